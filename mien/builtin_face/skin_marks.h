#pragma once

#include "mien/builtin_face/builtin_face.h"
#include "mien/face/skin_marks.h"

namespace mien::builtin_face {

/// Freckles, moles and stubble of a person, for pictures and textures. `face` is what make_builtin made of
/// these parameters. Fair skin has freckles, most where hair is red; moles lie where asymmetry_seed puts
/// them, none where it is 0; stubble goes by `beard`. How much of them was chosen by eye.
[[nodiscard]] face::SkinMarks skin_marks(const BuiltinParameters& parameters, const face::Face& face);

/// How a person's skin wrinkles, by age: young skin takes up more before it folds, old skin is folded at
/// rest. For pictures. Chosen by eye.
[[nodiscard]] face::SkinFolds skin_folds(const BuiltinParameters& parameters);

}  // namespace mien::builtin_face
