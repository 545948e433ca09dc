#include "mien/builtin_face/skin_folds.h"

#include <algorithm>

#include "mien/builtin_face/anatomy.h"

namespace mien::builtin_face {

face::SkinFolds skin_folds(const BuiltinParameters& parameters) {
  const double age = std::clamp(parameters.age_years, 18.0, 90.0);
  const double slack = age < 45 ? mix(-0.04, 0.0, (age - 18) / 27) : mix(0.0, 0.07, (age - 45) / 45);
  return {.depth = static_cast<float>(mix(0.5, 0.85, smoothstep(25, 75, age))),
          .slack = static_cast<float>(slack)};
}

}  // namespace mien::builtin_face
