#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "mien/face/profile.h"
#include "mien/take/take.h"

namespace mien::measure {

/// One piece of a take: how accuracy changes over a long one.
struct Piece {
  double begin_s = 0;      ///< From the first evaluated frame, s.
  std::size_t frames = 0;  ///< That count.
  double mse = 0;          ///< As Metrics::mse.
  double mean_pose_mse = 0;
  /// Error over the mean pose's, divided by the same of the first piece: how much worse than at first,
  /// whatever is performed. 0 where that is not defined, as where the first piece has no error.
  double ratio = 0;
  /// The shape whose mean error, estimate less truth, differs most from the first piece's, and by how much;
  /// none of the first piece.
  std::optional<std::size_t> biased_shape = {};
  double bias = 0;
};

/// The evaluated frames of a take in pieces of `length_s` at the ticks' 60 Hz. Left out are pieces without
/// such a frame, and a last one with less than half the frames of a full piece, unless it is the only one.
/// Shape: both one a tick.
[[nodiscard]] std::vector<Piece> pieces_of(std::span<const take::TruthFrame> truth,
                                           std::span<const face::BlendshapeWeights> estimate,
                                           const face::BlendshapeWeights& mean_pose, double length_s);

}  // namespace mien::measure
