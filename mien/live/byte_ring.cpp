#include "mien/live/byte_ring.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

namespace mien::live {
namespace {

constexpr std::size_t kHead = sizeof(std::uint32_t);
/// So much is given back at once, a few calls a second of four cameras.
constexpr std::size_t kGivenBack = std::size_t{1} << 18;

/// Records begin at multiples of eight, so that what stands in them may be read in place.
constexpr std::size_t rounded(std::size_t size) {
  return (size + kHead + 7) / 8 * 8;
}

}  // namespace

ByteRing::ByteRing(std::size_t size, Memory memory)
    : bytes_(memory == Memory::at_once ? std::make_unique<std::byte[]>(size)
                                       : std::make_unique_for_overwrite<std::byte[]>(size)),
      size_(size),
      memory_(memory) {}

std::span<std::byte> ByteRing::claim(std::size_t size) {
  const std::size_t whole = rounded(size);
  if (whole > size_ / 4) return {};
  const std::size_t at = written_.load(std::memory_order_relaxed);
  const std::size_t used = at - read_.load(std::memory_order_acquire);
  const std::size_t place = at & (size_ - 1);
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
    const std::size_t place = at & (size_ - 1);
    std::uint32_t length = 0;
    std::memcpy(&length, bytes_.get() + place, kHead);
    if (length != kSkip) return {bytes_.get() + place + kHead, length};
    read_.store(at + (size_ - place), std::memory_order_release);
  }
}

void ByteRing::release() {
  const std::size_t at = read_.load(std::memory_order_relaxed);
  std::uint32_t length = 0;
  std::memcpy(&length, bytes_.get() + (at & (size_ - 1)), kHead);
  const std::size_t end = at + rounded(length);
  if (memory_ == Memory::when_used && end - given_back_ >= kGivenBack) give_back(end);
  read_.store(end, std::memory_order_release);
}

void ByteRing::give_back(std::size_t end) {
  static const auto kPage = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  while (given_back_ < end) {
    const std::size_t place = given_back_ & (size_ - 1);
    const std::size_t length = std::min(end - given_back_, size_ - place);
    // Whole pages alone: the others may hold what is still to be read, or somebody else's.
    const auto address = reinterpret_cast<std::uintptr_t>(bytes_.get()) + place;
    const std::uintptr_t first = (address + kPage - 1) / kPage * kPage;
    const std::uintptr_t last = (address + length) / kPage * kPage;
    if (first < last) ::madvise(reinterpret_cast<void*>(first), last - first, MADV_DONTNEED);
    const bool at_end = place + length == size_;
    if (!at_end && last <= address) return;  // Not a page yet.
    given_back_ += at_end ? length : last - address;
    if (!at_end) return;
  }
}

}  // namespace mien::live
