#include "mien/performer/recorded_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "mien/core/minimum_jerk.h"
#include "mien/core/time.h"
#include "mien/face/shape_region.h"
#include "mien/performer/canvas.h"

namespace mien::performer {

using face::BlendshapeWeights;
using face::kShapeCount;
using face::shape;

namespace {

constexpr double kFade_s = 0.4;
constexpr double kRestPercentile = 0.1;

/// Part of a recording that is played; or a rest, where the pose stays that of the clip's begin.
struct Clip {
  double begin_s = 0;     ///< In the performance.
  double length_s = 0;    ///< Likewise.
  std::size_t which = 0;  ///< Of the recordings.
  double from_s = 0;      ///< In the recording.
  double speed = 1;       ///< Recorded seconds a second.
  bool rests = false;
};

/// A recording that can be played, and the pose in which its face rests.
struct Playable {
  explicit Playable(const face::Motion& motion) : curve(motion) {
    std::array<std::vector<float>, kShapeCount> values;
    for (const face::MotionFrame& frame : motion.frames)
      if (frame.has_face)
        for (std::size_t k = 0; k < kShapeCount; ++k) values[k].push_back(frame.weights[k]);
    for (std::size_t k = 0; k < kShapeCount; ++k) {
      if (values[k].empty()) continue;
      const auto nth = values[k].begin() +
                       static_cast<std::ptrdiff_t>(kRestPercentile * static_cast<double>(values[k].size()));
      std::ranges::nth_element(values[k], nth);
      rest[k] = std::clamp(*nth, 0.0F, 1.0F);
    }
  }
  face::MotionCurve curve;
  BlendshapeWeights rest;
};

std::vector<Clip> draw_clips(std::span<const Playable> recordings, double duration_s, Random random) {
  std::vector<Clip> clips;
  const double rests = random.uniform(0, 0.3);
  for (double at_s = 0; at_s < duration_s;) {
    Clip clip{.begin_s = at_s, .which = random.below(recordings.size())};
    clip.speed = random.uniform(0.8, 1.25);
    clip.rests = random.chance(rests);
    clip.length_s = clip.rests ? random.uniform(1, 3) : random.uniform(3, 10);
    const double recorded_s = recordings[clip.which].curve.duration_s();
    clip.length_s = std::min(clip.length_s, std::max(1.0, recorded_s / clip.speed));
    clip.from_s = random.uniform(0, std::max(0.0, recorded_s - clip.speed * clip.length_s));
    at_s += clip.length_s;
    clips.push_back(clip);
  }
  return clips;
}

/// How a performance changes the shapes of each recording: out = rest + gain (in - recording's rest).
struct Change {
  BlendshapeWeights gain, rest;
};

Change draw_change(const Playable& recording, const Style& style, Random random) {
  Change change;
  const double all = random.log_normal(0.15);
  const double towards_style = random.chance(0.5) ? 0 : random.uniform();
  for (std::size_t k = 0; k < kShapeCount; ++k) {
    const std::size_t twin = other_side(k);
    const double by = twin < k ? random.log_normal(0.06) : random.log_normal(0.15);
    change.gain[k] = static_cast<float>(std::clamp(twin < k ? change.gain[twin] * by : all * by, 0.4, 2.0));
    // Eyes look where they look, and lips that seal an open jaw seal it.
    const bool kept = is_driven_by_others(k);
    if (kept) change.gain[k] = 1;
    const double other = style.rest[k] - recording.rest[k];
    change.rest[k] = recording.rest[k] + (kept ? 0.0F : static_cast<float>(towards_style * other));
  }
  return change;
}

/// One part of the face: clips, one after the other.
class Track {
 public:
  Track(std::span<const Playable> recordings, std::vector<Clip> clips, std::span<const Change> changes)
      : recordings_(recordings), clips_(std::move(clips)), changes_(changes) {}

