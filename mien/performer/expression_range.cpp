#include "mien/performer/expression_range.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace mien::performer {

using face::kShapeCount;
using face::kShapeNames;
using face::shape;

namespace {

std::vector<Exercise> make_exercises() {
  std::vector<Exercise> all;
  const auto exercise = [&](std::string_view name,
                            std::initializer_list<std::initializer_list<NamedPart>> poses) {
    Exercise one{.name = name, .poses = {}};
    for (const auto& parts : poses) one.poses.push_back(pose_of(parts));
    all.push_back(std::move(one));
  };
  exercise("brows_up", {{{"browInnerUp", 1}, {"browOuterUp", 0.9F}}});
  exercise("brows_down", {{{"browDown", 1}}});
  exercise("brows_up_down", {{{"browInnerUp", 1}, {"browOuterUp", 0.9F}}, {{"browDown", 1}}});
  exercise("brows_inner", {{{"browInnerUp", 1}}});
  exercise("brow_left", {{{"browOuterUp_L", 1}, {"browInnerUp_L", 0.5F}}});
  exercise("brow_right", {{{"browOuterUp_R", 1}, {"browInnerUp_R", 0.5F}}});
  exercise("brows_seesaw", {{{"browOuterUp_L", 0.9F}, {"browDown_R", 0.7F}},
                            {{"browOuterUp_R", 0.9F}, {"browDown_L", 0.7F}}});
  exercise("blink", {{{"eyeBlink", 1}}});
  exercise("squeeze", {{{"eyeBlink", 1}, {"eyeSquint", 0.9F}, {"cheekSquint", 0.6F}, {"browDown", 0.4F}}});
  exercise("wink_left", {{{"eyeBlink_L", 1}, {"eyeSquint_L", 0.4F}}});
  exercise("wink_right", {{{"eyeBlink_R", 1}, {"eyeSquint_R", 0.4F}}});
  exercise("wide_eyes", {{{"eyeWide", 1}}});
  exercise("wide_then_shut",
           {{{"eyeWide", 1}, {"browOuterUp", 0.5F}}, {{"eyeBlink", 1}, {"eyeSquint", 0.5F}}});
  exercise("squint", {{{"eyeSquint", 1}}});
  exercise("squint_left", {{{"eyeSquint_L", 1}, {"cheekSquint_L", 0.4F}}});
  exercise("squint_right", {{{"eyeSquint_R", 1}, {"cheekSquint_R", 0.4F}}});
  exercise("cheeks_up", {{{"cheekSquint", 1}, {"eyeSquint", 0.4F}}});
  exercise("cheek_left", {{{"cheekSquint_L", 1}}});
  exercise("cheek_right", {{{"cheekSquint_R", 1}}});
  exercise("puff", {{{"cheekPuff", 1}}});
  exercise("puff_sides",
           {{{"cheekPuff_L", 1}, {"mouthPress", 0.2F}}, {{"cheekPuff_R", 1}, {"mouthPress", 0.2F}}});
  exercise("sneer", {{{"noseSneer", 1}}});
  exercise("sneer_sides",
           {{{"noseSneer_L", 1}, {"mouthUpperUp_L", 0.4F}}, {{"noseSneer_R", 1}, {"mouthUpperUp_R", 0.4F}}});
  exercise("jaw_open", {{{"jawOpen", 1}}});
  exercise("jaw_open_lips_closed", {{{"jawOpen", 0.6F}, {"mouthClose", 0.58F}}});
  exercise("jaw_sides", {{{"jawLeft", 1}}, {{"jawRight", 1}}});
  exercise("jaw_forward", {{{"jawForward", 1}}});
  exercise("jaw_circle",
           {{{"jawLeft", 0.7F}}, {{"jawOpen", 0.6F}}, {{"jawRight", 0.7F}}, {{"jawForward", 0.6F}}});
  exercise("chew", {{{"jawOpen", 0.35F}, {"mouthClose", 0.33F}, {"jawLeft", 0.2F}},
                    {{"mouthPress", 0.4F}, {"jawRight", 0.15F}}});
  exercise("smile", {{{"mouthSmile", 1}}});
  exercise("smile_sides", {{{"mouthSmile_L", 1}}, {{"mouthSmile_R", 1}}});
  exercise("smile_open", {{{"mouthSmile", 1}, {"jawOpen", 0.4F}, {"mouthUpperUp", 0.4F}}});
  exercise("frown", {{{"mouthFrown", 1}}});
  exercise("smile_frown", {{{"mouthSmile", 1}}, {{"mouthFrown", 1}, {"mouthShrugLower", 0.3F}}});
  exercise("frown_sides", {{{"mouthFrown_L", 1}}, {{"mouthFrown_R", 1}}});
  exercise("pucker", {{{"mouthPucker", 1}}});
  exercise("pucker_sides",
           {{{"mouthPucker", 0.9F}, {"mouthLeft", 0.7F}}, {{"mouthPucker", 0.9F}, {"mouthRight", 0.7F}}});
  exercise("pucker_smile", {{{"mouthPucker", 1}}, {{"mouthSmile", 1}}});
  exercise("funnel", {{{"mouthFunnel", 1}, {"jawOpen", 0.2F}}});
  exercise("mouth_sides", {{{"mouthLeft", 1}}, {{"mouthRight", 1}}});
  exercise("mouth_circle", {{{"mouthLeft", 0.8F}},
                            {{"mouthUpperUp", 0.5F}, {"mouthPucker", 0.5F}},
                            {{"mouthRight", 0.8F}},
                            {{"mouthShrugLower", 0.4F}, {"mouthPucker", 0.4F}}});
  exercise("stretch", {{{"mouthStretch", 1}}});
  exercise("stretch_sides", {{{"mouthStretch_L", 1}}, {{"mouthStretch_R", 1}}});
  exercise("dimple", {{{"mouthDimple", 1}}});
  exercise("dimple_sides", {{{"mouthDimple_L", 1}}, {{"mouthDimple_R", 1}}});
  exercise("press", {{{"mouthPress", 1}}});
  exercise("lips_in", {{{"mouthRollLower", 1}, {"mouthRollUpper", 1}}});
  exercise("lower_lip_in", {{{"mouthRollLower", 1}}});
  exercise("upper_lip_in", {{{"mouthRollUpper", 1}}});
  exercise("chin_up", {{{"mouthShrugLower", 1}, {"mouthShrugUpper", 0.6F}}});
  exercise("upper_lip_pushed", {{{"mouthShrugUpper", 1}}});
  exercise("upper_lip", {{{"mouthUpperUp", 1}}});
  exercise("upper_lip_sides", {{{"mouthUpperUp_L", 1}}, {{"mouthUpperUp_R", 1}}});
  exercise("lower_lip", {{{"mouthLowerDown", 1}}});
  exercise("lower_lip_sides", {{{"mouthLowerDown_L", 1}}, {{"mouthLowerDown_R", 1}}});
  exercise("teeth", {{{"mouthUpperUp", 0.9F}, {"mouthLowerDown", 0.9F}, {"mouthStretch", 0.4F}}});
  exercise("wide_open_everything", {{{"jawOpen", 1},
                                     {"eyeWide", 0.9F},
                                     {"browInnerUp", 0.9F},
                                     {"browOuterUp", 0.9F},
                                     {"mouthStretch", 0.3F}}});
  exercise("scrunch_everything", {{{"eyeBlink", 0.9F},
                                   {"eyeSquint", 0.9F},
                                   {"browDown", 0.9F},
                                   {"noseSneer", 0.9F},
                                   {"cheekSquint", 0.8F},
                                   {"mouthPucker", 0.6F}}});
  exercise("open_then_scrunch", {{{"jawOpen", 0.9F}, {"eyeWide", 0.8F}, {"browOuterUp", 0.8F}},
                                 {{"eyeBlink", 0.9F},
                                  {"eyeSquint", 0.7F},
                                  {"browDown", 0.8F},
                                  {"noseSneer", 0.7F},
                                  {"mouthPucker", 0.6F}}});
  exercise("vowels", {{{"jawOpen", 0.6F}},
                      {{"mouthSmile", 0.5F}, {"mouthStretch", 0.3F}, {"jawOpen", 0.15F}},
                      {{"mouthFunnel", 0.7F}, {"jawOpen", 0.3F}},
                      {{"mouthPucker", 0.9F}}});
  exercise("tongue", {{{"jawOpen", 0.35F}, {"mouthLowerDown", 0.2F}}});
  all.back().tongue_out = 1;
  exercise("eyes_round", {{}});
  all.back().gaze_rad = {0.5F, 0.4F};
  exercise("eyes_sides", {{}});
  all.back().gaze_rad = {0.55F, 0.0F};
  exercise("eyes_up_down", {{}});
  all.back().gaze_rad = {0.0F, 0.45F};
  return all;
}

/// How one run of repetitions is done.
struct Pace {
  double move_s;
  double hold_s;
  std::size_t repetitions;
};

/// Shapes that join in unasked, the same for the whole exercise.
Pose draw_overflow(Random& random) {
  Pose overflow;
  const auto count = random.below(4);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::size_t k = random.below(kShapeCount);
    if (kShapeNames[k].starts_with("eyeLook") || k == shape("mouthClose")) continue;
    const auto amount = static_cast<float>(random.uniform(0, 0.3));
    overflow.push_back({static_cast<std::uint8_t>(k), amount});
    if (other_side(k) != k && random.chance(0.7))
      overflow.push_back({static_cast<std::uint8_t>(other_side(k)), amount});
  }
  return overflow;
}

