#include "mien/performer/performer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mien/performer/blinks.h"
#include "mien/performer/canvas.h"
#include "mien/performer/eating.h"
#include "mien/performer/expression.h"
#include "mien/performer/expression_range.h"
#include "mien/performer/free.h"
#include "mien/performer/gaze.h"
#include "mien/performer/limits.h"
#include "mien/performer/rapid.h"
#include "mien/performer/speech_articulation.h"

namespace mien::performer {

using face::BlendshapeWeights;
using face::kShapeCount;
using face::kShapeNames;
using face::shape;

namespace {

/// Neighbouring segments overlap by twice this.
constexpr std::size_t kOverlapFrames = 12;

/// By Emotion: active ones open the mouth and move the head, sadness takes both back.
constexpr Manner kUnmoved{0, 0, 0}, kRoused{0.3, 0.2, 0.8}, kTense{0.4, 0.3, 0.6}, kLow{-0.35, -0.3, -0.4};
constexpr std::array<Manner, kEmotionCount> kChanges = {kUnmoved, kRoused,  kLow,    kTense,
                                                        kTense,   kUnmoved, kRoused, kUnmoved};

Manner manner_of(const Segment& segment, const Style& style) {
  Manner manner{
      .loudness = style.articulation, .articulation = style.articulation, .prosody = style.head_liveliness};
  if (segment.block != Block::acted) {
    manner.prosody *= 0.6;  // Calm reading.
    return manner;
  }
  const double by = segment.intensity;
  const Manner& change = kChanges[static_cast<std::size_t>(segment.emotion)];
  manner = {manner.loudness * (1 + change.loudness * by),
            manner.articulation * (1 + change.articulation * by), manner.prosody * (1 + change.prosody * by)};
  manner.prosody = std::min(manner.prosody, 2.0);
  return manner;
}

void speak(Canvas& canvas, const Segment& segment, const Style& style, const Random& random) {
  Random words = random.fork("words");
  // The languages' rates are those of fluent reading; calm reading is slower, acted lines are not.
  const double rate = style.speech_rate * (segment.block == Block::acted ? 1.0 : 0.8);
  const Utterance drawn = segment.utterance
                              ? *segment.utterance
                              : random_utterance(segment.language, canvas.duration_s(), rate, words);
  perform_speech(canvas, drawn, manner_of(segment, style), style, random.fork("mouth"));
}

void perform_segment(Canvas& canvas, const Segment& segment, const Style& style, const Random& random) {
  switch (segment.block) {
    case Block::reading:
      speak(canvas, segment, style, random);
      break;
    case Block::acted:
      speak(canvas, segment, style, random);
      perform_emotion(canvas, segment.emotion, segment.intensity, style, random.fork("emotion"));
      break;
    case Block::expressions:
      perform_expressions(canvas, style, random.fork("expressions"));
      break;
    case Block::range_of_motion:
      perform_range_of_motion(canvas, style, random.fork("range"));
      break;
    case Block::eating:
      perform_eating(canvas, style, random.fork("eating"));
      break;
    case Block::rapid:
      perform_rapid(canvas, random.fork("rapid"));
      break;
    case Block::free:
    case Block::mixed:
      perform_free(canvas, random.fork("free"));
      break;
  }
}

GazeTask gaze_task(Block block, Random& random) {
  switch (block) {
    case Block::reading:
      return GazeTask::reading;
    case Block::acted:
      return GazeTask::conversation;
    case Block::expressions:
      return random.chance(0.7) ? GazeTask::conversation : GazeTask::still;
    case Block::range_of_motion:
      return random.chance(0.5) ? GazeTask::still : GazeTask::conversation;
    case Block::eating:
      return GazeTask::conversation;
    default:
      return random.chance(0.6) ? GazeTask::wandering : GazeTask::conversation;
  }
}

HeadActivity head_activity(Block block, Random& random) {
  switch (block) {
    case Block::reading:
    case Block::acted:
      return HeadActivity::talking;
    case Block::expressions:
      return random.chance(0.5) ? HeadActivity::still : HeadActivity::talking;
    case Block::range_of_motion:
      return random.chance(0.7) ? HeadActivity::still : HeadActivity::turning;
    case Block::eating:
      return random.chance(0.6) ? HeadActivity::still : HeadActivity::talking;
    case Block::rapid:
      return HeadActivity::darting;
    default:
      break;
  }
  const double which = random.uniform();
  return which < 0.25   ? HeadActivity::still
         : which < 0.40 ? HeadActivity::nodding
         : which < 0.70 ? HeadActivity::turning
         : which < 0.85 ? HeadActivity::talking
         : which < 0.96 ? HeadActivity::walking
                        : HeadActivity::running;
}

/// Applies a person's style to the canvas, frame by frame.
class Person {
 public:
  Person(const Style& style, const Random& random) : style_(style), random_(random.fork("tremor")) {
    if (style.micro_motion <= 0) return;
    tremor_.reserve(kShapeCount);
    for (std::size_t k = 0; k < kShapeCount; ++k) tremor_.emplace_back(1.5, random_);
  }

