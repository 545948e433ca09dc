#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

// A device on a serial line, without one: the machine's own pseudo-terminal.
namespace mien::live::test {

/// A line whose near end has one name for ever, as those in /dev/serial/by-id have, and whose far end is
/// plugged in and out.
class Cable {
 public:
  explicit Cable(std::filesystem::path name) : name_(std::move(name)) { plug(); }
  Cable(const Cable&) = delete;
  Cable& operator=(const Cable&) = delete;
  ~Cable() { unplug(); }

  void plug() {
    device_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    std::array<char, 128> near{};
    if (device_ < 0 || ::grantpt(device_) != 0 || ::unlockpt(device_) != 0 ||
        ::ptsname_r(device_, near.data(), near.size()) != 0) {
      ADD_FAILURE() << "no pseudo-terminal";
      return;
    }
    std::filesystem::create_symlink(near.data(), name_);
  }
  void unplug() {
    if (device_ < 0) return;
    std::error_code ignored;
    std::filesystem::remove(name_, ignored);
    ::close(device_);
    device_ = -1;
  }

  /// As much as the line takes now; returns how many bytes that were.
  std::size_t write(std::span<const std::byte> bytes) const {
    const ssize_t written = ::write(device_, bytes.data(), bytes.size());
    return written > 0 ? static_cast<std::size_t>(written) : 0;
  }
  [[nodiscard]] std::string address() const { return "serial:" + name_.string(); }

 private:
  std::filesystem::path name_;
  int device_ = -1;
};

}  // namespace mien::live::test
