#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace mien {

/// What stands on a wire as a number. Not bool: a byte of 2 is no bool; read a std::uint8_t and judge it.
template <class T>
concept WireNumber = (std::integral<T> && !std::same_as<std::remove_cv_t<T>, bool>) ||
                     std::same_as<T, float> || std::same_as<T, double>;

/// Reads numbers from the front of a buffer. Past its end every read gives zero and ok() turns false for
/// good, so a parser reads its whole record and asks once. Numbers on our own wire are little-endian.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <WireNumber T>
  T little() {
    return read<T>(std::endian::native != std::endian::little);
  }
  template <WireNumber T>
  T big() {
    return read<T>(std::endian::native != std::endian::big);
  }
  /// The next `count` bytes, or none (and ok() false) when fewer are left.
  std::span<const std::byte> take(std::size_t count) {
    if (count > bytes_.size()) {
      ok_ = false;
      bytes_ = {};
      return {};
    }
    const auto front = bytes_.first(count);
    bytes_ = bytes_.subspan(count);
    return front;
  }
  [[nodiscard]] std::size_t left() const { return bytes_.size(); }
  [[nodiscard]] bool ok() const { return ok_; }

 private:
  template <class T>
  T read(bool swap) {
    const auto source = take(sizeof(T));
    if (source.empty()) return T{};
    std::array<std::byte, sizeof(T)> raw;
    for (std::size_t i = 0; i < sizeof(T); ++i) raw[i] = source[swap ? sizeof(T) - 1 - i : i];
    return std::bit_cast<T>(raw);
  }

  std::span<const std::byte> bytes_;
  bool ok_ = true;
};

/// Appends numbers to a buffer that it owns.
class ByteWriter {
 public:
  template <WireNumber T>
  void little(T value) {
    put(value, std::endian::native != std::endian::little);
  }
  template <WireNumber T>
  void big(T value) {
    put(value, std::endian::native != std::endian::big);
  }
  void append(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  void append(std::string_view text) { append(std::as_bytes(std::span(text))); }
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }
  [[nodiscard]] std::vector<std::byte> release() { return std::move(bytes_); }
  void clear() { bytes_.clear(); }

 private:
  template <class T>
  void put(T value, bool swap) {
    const auto raw = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
    for (std::size_t i = 0; i < sizeof(T); ++i) bytes_.push_back(raw[swap ? sizeof(T) - 1 - i : i]);
  }
  std::vector<std::byte> bytes_;
};

/// CRC-32 (IEEE 802.3, reflected, start and end value all ones). "123456789" gives 0xCBF43926.
[[nodiscard]] std::uint32_t crc32(std::span<const std::byte> bytes);

/// The bytes as characters; valid while they are.
[[nodiscard]] inline std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace mien
