#include "mien/face/weight_solver.h"

#include <algorithm>
#include <cmath>

#include "mien/core/time.h"
#include "mien/core/units.h"

namespace mien::face {
namespace {

/// A sweep in which no weight moves by more has nothing left to do.
constexpr double kDone = 5e-4;

}  // namespace

Result<WeightSolver> WeightSolver::create(Eigen::VectorXd neutral_m, Eigen::MatrixXd shapes_m,
                                          const RigConstraints& rules, const WeightSolverSettings& settings) {
  if (neutral_m.size() == 0 || neutral_m.size() % 3 != 0 || shapes_m.rows() != neutral_m.size() ||
      shapes_m.cols() != static_cast<Eigen::Index>(kShapeCount))
    return fail(ErrorCode::mismatch, "the points and what the shapes do to them are not of one size",
                "weight solver");
  if (!neutral_m.allFinite() || !shapes_m.allFinite())
    return fail(ErrorCode::out_of_range, "a point that is not finite", "weight solver");
  for (const double cost : {settings.rest, settings.smooth, settings.exclusive, settings.together})
    if (!(cost >= 0) || !std::isfinite(cost))
      return fail(ErrorCode::out_of_range, "a setting below 0, or not finite", "weight solver");
  WeightSolver solver;
  solver.settings_ = settings;
  const RuleSet& solve = rules.solve();
  solver.conditions_ = solve.conditions;
  const auto index = [](std::size_t shape) { return static_cast<Eigen::Index>(shape); };
  for (const ExclusivePair& pair : solve.exclusive) {
    solver.sides_[pair.a].exclusive.push_back(index(pair.b));
    solver.sides_[pair.b].exclusive.push_back(index(pair.a));
  }
  for (const TogetherGroup& group : solve.together)
    for (const std::size_t a : group.shapes) {
      Sides& sides = solver.sides_[a];
      sides.banded = sides.banded || group.within > 0;
      const double share = 1 / static_cast<double>(group.shapes.size() - 1);
      for (const std::size_t b : group.shapes)
        if (a != b) sides.together.push_back({index(b), share, 2 * static_cast<double>(group.within)});
    }
  for (std::size_t i = 0; i < solve.conditions.size(); ++i)
    solver.sides_[solve.conditions[i].a].conditions.push_back(i);
  solver.neutral_mm_ = kMmPerM * neutral_m;
  solver.shapes_mm_ = kMmPerM * shapes_m;
  const auto shapes = static_cast<Eigen::Index>(kShapeCount);
  solver.weighted_mm_ = Eigen::VectorXd::Zero(neutral_m.size());
  solver.target_ = solver.weights_ = solver.before_ = solver.fitted_ = Eigen::VectorXd::Zero(shapes);
  solver.normal_ = Eigen::MatrixXd::Zero(shapes, shapes);
  solver.trust_.assign(solver.point_count(), 0.0);
  return solver;
}

void WeightSolver::reset() {
  weights_.setZero();
  fitted_.setZero();
}

/// The normal matrix changes only when points come and go.
void WeightSolver::weigh(const Eigen::VectorXd& points_m, std::span<const double> trust) {
  bool changed = false;
  for (std::size_t i = 0; i < trust_.size(); ++i) {
    const bool there = points_m.segment<3>(static_cast<Eigen::Index>(3 * i)).allFinite();
    const double now = there && i < trust.size() ? std::clamp(trust[i], 0.0, 1.0) : there && trust.empty();
    changed = changed || trust_[i] != now;
    trust_[i] = now;
  }
  if (!changed) return;
  normal_.setZero();
  for (std::size_t i = 0; i < trust_.size(); ++i) {
    if (trust_[i] == 0) continue;
    const auto rows = shapes_mm_.middleRows<3>(static_cast<Eigen::Index>(3 * i));
    normal_.noalias() += trust_[i] * rows.transpose() * rows;
  }
  fitted_.noalias() = normal_ * weights_;
}

double WeightSolver::most_of(std::size_t condition) const {
  const Condition& rule = conditions_[condition];
  return rule.most(weights_[static_cast<Eigen::Index>(rule.b)]);
}

double WeightSolver::best_banded(Eigen::Index k, double slope, double curve, double most) const {
  const auto slope_at = [&](double weight) {
    double sum = slope + curve * (weight - weights_[k]);
    for (const Alike& alike : sides_[static_cast<std::size_t>(k)].together) {
      const double apart = weight - weights_[alike.other];
      sum += settings_.together * alike.share * (apart - std::clamp(apart, -alike.free, alike.free));
    }
    return sum;
  };
  // The slope never falls, so the best is where it becomes 0.
  if (slope_at(0) >= 0) return 0;
  if (slope_at(most) <= 0) return most;
  double low = 0, high = most;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (slope_at(middle) > 0 ? high : low) = middle;
  }
  return low;
}

/// One pass over the shapes; returns the largest change.
double WeightSolver::sweep(double smooth) {
  double largest = 0;
  for (Eigen::Index k = 0; k < weights_.size(); ++k) {
    double slope =
        fitted_[k] - target_[k] + settings_.rest * weights_[k] + smooth * (weights_[k] - before_[k]);
    double curve = normal_(k, k) + settings_.rest + smooth;
    double most = 1;
    const Sides& sides = sides_[static_cast<std::size_t>(k)];
    for (const Eigen::Index other : sides.exclusive) slope += settings_.exclusive * weights_[other];
    for (const std::size_t i : sides.conditions) most = std::min(most, most_of(i));
    double next = 0;
    if (sides.banded) {
      next = best_banded(k, slope, curve, most);
    } else {
      for (const Alike& alike : sides.together) {
        slope += settings_.together * alike.share * (weights_[k] - weights_[alike.other]);
        curve += settings_.together * alike.share;
      }
      if (!(curve > 0)) continue;  // Nobody sees this shape, and nothing holds it.
      next = std::clamp(weights_[k] - slope / curve, 0.0, most);
    }
    const double change = next - weights_[k];
    if (change == 0) continue;
    weights_[k] = next;
    fitted_.noalias() += change * normal_.col(k);
    largest = std::max(largest, std::abs(change));
  }
  return largest;
}

void WeightSolver::solve(const Eigen::VectorXd& points_m, std::span<const double> trust, double dt_s,
                         BlendshapeWeights& weights) {
  weigh(points_m, trust);
  for (std::size_t i = 0; i < trust_.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    if (trust_[i] > 0)
      weighted_mm_.segment<3>(at) =
          trust_[i] * (kMmPerM * points_m.segment<3>(at) - neutral_mm_.segment<3>(at));
    else
      weighted_mm_.segment<3>(at).setZero();
  }
  target_.noalias() = shapes_mm_.transpose() * weighted_mm_;
  before_ = weights_;
  // The longer ago the frame before was, the less it says.
  const double frames = std::max(dt_s * kFrameRateHz, 1e-3);
  const double smooth = settings_.smooth / frames;
  for (int i = 0; i < settings_.sweeps; ++i)
    if (sweep(smooth) < kDone) break;
  // A shape that another may not exceed has moved last: its bound holds at the end too.
  for (std::size_t i = 0; i < conditions_.size(); ++i) {
    const auto a = static_cast<Eigen::Index>(conditions_[i].a);
    const double over = weights_[a] - most_of(i);
    if (over <= 0) continue;
    weights_[a] -= over;
    fitted_.noalias() -= over * normal_.col(a);
  }
  for (std::size_t k = 0; k < kShapeCount; ++k)
    weights[k] = static_cast<float>(weights_[static_cast<Eigen::Index>(k)]);
}

}  // namespace mien::face
