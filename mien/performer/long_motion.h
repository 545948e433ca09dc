#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/motion.h"
#include "mien/performer/encore.h"
#include "mien/performer/prologue.h"
#include "mien/performer/script.h"
#include "mien/performer/style.h"

namespace mien::performer {

/// Length of the pieces of which a long performance is made, s.
inline constexpr double kPieceS = 600;

/// A performance of one kind as the scripts of its pieces, each drawn for itself: default_script() of
/// kPieceS, and of what is left.
[[nodiscard]] std::vector<Script> piece_scripts(Block kind, double seconds);

/// An expression that is held whatever else the face does: every shape is at least `value`.
struct HeldExpression {
  std::vector<std::size_t> shapes;
  float value = 0;     ///< 0 to 1.
  double begin_s = 0;  ///< From the motion's start; reached within half a second.
  double end_s = 0;    ///< Released within half a second.
};

/// How a motion goes on after its first piece.
struct LaterPieces {
  /// Piece `index` of the motion, from 1 on, from its own time 0; without frames: the motion is over.
  std::function<face::Motion(std::size_t index)> draw;
  double duration_s = 0;     ///< Of the whole with its prologue: time of the last frame; may be infinite.
  double piece_s = kPieceS;  ///< Length of every piece but the last.
};

/// The same performance whole, as LongMotion would play it.
[[nodiscard]] PrologueMotion join(PrologueMotion first, const LaterPieces& later);

/// A performance of any length that is never held in memory whole: a prologue, then a motion that is drawn
/// piece by piece, or one that is repeated. Time 0 is the prologue's start. Times asked for may step back by
/// less than a piece. Thread: one at a time.
class LongMotion {
 public:
  /// `first`: the prologue and piece 0. A piece begins with a blend of a second from the last frame of the
  /// one before it, and where the head was then.
  LongMotion(const PrologueMotion& first, LaterPieces later, std::vector<HeldExpression> held = {});
  /// The brief prologue, then a block's script drawn anew for every piece, without end.
  LongMotion(Block block, const Style& style, const Random& root, std::vector<HeldExpression> held = {});
  /// A motion that is performed once.
  explicit LongMotion(const PrologueMotion& once);
  /// A motion that is repeated as an encore says, until `duration_s`.
  LongMotion(const PrologueMotion& repeated, const Encore& encore, double duration_s,
             std::vector<HeldExpression> held = {});

  [[nodiscard]] const PrologueTimes& prologue() const { return times_; }
  /// Time of the last frame, s; infinite for a motion without end. Afterwards that frame is held.
  [[nodiscard]] double duration_s() const { return later_.duration_s; }
  [[nodiscard]] face::MotionFrame at(double time_s);

 private:
  struct Piece {
    std::size_t index = 0;
    face::MotionCurve curve;
    face::MotionFrame last;
  };
  /// Makes the next piece, if there is one.
  void advance();
  [[nodiscard]] double end_s(const Piece& piece) const;

  LaterPieces later_;  // Their `draw` is empty where there are no more.
  std::optional<Encore> encore_;
  std::vector<HeldExpression> held_;
  PrologueTimes times_;
  std::vector<Piece> pieces_;  // The current one, and the one before it.
};

}  // namespace mien::performer
