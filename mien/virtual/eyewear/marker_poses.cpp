#include "mien/virtual/eyewear/marker_poses.h"

#include <algorithm>
#include <array>

#include "mien/builtin_face/builtin_face.h"
#include "mien/eyewear/marker_model.h"
#include "mien/performer/performer.h"
#include "mien/performer/script.h"
#include "mien/performer/style.h"

namespace mien::virt {
namespace {

constexpr std::size_t kEveryFrames = 6;  // Ten a second.

}  // namespace

Result<MarkerPoses> MarkerPoses::measure(const builtin_face::MarkerSet& markers, double seconds,
                                         const Random& random) {
  if (!(seconds >= 10))
    return fail(ErrorCode::bad_usage, "ten seconds are the least that poses are learnt from", "target poses");
  MIEN_TRY_ASSIGN(const builtin_face::PlacedMarkers placed,
                  builtin_face::PlacedMarkers::place(builtin_face::make_builtin(), markers));
  performer::Script script;
  for (const performer::Block block :
       {performer::Block::expressions, performer::Block::range_of_motion, performer::Block::reading})
    for (performer::Segment& segment : performer::default_script(block, seconds / 3).segments)
      script.segments.push_back(std::move(segment));
  Random person = random.fork("person");
  const face::Motion motion =
      performer::perform(script, performer::draw_style(person), random.fork("motion"));

  const auto rows = static_cast<Eigen::Index>((motion.frames.size() + kEveryFrames - 1) / kEveryFrames);
  Eigen::MatrixXd seen(rows, 3 * static_cast<Eigen::Index>(placed.count()));
  Eigen::MatrixXd weights(rows, static_cast<Eigen::Index>(face::kShapeCount));
  for (Eigen::Index i = 0; i < rows; ++i) {
    const face::BlendshapeWeights& w = motion.frames[static_cast<std::size_t>(i) * kEveryFrames].weights;
    seen.row(i) = placed.at(w).transpose();
    for (std::size_t k = 0; k < face::kShapeCount; ++k) weights(i, static_cast<Eigen::Index>(k)) = w[k];
  }
  // The model's basis is what is wanted; the regression onto weights uses the same least squares.
  MIEN_TRY_ASSIGN(const eyewear::MarkerModel components,
                  eyewear::MarkerModel::fit(Eigen::MatrixXd::Zero(rows, 1), seen,
                                            {.components = static_cast<int>(kPoseComponents)}));
  const Eigen::MatrixXd scores = (seen.rowwise() - components.mean().transpose()) * components.basis();
  MarkerPoses poses;
  poses.share_ = components.share();
  poses.mean_weights_ = weights.colwise().mean().transpose();
  const Eigen::MatrixXd centred = weights.rowwise() - poses.mean_weights_.transpose();
  poses.weights_.resize(weights.cols(), scores.cols());
  for (Eigen::Index c = 0; c < scores.cols(); ++c) {
    poses.weights_.col(c) =
        centred.transpose() * scores.col(c) / std::max(scores.col(c).squaredNorm(), 1e-300);
    poses.levels_.push_back({scores.col(c).minCoeff(), 0.0, scores.col(c).maxCoeff()});
  }
  return poses;
}

face::BlendshapeWeights MarkerPoses::pose(std::span<const Level> levels) const {
  Eigen::VectorXd sum = mean_weights_;
  for (std::size_t c = 0; c < std::min(levels.size(), levels_.size()); ++c)
    sum += levels_[c][static_cast<std::size_t>(levels[c])] * weights_.col(static_cast<Eigen::Index>(c));
  face::BlendshapeWeights weights;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    weights[k] = static_cast<float>(std::clamp(sum[static_cast<Eigen::Index>(k)], 0.0, 1.0));
  return weights;
}

face::BlendshapeWeights MarkerPoses::draw(Random& random) const {
  std::array<Level, kPoseComponents> levels{};
  for (Level& level : levels) level = static_cast<Level>(random.below(3));
  return pose(levels);
}

}  // namespace mien::virt
