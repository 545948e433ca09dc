#include "mien/session/prompt_watch.h"

#include <algorithm>
#include <string_view>

namespace mien::session {
namespace {

/// Less than this of a text was hardly shown.
constexpr std::size_t kLeastFrames = 30;

/// Microphones.
constexpr std::string_view kHears = "speech";

bool moves_alone(std::string_view shape) {
  return shape.starts_with("eyeBlink") || shape.starts_with("eyeLook");
}

}  // namespace

void PromptWatch::clear(DeviceTime begin) {
  begin_ = begin;
  frames_ = 0;
  std::ranges::fill(missing_, Missing());
  least_.values.fill(1);
  most_.values.fill(0);
}

void PromptWatch::add_weights(const face::BlendshapeWeights& weights) {
  ++frames_;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    least_[k] = std::min(least_[k], weights[k]);
    most_[k] = std::max(most_[k], weights[k]);
  }
}

std::vector<std::string> PromptWatch::poor(const Prompt& prompt, const sensor::Rig& rig) const {
  std::vector<std::string> out;
  if (frames_ < kLeastFrames) {
    out.emplace_back("it was over at once");
    return out;
  }
  const double most = kMostMissing * static_cast<double>(frames_);
  for (std::size_t i = 0; i < std::min(missing_.size(), rig.sensors.size()); ++i) {
    const sensor::Mount& sensor = rig.sensors[i];
    if (sensor.kind == kHears)
      continue;  // Whoever makes a face says nothing, and sound is not always agreed to.
    if (static_cast<double>(missing_[i].lost) > most) out.push_back(sensor.name + " was lost");
    if (static_cast<double>(missing_[i].no_face) > most) out.push_back(sensor.name + " saw no face");
  }
  const bool asked = !prompt.text.empty() || prompt.target != face::BlendshapeWeights();
  float moved = 0;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (prompt.target[k] > 0 || !moves_alone(face::kShapeNames[k]))
      moved = std::max(moved, most_[k] - least_[k]);
  if (asked && moved < kLeastMoved) out.emplace_back("nothing moved");
  return out;
}

}  // namespace mien::session
