#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "mien/core/random.h"

namespace mien::lab {

/// Under what speech is heard in studies.
inline constexpr std::array<std::string_view, 7> kSoundConditions = {
    "clean", "noise at 20 dB", "noise at 10 dB", "noise at 5 dB", "room", "20 dB quieter", "telephone"};

/// The sound, speech::kRateHz, as one of kSoundConditions has it.
[[nodiscard]] std::vector<float> disturbed(std::span<const float> sound, std::size_t condition,
                                           const Random& random);

}  // namespace mien::lab
