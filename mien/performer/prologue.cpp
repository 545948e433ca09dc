#include "mien/performer/prologue.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "mien/core/units.h"
#include "mien/face/anchors.h"
#include "mien/performer/blinks.h"
#include "mien/performer/canvas.h"
#include "mien/performer/gaze_points.h"
#include "mien/performer/head_motion.h"
#include "mien/performer/limits.h"

namespace mien::performer {

using face::kShapeCount;
using face::shape;

namespace {

constexpr double kGesture_s = 4;        // Two cycles at half a hertz,
constexpr double kGestureRest_s = 0.5;  // and a moment of rest after each.
constexpr double kCycles = 2;
constexpr double kEase_s = 0.5;
/// A session shows a prompt 1.5 s ahead; people react in 0.1 s.
constexpr double kLedIn_s = 1.6;
constexpr double kAnchor_s = 2.4;
constexpr double kRangePrompt_s = 2.0;

/// The performed answer to a prompt.
void miss(Canvas& canvas, const Prompt& prompt, double canvas_begin_s, Random random) {
  const double late_s = random.uniform(0.15, 0.6);
  const double length_s = prompt.end_s - prompt.begin_s;
  const double hold_s = std::max(0.1, length_s - 3 * prompt.rise_s);
  const Envelope envelope{prompt.begin_s - canvas_begin_s + late_s, prompt.rise_s * random.uniform(0.7, 1.2),
                          hold_s, prompt.rise_s * random.uniform(0.7, 1.2)};
  for (std::size_t k = 0; k < kShapeCount; ++k)
    if (prompt.target[k] > 0) canvas.add(k, envelope, prompt.target[k] * random.uniform(0.6, 1.2));
  const auto unasked = 1 + random.below(3);
  for (std::uint64_t i = 0; i < unasked;) {
    const std::size_t k = random.below(kShapeCount);
    if (prompt.target[k] > 0 || is_driven_by_others(k)) continue;
    canvas.add(k, envelope, random.uniform(0, 0.3));
    ++i;
  }
}

/// Writes the frames before the motion.
class Prologue {
 public:
  Prologue(const Random& random, const PrologueNeeds& needs) : random_(random), needs_(needs) {}

  PrologueMotion run(const face::Motion& motion, PrologueKind kind) {
    PrologueTimes times;
    const bool led = kind == PrologueKind::guided || kind == PrologueKind::gaze;
    times.neutral = stretch(needs_.neutral_s + (led ? kLedIn_s : 0));
    times.nod = stretch(needs_.gestures ? kGesture_s + kGestureRest_s : 0);
    times.shake = stretch(needs_.gestures ? kGesture_s + kGestureRest_s : 0);
    if (kind == PrologueKind::full || kind == PrologueKind::guided) {
      times.anchors = ask(face::anchors(), kAnchor_s, true, times.prompts);
      times.range_of_motion = ask(face::range_of_motion(), kRangePrompt_s, false, times.prompts);
    } else {
      times.anchors = times.range_of_motion = {now_s_, now_s_};
    }
    const double targets = kind == PrologueKind::gaze ? static_cast<double>(face::gaze_targets().size()) : 0;
    times.gaze = stretch(kGazeTarget_s * targets);
    times.ease = stretch(kEase_s);
    times.motion_start_s = times.ease.end_s;
    return {write(motion, times), times};
  }

 private:
  Interval stretch(double seconds) {
    const Interval interval{now_s_, now_s_ + seconds};
    now_s_ = interval.end_s;
    return interval;
  }
  Interval ask(std::span<const face::Anchor> poses, double each_s, bool anchor,
               std::vector<Prompt>& prompts) {
    const double begin_s = now_s_;
    for (const face::Anchor& pose : poses) {
      const Interval interval = stretch(each_s);
      prompts.push_back({.name = std::string(pose.name),
                         .anchor = anchor,
                         .begin_s = interval.begin_s,
                         .end_s = interval.end_s,
                         .target = pose.target});
    }
    // The last prompt too is answered late, and the face comes back to neutral.
    if (!anchor) stretch(1.0);
    return {begin_s, now_s_};
  }

  /// Two cycles with soft ends, as a share of the amplitude; downwards and to the left are positive and come
  /// first.
  static double gesture(double time_s) {
    if (time_s <= 0 || time_s >= kGesture_s) return 0;
    const double ends = minimum_jerk(time_s / 0.4) * minimum_jerk((kGesture_s - time_s) / 0.4);
    return ends * std::sin(2 * std::numbers::pi * kCycles * time_s / kGesture_s);
  }

