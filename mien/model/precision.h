#pragma once

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

/// "fp32", "bf16", "int8".
[[nodiscard]] std::string_view precision_name(Precision precision);
[[nodiscard]] std::optional<Precision> precision_from_name(std::string_view name);

}  // namespace mien::model