void roll_eyes(Canvas& canvas, const Exercise& exercise, double begin_s, double seconds, double cycles) {
  const Eigen::Vector2f& axes = exercise.gaze_rad;
  const bool circle = axes.x() > 0 && axes.y() > 0;
  const auto first = static_cast<std::size_t>(begin_s * kFrameRateHz);
  for (std::size_t i = first; i < canvas.frame_count(); ++i) {
    const double t = static_cast<double>(i) / kFrameRateHz - begin_s;
    if (t < 0) continue;
    if (t > seconds) break;
    const double share = minimum_jerk(t / 0.4) * minimum_jerk((seconds - t) / 0.4);
    const double angle = 2 * std::numbers::pi * cycles * t / seconds;
    const auto s = static_cast<float>(share);
    canvas.gaze_held[i] = std::max(canvas.gaze_held[i], s);
    canvas.gaze_rad[i] +=
        s * Eigen::Vector2f(axes.x() * static_cast<float>(std::sin(angle)),
                            axes.y() * static_cast<float>(circle ? std::cos(angle) : std::sin(angle)));
  }
}

/// One run of repetitions; returns when it ends.
double repeat(Canvas& canvas, const Exercise& exercise, const Pose& overflow, const Pace& pace,
              double begin_s, Random& random) {
  double now_s = begin_s;
  for (std::size_t r = 0; r < pace.repetitions; ++r) {
    const double peak = random.chance(0.25) ? random.uniform(0.4, 0.75) : random.uniform(0.75, 1.1);
    for (const Pose& pose : exercise.poses) {
      const double move_s = pace.move_s * std::clamp(random.log_normal(0.12), 0.75, 1.35);
      const double hold_s = pace.hold_s * random.uniform(0.5, 1.5);
      const double fall_s = std::max(0.08, move_s * random.uniform(0.8, 1.4));
      for (const PosePart& part : pose) {
        const double lag_s = random.uniform(0, 0.15) * move_s;
        canvas.add(part.shape, {now_s + lag_s, move_s, hold_s, fall_s},
                   peak * part.weight * random.uniform(0.85, 1.05));
      }
      canvas.add(overflow, {now_s, move_s, hold_s, fall_s}, peak);
      if (exercise.tongue_out > 0)
        canvas.add_tongue({now_s + 0.5 * move_s, move_s, hold_s, fall_s}, exercise.tongue_out);
      // With several poses the next begins while this one falls.
      now_s += move_s + hold_s + (exercise.poses.size() > 1 ? 0.15 * fall_s : fall_s);
    }
    now_s += random.uniform(0, 0.4) * pace.move_s;
  }
  return now_s + 0.5 * pace.move_s;
}

}  // namespace

