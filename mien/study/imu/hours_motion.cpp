#include "mien/study/imu/hours_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mien/core/minimum_jerk.h"
#include "mien/performer/performer.h"

namespace mien::study {
namespace {

constexpr double kJoinS = 1, kReachS = 0.5;

/// From one moment to another; `share` 0 to 1.
face::MotionFrame between(const face::MotionFrame& from, const face::MotionFrame& to, double share) {
  face::MotionFrame out = to;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    out.weights[k] = from.weights[k] + static_cast<float>(share) * (to.weights[k] - from.weights[k]);
  out.head = from.head.slerp(share, to.head);
  out.head_position_m = from.head_position_m + share * (to.head_position_m - from.head_position_m);
  return out;
}

}  // namespace

HoursMotion::HoursMotion(performer::Block block, const performer::Style& style, const Random& root,
                         std::vector<HeldExpression> held)
    : draw_([block, style, root](std::size_t index) {
        return performer::perform(performer::default_script(block, kPieceS), style,
                                  root.fork("piece", index));
      }),
      held_(std::move(held)) {
  performer::PrologueMotion begun =
      performer::with_prologue(draw_(0), performer::PrologueKind::brief, root.fork("prologue"));
  times_ = std::move(begun.times);
  pieces_.push_back(
      {.index = 0, .curve = face::MotionCurve(begun.motion), .last = begun.motion.frames.back()});
}

void HoursMotion::advance() {
  const Piece& before = pieces_.back();
  const std::size_t index = before.index + 1;
  face::Motion motion = draw_(index);
  // The head does not jump where pieces join.
  const Vec3 offset_m = before.last.head_position_m - motion.frames.front().head_position_m;
  const face::MotionFrame from = before.last;
  const double begin_s = times_.motion_start_s + kPieceS * static_cast<double>(index);
  for (face::MotionFrame& frame : motion.frames) {
    frame.head_position_m += offset_m;
    if (frame.time_s < kJoinS) {
      const double time_s = frame.time_s;
      frame = between(from, frame, minimum_jerk(time_s / kJoinS));
      frame.time_s = time_s;
    }
    frame.time_s += begin_s;
  }
  Piece next{.index = index, .curve = face::MotionCurve(motion), .last = motion.frames.back()};
  if (pieces_.size() > 1) pieces_.erase(pieces_.begin());
  pieces_.push_back(std::move(next));
}

face::MotionFrame HoursMotion::at(double time_s) {
  const auto end_s = [this](const Piece& piece) {
    return times_.motion_start_s + kPieceS * static_cast<double>(piece.index + 1);
  };
  while (time_s >= end_s(pieces_.back())) advance();
  const Piece& piece = time_s < end_s(pieces_.front()) ? pieces_.front() : pieces_.back();
  face::MotionFrame frame = piece.curve.at(time_s);
  for (const HeldExpression& held : held_) {
    const double since_s = time_s - times_.motion_start_s - held.begin_s;
    const double left_s = held.end_s + kReachS - (time_s - times_.motion_start_s);
    if (since_s <= 0 || left_s <= 0) continue;
    const double share = std::min(minimum_jerk(std::clamp(since_s / kReachS, 0.0, 1.0)),
                                  minimum_jerk(std::clamp(left_s / kReachS, 0.0, 1.0)));
    for (const std::size_t k : held.shapes)
      frame.weights[k] = std::max(frame.weights[k], static_cast<float>(share) * held.value);
  }
  return frame;
}

}  // namespace mien::study
