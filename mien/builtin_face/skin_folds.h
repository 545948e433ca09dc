#pragma once

#include "mien/builtin_face/builtin_face.h"
#include "mien/face/skin_folds.h"

namespace mien::builtin_face {

/// How a person's skin wrinkles, by age: young skin takes up more before it folds, old skin is folded at
/// rest. For pictures. Chosen by eye.
[[nodiscard]] face::SkinFolds skin_folds(const BuiltinParameters& parameters);

}  // namespace mien::builtin_face