  face::Motion write(const face::Motion& motion, const PrologueTimes& times) {
    face::Motion out;
    out.name = motion.name;
    out.has_head = motion.has_head || needs_.gestures;
    out.head_without_face = motion.head_without_face;
    const auto frame_count = static_cast<std::size_t>(std::round(times.motion_start_s * kFrameRateHz));
    out.frames.reserve(frame_count + motion.frames.size());

    Canvas canvas(frame_count);
    for (std::size_t p = 0; p < times.prompts.size(); ++p)
      miss(canvas, times.prompts[p], 0, random_.fork("prompt", p));
    const double prompted_s = times.range_of_motion.end_s - times.anchors.begin_s;
    auto blinks = draw_blinks(std::max(0.0, prompted_s - 0.5), 12, {}, random_.fork("blink"));
    for (face::Blink& blink : blinks) blink.begin_s += times.anchors.begin_s;
    const auto lids = lid_tracks(blinks, frame_count);

    if (times.gaze.end_s > times.gaze.begin_s) {
      const auto begin = static_cast<std::size_t>(std::round(times.gaze.begin_s * kFrameRateHz));
      const auto looks = look_at_targets(face::gaze_targets(), kGazeTarget_s, random_.fork("gaze"));
      for (std::size_t i = begin; i < frame_count; ++i)
        canvas.weights[i] = looks[std::min(i - begin, looks.size() - 1)];
    }

    // Where the motion begins.
    face::MotionFrame first;
    const auto found = std::ranges::find_if(motion.frames, [](const auto& frame) { return frame.has_face; });
    if (found != motion.frames.end()) first = *found;
    if (!motion.has_head) {
      first.head = Quat::Identity();
      first.head_position_m = Vec3::Zero();
    }

    Random body = random_.fork("body");
    const double nod_rad = body.uniform(18, 22) * kRadPerDeg;
    const double shake_rad = body.uniform(18, 22) * kRadPerDeg;
    const double slant = 0.04 * body.normal();
    std::array<SmoothNoise, 3> sway = {SmoothNoise(0.25, body), SmoothNoise(0.25, body),
                                       SmoothNoise(0.2, body)};
    for (std::size_t i = 0; i < frame_count; ++i) {
      face::MotionFrame frame;
      frame.time_s = to_seconds(frame_offset(static_cast<std::int64_t>(i)));
      const double t = frame.time_s;
      const double ease = minimum_jerk((t - times.ease.begin_s) / kEase_s);
      frame.weights = canvas.weights[i];
      if (prompted_s > 0) {
        const auto lid = [&](std::size_t k, float shut) {
          frame.weights[k] += std::max(0.0F, 1 - frame.weights[k]) * shut;
        };
        lid(shape("eyeBlink_L"), lids[i][0]);
        lid(shape("eyeBlink_R"), lids[i][1]);
        apply_limits(frame.weights, 0);
      }
      for (std::size_t k = 0; k < kShapeCount; ++k)
        frame.weights[k] += static_cast<float>(ease) * (first.weights[k] - frame.weights[k]);
      frame.tongue_out = static_cast<float>(ease) * first.tongue_out;
      if (needs_.gestures) {
        const double down = nod_rad * gesture(t - times.nod.begin_s);
        const double left = shake_rad * gesture(t - times.shake.begin_s);
        Vec3 angle(down + slant * left, left + slant * down, 0);
        // Asked to hold still, a head sways by a fifth of a degree.
        for (std::size_t axis = 0; axis < 3; ++axis)
          angle[static_cast<Eigen::Index>(axis)] += 0.2 * kRadPerDeg * sway[axis].next(body);
        frame.head = head_orientation(angle);
        frame.head_position_m = neck_displacement_m(frame.head);
      }
      frame.head = frame.head.slerp(ease, first.head);
      frame.head_position_m += ease * (first.head_position_m - frame.head_position_m);
      out.frames.push_back(frame);
    }
    const double shift_s = times.motion_start_s - (motion.frames.empty() ? 0 : motion.frames.front().time_s);
    for (face::MotionFrame frame : motion.frames) {
      frame.time_s += shift_s;
      out.frames.push_back(frame);
    }
    return out;
  }

  Random random_;
  PrologueNeeds needs_;
  double now_s_ = 0;
};

}  // namespace

face::BlendshapeWeights prompted_shapes() {
  face::BlendshapeWeights asked;
  for (const auto& poses : {face::anchors(), face::range_of_motion()})
    for (const face::Anchor& pose : poses)
      for (std::size_t k = 0; k < kShapeCount; ++k)
        if (pose.target[k] > 0) asked[k] = 1;
  return asked;
}

PrologueMotion with_prologue(const face::Motion& motion, PrologueKind kind, const Random& random,
                             const PrologueNeeds& needs) {
  if (kind == PrologueKind::none) return {motion, {}};
  return Prologue(random, needs).run(motion, kind);
}

PrologueKind prologue_kind(std::string_view name) {
  const auto found = std::ranges::find(kPrologueNames, name);
  return found == kPrologueNames.end() ? PrologueKind::brief
                                       : static_cast<PrologueKind>(found - kPrologueNames.begin());
}

}  // namespace mien::performer
