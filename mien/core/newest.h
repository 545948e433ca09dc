#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace mien {

/// The newest N values of a series, each by how many came after it. No allocation but the values' own.
template <class Value, std::size_t N>
class Newest {
 public:
  Newest() = default;
  /// `every`: what the places of values hold until these come.
  explicit Newest(const Value& every) { values_.fill(every); }
  /// The place of the next value, which still holds one that is forgotten.
  Value& push() { return values_[count_++ % N]; }
  void push(const Value& value) { push() = value; }
  /// Takes the newest one back; not empty. What it replaced stays lost: push again before asking for the
  /// oldest.
  void pop() { --count_; }
  void clear() { count_ = 0; }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] std::size_t size() const { return std::min(count_, N); }
  /// `back` before the newest, below size().
  [[nodiscard]] Value& operator[](std::size_t back) { return values_[(count_ - 1 - back) % N]; }
  [[nodiscard]] const Value& operator[](std::size_t back) const { return values_[(count_ - 1 - back) % N]; }

 private:
  std::array<Value, N> values_{};
  std::size_t count_ = 0;  // So far.
};

}  // namespace mien
