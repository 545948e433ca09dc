#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace mien::live {

/// As Ring, of records of any length: one thread writes, one reads. A record that does not fit is refused
/// whole. No lock, no allocation after construction.
class ByteRing {
 public:
  /// When a ring's memory is taken from the machine: at once, so that no page is missing on the way of a
  /// frame; or while records wait in it, for a large ring that a session hardly ever fills. Behind what was
  /// released its pages go back.
  enum class Memory : std::uint8_t { at_once, when_used };
  /// `size` a power of two; a record may have up to a quarter of it.
  explicit ByteRing(std::size_t size, Memory memory = Memory::at_once);

  /// Room for a record of `size` bytes, or an empty span when there is none now; publish() hands it over.
  [[nodiscard]] std::span<std::byte> claim(std::size_t size);
  void publish();

  /// The oldest record, empty when there is none; it stays valid until release().
  [[nodiscard]] std::span<const std::byte> front();
  void release();

 private:
  /// Gives the pages back that lie before `end`, a position as read_ is one. They may be written again once
  /// read_ says so.
  void give_back(std::size_t end);

  static constexpr std::uint32_t kSkip = 0xFFFFFFFF;  // The rest of the ring is left out.
  std::unique_ptr<std::byte[]> bytes_;
  std::size_t size_;
  Memory memory_;
  std::size_t claimed_ = 0;  // Bytes that publish() hands over.
  alignas(64) std::atomic<std::size_t> written_ = 0;
  alignas(64) std::atomic<std::size_t> read_ = 0;
  std::size_t given_back_ = 0;  // Up to this position; the reader's.
};

}  // namespace mien::live
