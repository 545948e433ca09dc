#pragma once

#include <atomic>
#include <cstddef>
#include <memory>

namespace mien::live {

/// A queue of fixed size between one thread that writes and one that reads. No lock, no allocation after
/// construction. A full ring refuses: whoever writes counts what it could not say.
template <class T>
class Ring {
 public:
  /// `size` a power of two.
  explicit Ring(std::size_t size) : slots_(std::make_unique<T[]>(size)), mask_(size - 1) {}

  /// The slot to fill, or none when the ring is full; publish() then hands it over. Writer's thread.
  [[nodiscard]] T* claim() {
    const std::size_t at = written_.load(std::memory_order_relaxed);
    if (at - read_.load(std::memory_order_acquire) > mask_) return nullptr;
    return &slots_[at & mask_];
  }
  void publish() { written_.store(written_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

  /// The oldest, or none; it stays valid until release(). Reader's thread.
  [[nodiscard]] T* front() {
    const std::size_t at = read_.load(std::memory_order_relaxed);
    if (at == written_.load(std::memory_order_acquire)) return nullptr;
    return &slots_[at & mask_];
  }
  void release() { read_.store(read_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

 private:
  std::unique_ptr<T[]> slots_;
  std::size_t mask_;
  alignas(64) std::atomic<std::size_t> written_ = 0;
  alignas(64) std::atomic<std::size_t> read_ = 0;
};

}  // namespace mien::live
