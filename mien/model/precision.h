#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace mien::model {

/// What a linear layer multiplies in. Sums, biases and everything between layers stay fp32.
enum class Precision {
  fp32,
  bf16,  ///< Weights and inputs rounded to 8 significant bits.
  /// Weights in 8 bits of their output channel's own scale, inputs in 8 bits of their row's, found as they
  /// come.
  int8,
};

inline constexpr std::array<std::string_view, 3> kPrecisionNames = {"fp32", "bf16", "int8"};
[[nodiscard]] constexpr std::string_view precision_name(Precision precision) {
  return kPrecisionNames[static_cast<std::size_t>(precision)];
}
[[nodiscard]] constexpr std::optional<Precision> precision_from_name(std::string_view name) {
  const auto found = std::ranges::find(kPrecisionNames, name);
  if (found == kPrecisionNames.end()) return std::nullopt;
  return static_cast<Precision>(found - kPrecisionNames.begin());
}

}  // namespace mien::model
