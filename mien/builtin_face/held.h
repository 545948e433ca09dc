#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/builtin_face/builtin_face.h"

namespace mien::builtin_face {

/// A number of BuiltinParameters and between what people have it.
struct ParameterRange {
  std::string_view name;  ///< As the member is called.
  double BuiltinParameters::*value;
  double least, most;
};

/// All of them but the asymmetry's seed and the cut of hair; the identity numbers first.
[[nodiscard]] std::span<const ParameterRange> parameter_ranges();
inline constexpr std::size_t kIdentityNumbers = 33;

/// Every number within its range; NaN becomes the default's. `said`, where given, gets a line for each that
/// was not: "nose_width 7 is beyond what people have, held to 3".
[[nodiscard]] BuiltinParameters held(BuiltinParameters parameters, std::vector<std::string>* said = nullptr);

}  // namespace mien::builtin_face
