#pragma once

#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/corrective.h"
#include "mien/face/face.h"
#include "mien/face/skin_marks.h"

namespace mien::app {

/// What --face offers, for its help.
inline constexpr const char* kFaceHelp =
    "builtin, one of its family by a performer's name or a seed, with values of its own (builtin:ada, "
    "builtin:7, "
    "builtin:ada,age_years=70), a folder with generic_neutral_mesh.obj, or a .glb, .gltf or .vrm file";

/// The face that --face names. Says on stderr which values of a person were beyond what people have. Errors:
/// builtin_face::load_face's.
[[nodiscard]] Result<face::Face> chosen_face(const std::string& what, const Progress& progress = no_progress);

/// Shown while chosen_face(what) reads files for long; of a built-in face nothing, so that Ctrl-C ends at
/// once what is made of it.
[[nodiscard]] Progress face_progress(const std::string& what);

/// chosen_face(what) with the colours that it has at 850 nm. Errors: its, unsupported (no built-in face:
/// nobody knows these of another one).
[[nodiscard]] Result<face::Face> chosen_infrared_face(const std::string& what);

/// What pictures of `face`, which is chosen_face(what), add where shapes meet: none but for the built-in
/// ones. Errors: chosen_face's.
[[nodiscard]] Result<std::vector<face::Corrective>> correctives_of(const std::string& what,
                                                                   const face::Face& face);

/// How the skin of chosen_face(what) wrinkles: not at all but for the built-in ones. Errors: chosen_face's.
[[nodiscard]] Result<face::SkinFolds> skin_folds_of(const std::string& what);

/// Freckles, moles and stubble of `face`, which is chosen_face(what): none but of the built-in ones. Errors:
/// chosen_face's.
[[nodiscard]] Result<face::SkinMarks> skin_marks_of(const std::string& what, const face::Face& face);

}  // namespace mien::app
