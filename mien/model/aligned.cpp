#include "mien/model/aligned.h"

#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace mien::model {
namespace {

constexpr std::size_t kAlignment = 128;
constexpr std::size_t kHugePage = std::size_t{2} << 20;

}  // namespace

void* allocate_aligned(std::size_t bytes) {
  const std::size_t alignment = bytes >= kHugePage ? kHugePage : kAlignment;
  const std::size_t whole = (bytes + alignment - 1) / alignment * alignment;
  void* memory = std::aligned_alloc(alignment, whole);
  if (memory == nullptr) throw std::bad_alloc();
#if defined(__linux__)
  // A wish: without huge pages it is only a little slower.
  if (alignment == kHugePage) static_cast<void>(madvise(memory, whole, MADV_HUGEPAGE));
#endif
  return memory;
}

void free_aligned(void* memory) {
  std::free(memory);
}

}  // namespace mien::model
