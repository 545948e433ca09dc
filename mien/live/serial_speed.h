#pragma once

#include <cstdint>

namespace mien::live {

/// Sets an open serial line to any rate: 250,000 bit/s has no name of its own in termios, and Asio knows only
/// those that have. Eight bits, no parity, one stop bit, no flow control. Returns 0, or errno.
[[nodiscard]] int set_serial_speed(int descriptor, std::uint32_t baud);

}  // namespace mien::live