  /// Style, rest and tremor; not yet blinks, gaze and limits.
  BlendshapeWeights carry_out(BlendshapeWeights meant) {
    for (float& weight : meant.values) weight = std::clamp(weight, 0.0F, 1.4F);
    BlendshapeWeights done = meant;
    for (std::size_t k = 0; k < kShapeCount; ++k)
      done[k] += style_.side_leak[k] * std::max(0.0F, meant[other_side(k)] - meant[k]);
    for (const Habit& habit : style_.habits) done[habit.to] += habit.amount * meant[habit.from];
    for (std::size_t k = 0; k < kShapeCount; ++k) {
      done[k] *= style_.gain[k] * style_.expressiveness;
      done[k] += style_.rest[k] * (1 - std::min(1.0F, done[k]));
    }
    // A blink on purpose closes the eye whoever does it.
    for (const std::size_t k : {shape("eyeBlink_L"), shape("eyeBlink_R")})
      done[k] = std::max(done[k], std::min(1.0F, meant[k]) * style_.blink_peak);
    if (!tremor_.empty()) add_tremor(done);
    // Gestures that happen to coincide are still made by one muscle.
    if (moved_) {
      for (std::size_t k = 0; k < kShapeCount; ++k)
        done[k] = std::clamp(done[k], before_[k] - kFastest, before_[k] + kFastest);
    }
    before_ = done;
    moved_ = true;
    return done;
  }

 private:
  void add_tremor(BlendshapeWeights& weights) {
    float left = 0;
    for (std::size_t k = 0; k < kShapeCount; ++k) {
      auto now = static_cast<float>(tremor_[k].next(random_));
      // Sides tremble mostly together.
      if (other_side(k) > k) left = now;
      if (other_side(k) < k) now = 0.8F * left + 0.6F * now;
      weights[k] += style_.micro_motion * (1 + std::min(1.0F, weights[k])) * now;
    }
  }

  /// Weight a frame: a full blink that closes in 75 ms.
  static constexpr float kFastest = 0.42F;

