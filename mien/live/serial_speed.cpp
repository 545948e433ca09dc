#include "mien/live/serial_speed.h"

// The kernel's own termios, which says rates as numbers; <termios.h> must not be seen beside it.
#include <asm/termbits.h>
#include <sys/ioctl.h>

#include <cerrno>

namespace mien::live {

int set_serial_speed(int descriptor, std::uint32_t baud) {
  termios2 line{};
  if (::ioctl(descriptor, TCGETS2, &line) != 0) return errno;
  line.c_cflag &= ~static_cast<tcflag_t>(CBAUD | (CBAUD << IBSHIFT) | CSIZE | CSTOPB | PARENB | CRTSCTS);
  line.c_cflag |= BOTHER | CS8;
  line.c_iflag &= ~static_cast<tcflag_t>(IXON | IXOFF);
  line.c_ispeed = baud;
  line.c_ospeed = baud;
  return ::ioctl(descriptor, TCSETS2, &line) == 0 ? 0 : errno;
}

}  // namespace mien::live
