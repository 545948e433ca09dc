#pragma once

#include <filesystem>
#include <string>

#include "mien/live/phone_lesson.h"

namespace mien::app {

/// How a session learns its wearer from a phone: prompts/learn_phone.toml, and what `mien personalise --truth
/// phone` does. `model`: the session's live model, or folder of models. `face`: whose skin counts, as
/// builtin_face::load_face takes it.
[[nodiscard]] live::PhoneLesson::Settings phone_teacher(const std::filesystem::path& model,
                                                        const std::string& face);

}  // namespace mien::app
