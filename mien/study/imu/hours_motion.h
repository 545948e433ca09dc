#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/motion.h"
#include "mien/performer/prologue.h"
#include "mien/performer/script.h"
#include "mien/performer/style.h"

namespace mien::study {

/// Length of the pieces of which a motion of hours is made, and by which it is measured, s.
inline constexpr double kPieceS = 600;

/// An expression that is held whatever else the face does: every shape is at least `value`.
struct HeldExpression {
  std::vector<std::size_t> shapes;
  float value = 0;     ///< 0 to 1.
  double begin_s = 0;  ///< From the motion's start; reached within half a second.
  double end_s = 0;    ///< Released within half a second.
};

/// A performance of hours, drawn piece by piece and never held in memory whole: after the brief prologue the
/// script's block is drawn anew for every ten minutes; pieces join over a second. Time 0 is the prologue's
/// start. Times asked for may step back by less than a piece. Thread: one at a time.
class HoursMotion {
 public:
  HoursMotion(performer::Block block, const performer::Style& style, const Random& root,
              std::vector<HeldExpression> held = {});

  [[nodiscard]] const performer::PrologueTimes& prologue() const { return times_; }
  [[nodiscard]] face::MotionFrame at(double time_s);

 private:
  struct Piece {
    std::size_t index = 0;
    face::MotionCurve curve;
    face::MotionFrame last;
  };
  /// Makes the next piece.
  void advance();

  std::function<face::Motion(std::size_t)> draw_;
  std::vector<HeldExpression> held_;
  performer::PrologueTimes times_;
  std::vector<Piece> pieces_;  // The current one, and the one before it.
};

}  // namespace mien::study
