#include "mien/performer/long_motion.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "mien/core/minimum_jerk.h"
#include "mien/performer/performer.h"

namespace mien::performer {
namespace {

constexpr double kJoinS = 1, kReachS = 0.5;

/// From one moment to another; `share` 0 to 1.
face::MotionFrame between(const face::MotionFrame& from, const face::MotionFrame& to, double share) {
  face::MotionFrame out = to;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    out.weights[k] = from.weights[k] + static_cast<float>(share) * (to.weights[k] - from.weights[k]);
  out.tongue_out = from.tongue_out + static_cast<float>(share) * (to.tongue_out - from.tongue_out);
  out.head = from.head.slerp(share, to.head);
  out.head_position_m = from.head_position_m + share * (to.head_position_m - from.head_position_m);
  return out;
}

PrologueMotion with_brief_prologue(const face::Motion& motion, const Random& root) {
  return with_prologue(motion, PrologueKind::brief, root.fork("prologue"));
}

/// Moves a piece to its beginning, after the last frame of the one before it.
void put_after(const face::MotionFrame& last, double begin_s, std::vector<face::MotionFrame>& piece) {
  // The head does not jump where pieces join.
  const Vec3 offset_m = last.head_position_m - piece.front().head_position_m;
  for (face::MotionFrame& frame : piece) {
    frame.head_position_m += offset_m;
    if (frame.time_s < kJoinS) {
      const double time_s = frame.time_s;
      frame = between(last, frame, minimum_jerk(time_s / kJoinS));
      frame.time_s = time_s;
    }
    frame.time_s += begin_s;
  }
}

}  // namespace

std::vector<Script> piece_scripts(Block kind, double seconds) {
  std::vector<Script> scripts;
  do {
    scripts.push_back(default_script(kind, std::min(seconds, kPieceS)));
    seconds -= kPieceS;
  } while (seconds > 0);
  return scripts;
}

PrologueMotion join(PrologueMotion first, const LaterPieces& later) {
  for (std::size_t index = 1;; ++index) {
    face::Motion piece = later.draw(index);
    if (piece.frames.empty()) return first;
    put_after(first.motion.frames.back(),
              first.times.motion_start_s + later.piece_s * static_cast<double>(index), piece.frames);
    first.motion.frames.insert(first.motion.frames.end(), piece.frames.begin(), piece.frames.end());
  }
}

LongMotion::LongMotion(const PrologueMotion& first, LaterPieces later, std::vector<HeldExpression> held)
    : later_(std::move(later)), held_(std::move(held)), times_(first.times) {
  pieces_.push_back(
      {.index = 0, .curve = face::MotionCurve(first.motion), .last = first.motion.frames.back()});
}

LongMotion::LongMotion(Block block, const Style& style, const Random& root, std::vector<HeldExpression> held)
    : LongMotion(
          with_brief_prologue(perform(default_script(block, kPieceS), style, root.fork("piece", 0)), root),
          {.draw =
               [block, style, root](std::size_t index) {
                 return perform(default_script(block, kPieceS), style, root.fork("piece", index));
               },
           .duration_s = std::numeric_limits<double>::infinity()},
          std::move(held)) {}

LongMotion::LongMotion(const PrologueMotion& once) : LongMotion(once, LaterPieces()) {
  later_.duration_s = pieces_.front().curve.duration_s();
}

LongMotion::LongMotion(const PrologueMotion& repeated, const Encore& encore, double duration_s,
                       std::vector<HeldExpression> held)
    : LongMotion(repeated, {.draw = {}, .duration_s = duration_s}, std::move(held)) {
  encore_ = encore;
}

double LongMotion::end_s(const Piece& piece) const {
  return times_.motion_start_s + later_.piece_s * static_cast<double>(piece.index + 1);
}

void LongMotion::advance() {
  const Piece& before = pieces_.back();
  const std::size_t index = before.index + 1;
  face::Motion motion = later_.draw(index);
  if (motion.frames.empty()) {
    later_.draw = {};
    return;
  }
  put_after(before.last, end_s(before), motion.frames);
  Piece next{.index = index, .curve = face::MotionCurve(motion), .last = motion.frames.back()};
  if (pieces_.size() > 1) pieces_.erase(pieces_.begin());
  pieces_.push_back(std::move(next));
}

face::MotionFrame LongMotion::at(double time_s) {
  while (later_.draw && time_s >= end_s(pieces_.back())) advance();
  const Piece& piece =
      pieces_.size() > 1 && time_s >= end_s(pieces_.front()) ? pieces_.back() : pieces_.front();
  face::MotionFrame frame =
      encore_ ? encore_->at(piece.curve, std::min(time_s, later_.duration_s)) : piece.curve.at(time_s);
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

}  // namespace mien::performer
