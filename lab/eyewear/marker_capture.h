#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "mien/core/random.h"
#include "mien/core/rotation.h"
#include "mien/virtual/eyewear/eyewear_faults.h"

namespace mien::lab {

/// Motion capture of markers past glasses: jitter, neighbours that change names, and markers that are found
/// elsewhere while the frame covers them. The head's own motion has been taken out.
class MarkerCapture {
 public:
  /// `neutral_m`: the markers on the neutral face, by which neighbours are told.
  MarkerCapture(const virt::EyewearFaults& faults, std::vector<Vec3> neutral_m, const Random& random);

  /// What is captured at `time_s` of markers that are truly at `markers_m` (3V: x, y, z of each). Times do
  /// not run backwards.
  [[nodiscard]] Eigen::VectorXd capture(double time_s, const Eigen::VectorXd& markers_m);

 private:
  /// One spell of mistakes after another.
  struct Spell {
    double begin_s = 0;
    double end_s = 0;
    std::size_t marker = 0;
    std::size_t other = 0;  ///< Whose name it has; unused for a lost one.
    Vec3 off_m = Vec3::Zero();
  };
  void next_mislabel(double after_s);
  void next_loss(double after_s);

  virt::EyewearFaults faults_;
  std::vector<Vec3> neutral_m_;
  Spell mislabel_;
  Spell loss_;
  Random jitter_;
  Random mislabels_;
  Random losses_;
};

}  // namespace mien::lab
