#include "mien/performer/mimic.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mien/core/time.h"
#include "mien/performer/blinks.h"
#include "mien/performer/canvas.h"
#include "mien/performer/limits.h"

namespace mien::performer {

using face::kShapeCount;
using face::shape;

namespace {

constexpr double kHoldS = 3;  // The hold that `slackening` refers to.
constexpr double kTremorHz = 1.5;

/// The performed answer to one cue.
struct Answer {
  double begin_s = 0;
  double ease_s = 0.5;
  double slackening = 0;
  face::BlendshapeWeights pose;
};

Answer answer(const PoseCue& cue, const Mimicry& mimicry, Random random) {
  Answer out;
  out.begin_s = cue.begin_s + random.uniform(mimicry.least_late_s, mimicry.most_late_s);
  out.ease_s = random.uniform(mimicry.least_ease_s, mimicry.most_ease_s);
  out.slackening = random.uniform(0, mimicry.slackening);
  bool asked = false;
  for (std::size_t k = 0; k < kShapeCount; ++k) {
    const double gain = random.uniform(mimicry.least_gain, mimicry.most_gain);
    out.pose[k] = static_cast<float>(gain * cue.target[k]);
    asked = asked || cue.target[k] > 0;
  }
  // A face at rest is at rest.
  if (!asked || mimicry.most_unasked < 1) return out;
  const auto unasked = 1 + random.below(static_cast<std::uint64_t>(mimicry.most_unasked));
  for (std::uint64_t i = 0; i < unasked;) {
    const std::size_t k = random.below(kShapeCount);
    const double weight = random.uniform(0, mimicry.unasked);
    if (is_driven_by_others(k)) continue;
    out.pose[k] += static_cast<float>(weight);
    ++i;
  }
  return out;
}

}  // namespace

face::Motion mimic(std::span<const PoseCue> cues, double end_s, const Mimicry& mimicry,
                   const Random& random) {
  std::vector<Answer> answers;
  for (std::size_t c = 0; c < cues.size(); ++c)
    answers.push_back(answer(cues[c], mimicry, random.fork("cue", c)));
  const std::vector<face::Blink> blinks =
      mimicry.blinks_per_min > 0 ? draw_blinks(end_s, mimicry.blinks_per_min, {}, random.fork("blinks"))
                                 : std::vector<face::Blink>();
  const auto frames = static_cast<std::size_t>(std::ceil(end_s * kFrameRateHz)) + 1;
  const std::vector<std::array<float, 2>> lids = lid_tracks(blinks, frames);
  Random unrest = random.fork("tremor");
  std::vector<SmoothNoise> tremor;
  for (std::size_t k = 0; k < kShapeCount; ++k) tremor.emplace_back(kTremorHz, unrest);

  face::Motion motion;
  motion.name = "mimicry";
  motion.frames.resize(frames);
  face::BlendshapeWeights from, now;
  std::size_t current = 0;  // Answers begun so far.
  for (std::size_t f = 0; f < frames; ++f) {
    face::MotionFrame& frame = motion.frames[f];
    frame.time_s = static_cast<double>(f) / kFrameRateHz;
    while (current < answers.size() && answers[current].begin_s <= frame.time_s) {
      from = now;
      ++current;
    }
    if (current > 0) {
      const Answer& to = answers[current - 1];
      const double since_s = frame.time_s - to.begin_s;
      const auto share = static_cast<float>(minimum_jerk(since_s / to.ease_s));
      const auto slack = static_cast<float>(1 - to.slackening * std::min(1.0, since_s / kHoldS));
      for (std::size_t k = 0; k < kShapeCount; ++k)
        now[k] = (1 - share) * from[k] + share * slack * to.pose[k];
    }
    frame.weights = now;
    for (std::size_t k = 0; k < kShapeCount; ++k) {
      const double shaken = mimicry.tremor * tremor[k].next(unrest);
      if (now[k] > 0) frame.weights[k] = std::max(0.0F, now[k] + static_cast<float>(shaken));
    }
    frame.weights[shape("eyeBlink_L")] = std::max(frame.weights[shape("eyeBlink_L")], lids[f][0]);
    frame.weights[shape("eyeBlink_R")] = std::max(frame.weights[shape("eyeBlink_R")], lids[f][1]);
    apply_limits(frame.weights, 0);
  }
  return motion;
}

}  // namespace mien::performer
