#include "mien/eyewear/light_drift.h"

#include <algorithm>
#include <cmath>

#include "mien/eyewear/light_grid.h"
#include "mien/eyewear/normalisation.h"

namespace mien::eyewear {
namespace {

/// Ten seconds of the grid and this speed are those of shaping::Resting; neither was tuned for light.
constexpr std::size_t kEnoughValues = 600;
constexpr double kSlew_per_s = 0.02;

}  // namespace

LightDrift::LightDrift(const sensor::Rig& rig) {
  for (const std::uint16_t number : photo_sensors(rig)) {
    if (rig.sensors[number].recentre) followed_.push_back(drifted_.size());
    drifted_.push_back(0);
  }
  seen_.resize(followed_.size());
}

void LightDrift::apply(double since_s, LightFrame& features) {
  constexpr auto kLimit = static_cast<float>(SensorNormalisation::kLimit);
  for (std::size_t i = 0; i < followed_.size(); ++i) {
    const std::size_t s = followed_[i];
    if (features.present[s] == 0) continue;
    StreamingMode& seen = seen_[i];
    seen.add((features.values[s] + 1) / 2);
    if (seen.count() >= kEnoughValues) {
      const double rest = 2 * seen.mode() - 1;
      const double most = kSlew_per_s * since_s;
      if (std::abs(rest) <= kMost)
        drifted_[s] += static_cast<float>(std::clamp(rest - double{drifted_[s]}, -most, most));
    }
    features.values[s] = std::clamp(features.values[s] - drifted_[s], -kLimit, kLimit);
  }
}

void LightDrift::reset() {
  for (StreamingMode& seen : seen_) seen.reset();
  std::ranges::fill(drifted_, 0.0F);
}

}  // namespace mien::eyewear
