#include "mien/headset/answer.h"

#include <algorithm>
#include <string>

namespace mien::headset {
namespace {

constexpr float kWidest_rad = 0.7F, kWidestOpen = 1.5F;
constexpr float kMiddlePupil_mm = 4.5F, kHalfPupil_mm = 3.5F;

float to_unit(float share) {
  return 2 * share - 1;
}
float from_unit(float output) {
  return std::clamp(0.5F * (output + 1), 0.0F, 1.0F);
}

}  // namespace

void encode_answer(const Answer& answer, std::span<float, kAnswerOutputs> out) {
  for (std::size_t k = 0; k < face::kShapeCount; ++k) out[k] = to_unit(answer.weights[k]);
  out[kTongueOutput] = to_unit(answer.tongue_out);
  for (std::size_t i = 0; i < 4; ++i) out[kGazeOutput + i] = answer.gaze_rad[i] / kWidest_rad;
  for (std::size_t e = 0; e < 2; ++e) {
    out[kOpennessOutput + e] = to_unit(std::min(answer.openness[e], kWidestOpen) / kWidestOpen);
    out[kPupilOutput + e] = (answer.pupil_mm[e] - kMiddlePupil_mm) / kHalfPupil_mm;
  }
}

Answer decode_answer(std::span<const float, kAnswerOutputs> outputs) {
  Answer answer;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) answer.weights[k] = from_unit(outputs[k]);
  answer.tongue_out = from_unit(outputs[kTongueOutput]);
  for (std::size_t i = 0; i < 4; ++i)
    answer.gaze_rad[i] = kWidest_rad * std::clamp(outputs[kGazeOutput + i], -1.5F, 1.5F);
  for (std::size_t e = 0; e < 2; ++e) {
    answer.openness[e] = kWidestOpen * from_unit(outputs[kOpennessOutput + e]);
    answer.pupil_mm[e] = kMiddlePupil_mm + kHalfPupil_mm * std::clamp(outputs[kPupilOutput + e], -1.0F, 1.0F);
  }
  return answer;
}

const std::array<std::size_t, kAnswerOutputs>& mirrored_outputs() {
  static const std::array<std::size_t, kAnswerOutputs> kMirrored = [] {
    std::array<std::size_t, kAnswerOutputs> places{};
    for (std::size_t i = 0; i < kAnswerOutputs; ++i) places[i] = i;
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      std::string name(face::kShapeNames[k]);
      if (name.ends_with("_L"))
        name.back() = 'R';
      else if (name.ends_with("_R"))
        name.back() = 'L';
      else if (name == "jawLeft" || name == "mouthLeft")
        name.replace(name.size() - 4, 4, "Right");
      else if (name == "jawRight" || name == "mouthRight")
        name.replace(name.size() - 5, 5, "Left");
      places[k] = face::shape_index(name);
    }
    std::swap(places[kGazeOutput], places[kGazeOutput + 2]);
    std::swap(places[kGazeOutput + 1], places[kGazeOutput + 3]);
    std::swap(places[kOpennessOutput], places[kOpennessOutput + 1]);
    std::swap(places[kPupilOutput], places[kPupilOutput + 1]);
    return places;
  }();
  return kMirrored;
}

bool mirrors_sign(std::size_t output) {
  return output == kGazeOutput || output == kGazeOutput + 2;
}

}  // namespace mien::headset
