#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/face.h"

namespace mien::face {

/// Moves a face that has no shapes by points of its skin: every vertex follows the markers that are near it
/// *along the skin*, so that the lower lip does not follow the upper one across the gap between them. Between
/// markers the movement is smooth, at each marker it is the marker's own, and beyond `reach_m` the mesh keeps
/// still. Radial basis functions of the distance along the mesh's edges (Wendland 1995,
/// doi:10.1007/BF02123482), brought to one matrix when it is made. Thread-safe once made.
class MarkerDeformation {
 public:
  static constexpr double kReachM = 0.08;

  /// `markers_m`: where the markers are at neutral, size 3V, metres, frame H; each holds on to the nearest
  /// vertex of the skin. Errors: mismatch (a size that is no multiple of three), out_of_range (no markers, a
  /// place that is not finite, a reach not above 0), not_found (a face without skin). Cost: one walk over the
  /// mesh a marker, about 10 ms on ICT's.
  [[nodiscard]] static Result<MarkerDeformation> create(const Face& face, const Eigen::VectorXd& markers_m,
                                                        double reach_m = kReachM);

  /// The face's vertices (size of neutral_m) when the markers have moved to `markers_m` (size 3V, finite). No
  /// allocation. Cost: V multiplications a coordinate of the vertices within reach.
  void apply(const Face& face, const Eigen::VectorXd& markers_m, std::span<Vec3f> vertices_m) const;

 private:
  Eigen::VectorXd neutral_m_;
  std::vector<std::uint32_t> vertices_;  // Those within reach of some marker.
  /// A row each of these: how much of each marker's displacement it takes.
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> shares_;
};

}  // namespace mien::face
