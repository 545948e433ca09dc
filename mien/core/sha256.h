#pragma once

#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <type_traits>

namespace mien {

/// SHA-256, fed piece by piece. Not thread-safe.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void add(std::span<const std::byte> bytes);
  /// The value's own bytes. Only types without padding, whose bytes are nothing but their value.
  template <class T>
  requires std::has_unique_object_representations_v<T> || std::same_as<T, float> || std::same_as<T, double>
  void add_value(const T& value) { add(std::as_bytes(std::span(&value, 1))); }
  /// 64 lower-case hexadecimal digits. Feed nothing afterwards.
  [[nodiscard]] std::string hex();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mien
