#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/sensor/rig.h"

namespace mien::lab {

/// The rig as somebody wears it who leaves the other face sensors away: these alone, in the rig's order, with
/// all that are not the face's, and of the `[skin]` table what it says of them (the marginal of a normal
/// distribution). Whoever tells headings by the skin then knows no more than they feel. Errors: not_found (a
/// name that is none of the face's), bad_usage (none is named).
[[nodiscard]] Result<sensor::Rig> rig_with_sensors(const sensor::Rig& rig,
                                                   std::span<const std::string> names);

/// CAPUS's "Fewer IMU" (arXiv:2402.03944v4, Evaluations on Facial Capture): brows, cheeks and jaw, by the
/// names of rigs/default.toml. Which of its two sites of the cheeks it keeps it does not say: here the lower.
inline constexpr std::array<std::string_view, 5> kPaperFive = {
    "frontalis_R", "frontalis_L", "zygomaticus_lower_R", "zygomaticus_lower_L", "mentalis"};

/// The same with the upper site of the cheeks.
inline constexpr std::array<std::string_view, 5> kPaperFiveUpper = {
    "frontalis_R", "frontalis_L", "zygomaticus_upper_R", "zygomaticus_upper_L", "mentalis"};

}  // namespace mien::lab
