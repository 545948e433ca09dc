#include "mien/performer/expression_range.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mien/performer/tables.h"

namespace mien::performer {

using face::kShapeCount;

namespace {

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
    if (is_driven_by_others(k)) continue;
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
  return tables().exercises;
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
