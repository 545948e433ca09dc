#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/profile.h"
#include "mien/face/rig_constraints.h"

namespace mien::face {

/// The costs are squared millimetres of one coordinate a unit of weight, summed over the points, and not
/// below 0: what is gained by fitting a millimetre better must outweigh them.
struct WeightSolverSettings {
  /// Pull to zero. Raising uses fewer and smaller shapes where the points do not tell; lowering fits the
  /// points more closely, and their noise with shapes that they hardly determine. For measured points;
  /// estimated ones, millimetres off, had the least error at 100 (docs/experiments/eyewear.md).
  double rest = 0.5;
  /// Pull to the frame before, at 60 frames a second; it falls with the time since that frame. Raising: less
  /// jitter, more delay. Lowering: more jitter, less delay; at 0 each frame is solved without the last one.
  double smooth = 2.0;
  /// Cost of both of an exclusive pair at full weight. Raising takes the lesser one out even where the points
  /// ask for both; lowering lets both share a movement of which the points cannot tell them apart.
  double exclusive = 40.0;
  /// Cost of a pair that should be alike and is a whole weight beyond its band (two `within` apart costs
  /// nothing); in a group of n each pair has a share of 1 / (n - 1) of it. Raising makes them more alike,
  /// also where the points show a difference; lowering lets noise drive them apart.
  double together = 1.0;
  /// Sweeps over all shapes at most. A frame that moves little needs three or four. Raising comes nearer to
  /// the optimum after a large movement and costs time in proportion; lowering bounds a frame's cost, and the
  /// following frames finish what it left.
  int sweeps = 40;
};

/// From where points of the skin are to the weights that bring a face's own points there: least squares
/// within [0, 1] and the rules that a file has for the solver (conditions are bounds, the others costs),
/// smoothed from frame to frame. Starts each frame from the last one's answer, which makes it a pure function
/// of the calls. Method: coordinate descent on the 53 weights, which minimises exactly along each and keeps
/// bounds for nothing (Tseng 2001, doi:10.1023/A:1017501703105). Thread: one at a time. No allocation in
/// solve().
class WeightSolver {
 public:
  /// `neutral_m`: the points at neutral, x, y, z of the first, then of the next (size 3V); `shapes_m`: their
  /// displacement per unit weight, 3V x 53; metres, frame H. Errors: mismatch (sizes), out_of_range (numbers
  /// that are not finite, no points, settings below 0). Of `rules` those for the solver are used.
  [[nodiscard]] static Result<WeightSolver> create(Eigen::VectorXd neutral_m, Eigen::MatrixXd shapes_m,
                                                   const RigConstraints& rules = natural_constraints(),
                                                   const WeightSolverSettings& settings = {});

  /// The weights for points at `points_m` (size 3V). `trust` (size V, or empty: all 1) is each point's share
  /// of its weight, 0 to 1; 0, and a place that is not finite, leaves it out. `dt_s`: since the frame before.
  void solve(const Eigen::VectorXd& points_m, std::span<const double> trust, double dt_s,
             BlendshapeWeights& weights);
  /// Begins anew from neutral.
  void reset();
  [[nodiscard]] std::size_t point_count() const { return static_cast<std::size_t>(neutral_mm_.size()) / 3; }

 private:
  WeightSolver() = default;
  void weigh(const Eigen::VectorXd& points_m, std::span<const double> trust);
  double sweep(double smooth);
  /// The most that a condition allows its shape at the weights of now.
  [[nodiscard]] double most_of(std::size_t condition) const;

  WeightSolverSettings settings_;
  /// Another shape of a group.
  struct Alike {
    Eigen::Index other;
    double share;  // Of the cost.
    double free;   // Apart by so much costs nothing.
  };
  /// The shapes that each excludes, those that it is like, and the conditions (of conditions_) that bound it.
  struct Sides {
    std::vector<Eigen::Index> exclusive;
    std::vector<Alike> together;
    bool banded = false;  // Some of `together` may be apart for nothing.
    std::vector<std::size_t> conditions;
  };
  /// The best weight of shape k between 0 and `most`; where it is now its other costs have this slope and
  /// curve.
  [[nodiscard]] double best_banded(Eigen::Index k, double slope, double curve, double most) const;

  std::vector<Condition> conditions_;
  std::array<Sides, kShapeCount> sides_;
  Eigen::VectorXd neutral_mm_;
  Eigen::MatrixXd shapes_mm_;  // 3V x 53.
  Eigen::MatrixXd normal_;     // 53 x 53, of the trust in force.
  std::vector<double> trust_;
  Eigen::VectorXd weighted_mm_;  // Trusted residual of a frame; its memory.
  Eigen::VectorXd target_;       // 53.
  Eigen::VectorXd weights_;
  Eigen::VectorXd before_;
  Eigen::VectorXd fitted_;  // normal_ * weights_, kept up to date.
};

}  // namespace mien::face