  const Style& style_;
  Random random_;
  std::vector<SmoothNoise> tremor_;
  BlendshapeWeights before_;
  bool moved_ = false;
};

/// Lids, eyes and tongue of one frame.
void add_eyes(BlendshapeWeights& weights, const std::array<float, 2>& lids, Eigen::Vector2f direction_rad,
              float vergence_rad, const Style& style) {
  const float blink = 0.5F * (lids[0] + lids[1]);
  direction_rad.y() -= 0.05F * blink;  // Eyes dip while the lids are down (Bour et al. 2000).
  direction_rad = direction_rad.cwiseMax(-0.66F).cwiseMin(0.66F);
  set_eye_look(weights, direction_rad, vergence_rad);
  const auto lid = [&](std::size_t eye_blink, std::size_t squint, std::size_t wide, std::size_t down,
                       std::size_t up, float shut) {
    weights[eye_blink] += style.lid_follow * weights[down];
    weights[wide] += 0.3F * style.lid_follow * weights[up];
    weights[eye_blink] += std::max(0.0F, 1 - weights[eye_blink]) * style.blink_peak * shut;
    weights[squint] += 0.08F * shut;
  };
  lid(shape("eyeBlink_L"), shape("eyeSquint_L"), shape("eyeWide_L"), shape("eyeLookDown_L"),
      shape("eyeLookUp_L"), lids[0]);
  lid(shape("eyeBlink_R"), shape("eyeSquint_R"), shape("eyeWide_R"), shape("eyeLookDown_R"),
      shape("eyeLookUp_R"), lids[1]);
}

}  // namespace

face::Motion perform(const Script& script, const Style& style, const Random& random) {
  const auto frame_count =
      static_cast<std::size_t>(std::max(1.0, std::round(script.duration_s() * kFrameRateHz)));
  Canvas canvas(frame_count);
  std::vector<GazeEpisode> gaze_episodes;
  std::vector<HeadEpisode> head_episodes = script.head;
  Random choices = random.fork("choices");

  double begin_s = 0;
  for (std::size_t s = 0; s < script.segments.size(); ++s) {
    const Segment& segment = script.segments[s];
    const auto first = static_cast<std::ptrdiff_t>(std::round(begin_s * kFrameRateHz));
    const double end_s = begin_s + segment.duration_s;
    const auto end = static_cast<std::ptrdiff_t>(std::round(end_s * kFrameRateHz));
    // Speech that was given begins when its segment begins; everything else may reach over.
    const std::size_t before = segment.utterance ? 0 : kOverlapFrames;
    Canvas part(static_cast<std::size_t>(std::max<std::ptrdiff_t>(1, end - first)) + before + kOverlapFrames);
    perform_segment(part, segment, style, random.fork("segment", s));
    canvas.lay(part, first - static_cast<std::ptrdiff_t>(before), 2 * kOverlapFrames);

    gaze_episodes.push_back({begin_s, gaze_task(segment.block, choices)});
    if (script.head.empty()) {
      // A long segment does not keep one activity.
      for (double t = begin_s; t < end_s; t += choices.uniform(5, 15))
        head_episodes.push_back({t, head_activity(segment.block, choices)});
    }
    begin_s = end_s;
  }

  GazeTrack gaze =
      draw_gaze(frame_count, gaze_episodes, style.rest_gaze_rad, style.gaze_range, random.fork("gaze"));
  std::vector<double> cues_s = gaze.shifts_s;
  cues_s.insert(cues_s.end(), canvas.pauses_s.begin(), canvas.pauses_s.end());
  std::ranges::sort(cues_s);
  const auto blinks =
      draw_blinks(canvas.duration_s(), style.blink_rate_per_min, cues_s, random.fork("blink"));
  const auto lids = lid_tracks(blinks, frame_count);

  face::Motion motion;
  motion.name = script.name;
  motion.has_head = script.moves_head;
  motion.frames.resize(frame_count);
  Person person(style, random);
  for (std::size_t i = 0; i < frame_count; ++i) {
    face::MotionFrame& frame = motion.frames[i];
    frame.time_s = to_seconds(frame_offset(static_cast<std::int64_t>(i)));
    frame.weights = person.carry_out(canvas.weights[i]);
    const Eigen::Vector2f direction =
        style.rest_gaze_rad + (1 - canvas.gaze_held[i]) * (gaze.direction_rad[i] - style.rest_gaze_rad) +
        canvas.gaze_rad[i];
    add_eyes(frame.weights, lids[i], direction, gaze.vergence_rad[i], style);
    frame.tongue_out = std::clamp(canvas.tongue_out[i], 0.0F, 1.0F);
    // A tongue needs a gap to come out of.
    float& jaw = frame.weights[shape("jawOpen")];
    jaw += frame.tongue_out * std::max(0.0F, 0.15F - jaw);
    apply_limits(frame.weights, canvas.lip_closure[i]);
  }
  if (script.moves_head) {
    const HeadTrack track = draw_head_motion(frame_count, head_episodes, style.head_liveliness,
                                             canvas.head_rad, random.fork("head"));
    for (std::size_t i = 0; i < frame_count; ++i) {
      motion.frames[i].head = track.orientation[i];
      motion.frames[i].head_position_m = track.position_m[i];
    }
  }
  return motion;
}

}  // namespace mien::performer
