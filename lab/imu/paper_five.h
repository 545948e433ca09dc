#pragma once

#include <array>
#include <string_view>

namespace mien::lab {

/// CAPUS's "Fewer IMU" (arXiv:2402.03944v4, Evaluations on Facial Capture): brows, cheeks and jaw, by the
/// names of rigs/default.toml. Which of its two sites of the cheeks it keeps it does not say: here the lower.
inline constexpr std::array<std::string_view, 5> kPaperFive = {
    "frontalis_R", "frontalis_L", "zygomaticus_lower_R", "zygomaticus_lower_L", "mentalis"};

/// The same with the upper site of the cheeks.
inline constexpr std::array<std::string_view, 5> kPaperFiveUpper = {
    "frontalis_R", "frontalis_L", "zygomaticus_upper_R", "zygomaticus_upper_L", "mentalis"};

}  // namespace mien::lab
