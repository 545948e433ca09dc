#include "mien/live/signal.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <system_error>

namespace mien::live {

Signal::Signal() : descriptor_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (descriptor_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
}

Signal::~Signal() {
  close(descriptor_);
}

void Signal::give() {
  const std::uint64_t one = 1;
  // A full counter is a signal too.
  [[maybe_unused]] const auto written = write(descriptor_, &one, sizeof(one));
}

void Signal::take() {
  std::uint64_t count = 0;
  [[maybe_unused]] const auto got = read(descriptor_, &count, sizeof(count));
}

void Signal::wait(Duration at_most) {
  const Duration length = std::max(at_most, Duration::zero());
  const timespec timeout{.tv_sec = length.count() / 1'000'000'000, .tv_nsec = length.count() % 1'000'000'000};
  pollfd waiting{.fd = descriptor_, .events = POLLIN, .revents = 0};
  if (ppoll(&waiting, 1, &timeout, nullptr) > 0) take();
}

}  // namespace mien::live
