#include "mien/speech/articulator.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mien/core/minimum_jerk.h"

namespace mien::speech {
namespace {

using face::shape;

/// The pull of rest. This, the core, and the times of lips are ours, tuned on nothing.
constexpr float kRest = 0.05F;
/// Share of a sound's length on either side of its middle in which it has its whole influence.
constexpr double kCore = 0.3;
/// Beyond so many sigmas a bell is nothing.
constexpr double kReach = 3.5;

/// Lips come together in this time, and part in this.
constexpr double kClosing_s = 0.050, kOpening_s = 0.060;
/// Lips part with the burst, which is the last quarter of a sound as aligners cut it.
constexpr double kBurst = 0.75;
/// They meet before it by half of the sound before, within these (Rhubarb's rule).
constexpr double kShortestHold_s = 0.040, kLongestHold_s = 0.120;

/// Shapes that part the lips, which a closure takes back.
constexpr std::array kPartLips = {shape("mouthLowerDown_L"), shape("mouthLowerDown_R"),
                                  shape("mouthUpperUp_L"), shape("mouthUpperUp_R"), shape("mouthFunnel")};

double bell(double away_s, double sigma_s) {
  return away_s < kReach * sigma_s ? std::exp(-0.5 * (away_s / sigma_s) * (away_s / sigma_s)) : 0;
}

/// 0 to 1: how far the lips are brought together by a sound that closes them, after one of `before_s`.
double closure_at(double time_s, const TimedSound& sound, double before_s) {
  const double part_s = sound.begin_s + kBurst * (sound.end_s - sound.begin_s);
  const double meet_s =
      std::min(sound.begin_s, part_s - std::clamp(0.5 * before_s, kShortestHold_s, kLongestHold_s));
  if (time_s < meet_s) return minimum_jerk(1 - (meet_s - time_s) / kClosing_s);
  return 1 - minimum_jerk((time_s - part_s) / kOpening_s);
}

}  // namespace

void close_lips(float closure, face::BlendshapeWeights& weights) {
  for (const std::size_t k : kPartLips) weights[k] *= 1 - closure;
  weights[shape("mouthClose")] = closure * weights[shape("jawOpen")];
}

Mouth Articulator::at(double time_s, std::span<const TimedSound> sounds) const {
  Mouth mouth;
  float jaw_pull = kRest, lip_pull = kRest;
  double closure = 0;
  for (std::size_t i = 0; i < sounds.size(); ++i) {
    const TimedSound& sound = sounds[i];
    double begin_s = sound.begin_s;
    for (const VisemePart& part : sound.parts) {
      const Viseme& viseme = (*visemes_)[part.viseme];
      const double length_s = part.share * (sound.end_s - sound.begin_s);
      const double away_s = time_s - (begin_s + 0.5 * length_s);
      begin_s += length_s;
      const double outside_s = std::max(0.0, std::abs(away_s) - kCore * length_s);
      const auto there = static_cast<float>(bell(outside_s, away_s < 0 ? viseme.onset_s : viseme.release_s));
      const float jaw = there * viseme.jaw, lips = there * viseme.lips;
      jaw_pull += jaw;
      lip_pull += lips;
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        mouth.weights[k] += (k == shape("jawOpen") ? jaw : lips) * viseme.weights[k];
      mouth.tongue += lips * viseme.tongue;
      if (viseme.closes) {
        const double before_s = i > 0 ? sounds[i - 1].end_s - sounds[i - 1].begin_s : 0;
        closure = std::max(closure, closure_at(time_s, sound, before_s));
      }
    }
  }
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    mouth.weights[k] /= k == shape("jawOpen") ? jaw_pull : lip_pull;
  mouth.tongue /= lip_pull;
  mouth.closure = static_cast<float>(closure);
  close_lips(mouth.closure, mouth.weights);
  return mouth;
}

}  // namespace mien::speech
