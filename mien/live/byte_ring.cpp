#include "mien/live/byte_ring.h"

namespace mien::live {
namespace {

constexpr std::size_t kHead = sizeof(std::uint32_t);

/// Records' lengths stand at multiples of eight.
constexpr std::size_t rounded(std::size_t size) {
  return (size + kHead + 7) / 8 * 8;
}

}  // namespace

ByteRing::ByteRing(std::size_t size)
    : bytes_(std::make_unique_for_overwrite<std::byte[]>(size)), size_(size) {}

std::span<std::byte> ByteRing::claim(std::size_t size) {
  const std::size_t whole = rounded(size);
  if (whole > size_ / 4) return {};
  const std::size_t at = written_.load(std::memory_order_relaxed);
  const std::size_t used = at - read_.load(std::memory_order_acquire);
  if (used == 0) origin_ = at;
  const std::size_t place = place_of(at);
  const std::size_t skipped = place + whole > size_ ? size_ - place : 0;
  if (used + skipped + whole > size_) return {};
  if (skipped > 0) std::memcpy(bytes_.get() + place, &kSkip, kHead);
  const std::size_t begin = skipped > 0 ? 0 : place;
  const auto length = static_cast<std::uint32_t>(size);
  std::memcpy(bytes_.get() + begin, &length, kHead);
  claimed_ = skipped + whole;
  return {bytes_.get() + begin + kHead, size};
}

void ByteRing::publish() {
  written_.store(written_.load(std::memory_order_relaxed) + claimed_, std::memory_order_release);
  claimed_ = 0;
}

std::span<const std::byte> ByteRing::front() {
  for (;;) {
    const std::size_t at = read_.load(std::memory_order_relaxed);
    if (at == written_.load(std::memory_order_acquire)) return {};
    const std::size_t place = place_of(at);
    std::uint32_t length = 0;
    std::memcpy(&length, bytes_.get() + place, kHead);
    if (length != kSkip) return {bytes_.get() + place + kHead, length};
    read_.store(at + (size_ - place), std::memory_order_release);
  }
}

void ByteRing::release() {
  const std::size_t at = read_.load(std::memory_order_relaxed);
  std::uint32_t length = 0;
  std::memcpy(&length, bytes_.get() + place_of(at), kHead);
  read_.store(at + rounded(length), std::memory_order_release);
}

}  // namespace mien::live
