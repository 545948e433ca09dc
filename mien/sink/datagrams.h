#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace mien::sink {

/// The datagrams of one frame, one behind the other in storage that is kept: after the largest frame it
/// allocates no more.
class Datagrams {
 public:
  void clear() {
    bytes_.clear();
    starts_.clear();
  }
  /// What is appended from here on is a datagram of its own.
  void begin() { starts_.push_back(bytes_.size()); }
  void append(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  void append(std::string_view text) { append(std::as_bytes(std::span(text))); }
  /// A number as most protocols of this room write them: highest byte first.
  template <class T>
  requires std::integral<T> || std::floating_point<T>
  void big(T value) {
    const auto raw = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
    for (std::size_t i = 0; i < sizeof(T); ++i)
      bytes_.push_back(raw[std::endian::native == std::endian::big ? i : sizeof(T) - 1 - i]);
  }

  [[nodiscard]] std::size_t size() const { return starts_.size(); }
  [[nodiscard]] std::span<const std::byte> operator[](std::size_t i) const {
    const std::size_t end = i + 1 < starts_.size() ? starts_[i + 1] : bytes_.size();
    return std::span(bytes_).subspan(starts_[i], end - starts_[i]);
  }

 private:
  std::vector<std::byte> bytes_;
  std::vector<std::size_t> starts_;
};

}  // namespace mien::sink
