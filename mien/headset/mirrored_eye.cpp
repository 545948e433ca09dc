#include "mien/headset/mirrored_eye.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace mien::headset {
namespace {

constexpr double kShrinkage = 0.01;

using Column = Eigen::Map<const Eigen::VectorXf>;

Eigen::VectorXd mean_of(std::span<const std::vector<float>> all) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(all.front().size()));
  for (const std::vector<float>& one : all) sum += Column(one.data(), sum.size()).cast<double>();
  return sum / static_cast<double>(all.size());
}

void add_spread(std::span<const std::vector<float>> all, const Eigen::VectorXd& mean, Eigen::MatrixXd& sum) {
  for (const std::vector<float>& one : all) {
    const Eigen::VectorXd off = Column(one.data(), mean.size()).cast<double>() - mean;
    sum.selfadjointView<Eigen::Lower>().rankUpdate(off);
  }
}

}  // namespace

float MirroredEye::logit(std::span<const float> features) const {
  if (weight.size() != features.size()) return 0;
  float sum = bias;
  for (std::size_t i = 0; i < weight.size(); ++i) sum += weight[i] * features[i];
  return sum;
}

Result<MirroredEye> fit_mirrored_eye(std::span<const std::vector<float>> seen,
                                     std::span<const std::vector<float>> mirrored) {
  if (seen.size() < 2 || mirrored.size() < 2)
    return fail(ErrorCode::bad_usage, "too few eyes to tell mirrored ones by");
  const std::size_t count = seen.front().size();
  for (const auto all : {seen, mirrored})
    if (count == 0 || !std::ranges::all_of(all, [&](const auto& one) { return one.size() == count; }))
      return fail(ErrorCode::bad_usage, "eyes of different numbers of features");
  const Eigen::VectorXd here = mean_of(seen), there = mean_of(mirrored);
  const auto n = static_cast<Eigen::Index>(count);
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(n, n);
  add_spread(seen, here, spread);
  add_spread(mirrored, there, spread);
  spread /= static_cast<double>(seen.size() + mirrored.size() - 2);
  spread.diagonal().array() += kShrinkage * spread.trace() / static_cast<double>(count) + 1e-12;
  const Eigen::VectorXd weight = spread.selfadjointView<Eigen::Lower>().ldlt().solve(there - here);
  MirroredEye made;
  made.bias = static_cast<float>(-0.5 * weight.dot(here + there));
  for (const double value : weight) made.weight.push_back(static_cast<float>(value));
  return made;
}

}  // namespace mien::headset
