#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>

namespace mien::model {

/// Memory at an address that suits the widest SIMD (128 bytes). Of two megabytes and more it asks for huge
/// pages, where the system gives them. Throws std::bad_alloc.
[[nodiscard]] void* allocate_aligned(std::size_t bytes);
void free_aligned(void* memory);

/// Numbers for the kernels, zero at first.
template <class T>
class Aligned {
 public:
  Aligned() = default;
  explicit Aligned(std::size_t size)
      : values_(static_cast<T*>(allocate_aligned(std::max<std::size_t>(size, 1) * sizeof(T)))), size_(size) {
    std::fill_n(values_.get(), size, T{});
  }
  [[nodiscard]] T* data() { return values_.get(); }
  [[nodiscard]] const T* data() const { return values_.get(); }
  [[nodiscard]] std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return values_[i]; }
  const T& operator[](std::size_t i) const { return values_[i]; }

 private:
  struct Free {
    void operator()(T* memory) const { free_aligned(memory); }
  };
  std::unique_ptr<T[], Free> values_;
  std::size_t size_ = 0;
};

using AlignedFloats = Aligned<float>;

}  // namespace mien::model
