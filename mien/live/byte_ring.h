#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <utility>

namespace mien::live {

/// A queue of records of any length: one thread writes, one reads. A record that does not fit is refused
/// whole. A record that is claimed while nothing waits stands at the front of the ring's memory, so that one
/// which is emptied now and then touches only what came in between: the machine is asked for the rest of a
/// large ring only when it fills. No lock, no allocation after construction.
class ByteRing {
 public:
  /// `size` a power of two; a record may have up to a quarter of it.
  explicit ByteRing(std::size_t size);

  /// Room for a record of `size` bytes, or an empty span when there is none now; publish() hands it over.
  [[nodiscard]] std::span<std::byte> claim(std::size_t size);
  void publish();
  /// Both, for a record that begins with a plain struct. False when there is no room now.
  template <class Head>
  [[nodiscard]] bool put(const Head& head, std::span<const std::byte> bytes,
                         std::span<const std::byte> more = {}) {
    const std::span<std::byte> room = claim(sizeof(head) + bytes.size() + more.size());
    if (room.empty()) return false;
    std::memcpy(room.data(), &head, sizeof(head));
    std::ranges::copy(more, std::ranges::copy(bytes, room.begin() + sizeof(head)).out);
    publish();
    return true;
  }

  /// The oldest record, empty when there is none; it stays valid until release().
  [[nodiscard]] std::span<const std::byte> front();
  /// The same of one that put() wrote: its head, and what is behind it.
  template <class Head>
  [[nodiscard]] std::optional<std::pair<Head, std::span<const std::byte>>> front_of() {
    const std::span<const std::byte> record = front();
    if (record.empty()) return std::nullopt;
    Head head{};
    std::memcpy(&head, record.data(), sizeof(head));
    return std::pair(head, record.subspan(sizeof(head)));
  }
  void release();

 private:
  /// Where the record at a position, as written_ and read_ are, stands in bytes_.
  [[nodiscard]] std::size_t place_of(std::size_t at) const { return (at - origin_) & (size_ - 1); }

  static constexpr std::uint32_t kSkip = 0xFFFFFFFF;  // The rest of the ring is left out.
  std::unique_ptr<std::byte[]> bytes_;
  std::size_t size_;
  std::size_t claimed_ = 0;  // Bytes that publish() hands over.
  /// The position at the front of bytes_. The writer moves it while nothing waits; the reader looks at it
  /// only between a record's publish() and its own release(), which order both. A skip is published together
  /// with the record behind it, so front() never ends on one.
  std::size_t origin_ = 0;
  alignas(64) std::atomic<std::size_t> written_ = 0;
  alignas(64) std::atomic<std::size_t> read_ = 0;
};

}  // namespace mien::live
