#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "mien/face/profile.h"

namespace mien::headset {

/// What a network of pictures tells of a moment.
struct Answer {
  face::BlendshapeWeights weights;  ///< 0 to 1.
  float tongue_out = 0;             ///< 0 to 1.
  std::array<float, 4>
      gaze_rad{};  ///< Left eye's yaw to the performer's left and pitch upwards, right eye's.
  std::array<float, 2> openness{
      1, 1};  ///< Gap between the lids, left and right: 0 closed, 1 as at rest, to 1.5.
  std::array<float, 2> pupil_mm{4, 4};  ///< Diameters, 1 to 8.
};

/// Furthest that an eye looks from straight ahead, by yaw and by pitch each.
inline constexpr float kMostGaze_rad = 1.1F;

/// The outputs' places: 53 weights in the ICT profile's order, the tongue, then those below.
inline constexpr std::size_t kTongueOutput = face::kShapeCount;
inline constexpr std::size_t kGazeOutput = kTongueOutput + 1;
inline constexpr std::size_t kOpennessOutput = kGazeOutput + 4;
inline constexpr std::size_t kPupilOutput = kOpennessOutput + 2;
inline constexpr std::size_t kAnswerOutputs = kPupilOutput + 2;

/// To the network's range, nominally [-1, 1]: an angle of 0.7 rad is 1, an openness of 1.5, a pupil of 8 mm.
void encode_answer(const Answer& answer, std::span<float, kAnswerOutputs> out);
/// Back, held to what each can be.
[[nodiscard]] Answer decode_answer(std::span<const float, kAnswerOutputs> outputs);

/// Where an output of the mirrored face stands: left and right changed. Yaws change their sign too.
[[nodiscard]] const std::array<std::size_t, kAnswerOutputs>& mirrored_outputs();
/// Whether that output's sign changes.
[[nodiscard]] bool mirrors_sign(std::size_t output);

}  // namespace mien::headset
