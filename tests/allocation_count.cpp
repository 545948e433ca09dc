#include "tests/allocation_count.h"

#include <atomic>
#include <cstdlib>
#include <new>

#if defined(__SANITIZE_THREAD__)
#define MIEN_THREAD_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define MIEN_THREAD_SANITIZER 1
#endif
#endif

namespace {
std::atomic<std::size_t> allocations = 0;
}

#ifdef MIEN_THREAD_SANITIZER  // It has replaced operator new already, and calls whoever wants to know.
#include <sanitizer/allocator_interface.h>

std::size_t mien::test::allocation_count() {
  [[maybe_unused]] static const int installed = __sanitizer_install_malloc_and_free_hooks(
      [](const volatile void*, std::size_t) { ++allocations; }, [](const volatile void*) {});
  return allocations;
}

#else

// Not inlined: g++ would then see free() beside somebody else's new.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* const place = std::malloc(size)) return place;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* place) noexcept {
  std::free(place);
}
[[gnu::noinline]] void operator delete(void* place, std::size_t /*size*/) noexcept {
  std::free(place);
}

std::size_t mien::test::allocation_count() {
  return allocations;
}

#endif