  /// Moments in order.
  BlendshapeWeights at(double time_s, float& tongue_out) {
    while (now_ + 1 < clips_.size() && clips_[now_ + 1].begin_s <= time_s) ++now_;
    BlendshapeWeights weights = play(clips_[now_], time_s, tongue_out);
    const double into_s = time_s - clips_[now_].begin_s;
    if (now_ == 0 || into_s >= kFade_s) return weights;
    float tongue_before = 0;
    const BlendshapeWeights before = play(clips_[now_ - 1], time_s, tongue_before);
    const auto share = static_cast<float>(minimum_jerk(into_s / kFade_s));
    for (std::size_t k = 0; k < kShapeCount; ++k) weights[k] = before[k] + share * (weights[k] - before[k]);
    tongue_out = tongue_before + share * (tongue_out - tongue_before);
    return weights;
  }

 private:
  BlendshapeWeights play(const Clip& clip, double time_s, float& tongue_out) const {
    const Playable& recording = recordings_[clip.which];
    const Change& change = changes_[clip.which];
    if (clip.rests) {
      tongue_out = 0;
      return change.rest;
    }
    const face::MotionFrame frame = recording.curve.at(clip.from_s + clip.speed * (time_s - clip.begin_s));
    BlendshapeWeights out;
    for (std::size_t k = 0; k < kShapeCount; ++k)
      out[k] = change.rest[k] + change.gain[k] * (frame.weights[k] - recording.rest[k]);
    tongue_out = frame.tongue_out;
    return out;
  }

  std::span<const Playable> recordings_;
  std::vector<Clip> clips_;
  std::span<const Change> changes_;
  std::size_t now_ = 0;
};

bool is_upper(std::size_t k) {
  return face::kShapeRegions[k] == face::ShapeRegion::brows ||
         face::kShapeRegions[k] == face::ShapeRegion::eyes;
}

}  // namespace

BlendshapeWeights mirrored(const BlendshapeWeights& weights) {
  BlendshapeWeights out;
  for (std::size_t k = 0; k < kShapeCount; ++k) out[k] = weights[other_side(k)];
  for (const auto& [left, right] :
       {std::pair{shape("jawLeft"), shape("jawRight")}, std::pair{shape("mouthLeft"), shape("mouthRight")}}) {
    out[left] = weights[right];
    out[right] = weights[left];
  }
  return out;
}

face::Motion perform_recorded(std::span<const face::Motion> recordings, double duration_s, const Style& style,
                              const Random& random) {
  const std::vector<Playable> playable(recordings.begin(), recordings.end());
  Random choices = random.fork("choices");
  const bool mirror = choices.chance(0.5), apart = choices.chance(0.5);
  std::vector<Change> changes;
  for (std::size_t r = 0; r < playable.size(); ++r)
    changes.push_back(draw_change(playable[r], style, random.fork("change", r)));
  Track lower(playable, draw_clips(playable, duration_s, random.fork("lower")), changes);
  Track upper(playable, draw_clips(playable, duration_s, random.fork(apart ? "upper" : "lower")), changes);

  face::Motion motion;
  motion.name = "recorded";
  const auto frame_count = static_cast<std::size_t>(std::max(1.0, std::round(duration_s * kFrameRateHz)));
  for (std::size_t i = 0; i < frame_count; ++i) {
    face::MotionFrame& frame = motion.frames.emplace_back();
    frame.time_s = to_seconds(frame_offset(static_cast<std::int64_t>(i)));
    frame.weights = lower.at(frame.time_s, frame.tongue_out);
    float tongue_of_upper = 0;
    const BlendshapeWeights eyes = upper.at(frame.time_s, tongue_of_upper);
    for (std::size_t k = 0; k < kShapeCount; ++k)
      frame.weights[k] = std::clamp(is_upper(k) ? eyes[k] : frame.weights[k], 0.0F, 1.0F);
    if (mirror) frame.weights = mirrored(frame.weights);
  }
  return motion;
}

}  // namespace mien::performer