std::span<const Exercise> range_exercises() {
  static const auto exercises = make_exercises();
  return exercises;
}

void perform_range_of_motion(Canvas& canvas, const Style& style, Random random) {
  const auto exercises = range_exercises();
  std::vector<std::size_t> order(exercises.size());
  std::size_t next = order.size();
  double now_s = random.uniform(0, 0.5);
  while (now_s < canvas.duration_s()) {
    if (next == order.size()) {
      for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
      for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
      next = 0;
    }
    const Exercise& exercise = exercises[order[next++]];
    const Pose overflow = draw_overflow(random);
    const Pace slow{random.uniform(0.4, 1.3) / style.tempo, random.uniform(0.1, 1.0), 1 + random.below(2)};
    const Pace fast{random.uniform(0.10, 0.30) / style.tempo, random.uniform(0, 0.12), 2 + random.below(4)};
    if (exercise.gaze_rad != Eigen::Vector2f::Zero()) {
      const double seconds = random.uniform(2.5, 6);
      roll_eyes(canvas, exercise, now_s, seconds, std::round(random.uniform(1, 3)));
      now_s += seconds;
    } else {
      const double which = random.uniform();
      if (which < 0.75) now_s = repeat(canvas, exercise, overflow, slow, now_s, random);
      if (which > 0.35) now_s = repeat(canvas, exercise, overflow, fast, now_s, random);
    }
    if (random.chance(0.3)) now_s += random.uniform(0.2, 1.5);
  }
}

}  // namespace mien::performer
