#include "mien/tracker/personalise.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "mien/core/minimum_jerk.h"
#include "mien/core/rotation.h"
#include "mien/sensor/sensor_places.h"

namespace mien::tracker {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
constexpr auto kShapes = static_cast<Index>(face::kShapeCount);

/// Prior of how people answer prompts, as the virtual performers do (gain 0.6 to 1.2, 0.15 to 0.6 s late, one
/// to three other shapes at up to 0.3). Not measured on real people yet.
constexpr double kGainMean = 0.9, kGainSigma = 0.17;
constexpr double kLateFirst_s = 0.15;
/// Mean and mean square of a shape that was not asked for, while the expression is held.
constexpr double kUnaskedMean = 0.007, kUnaskedSquare = 0.0014;
/// Additional variance of the lids: spontaneous blinks.
constexpr double kBlinkSquare = 0.01;
/// Variance of all weights where nothing is asked for.
constexpr double kRestSquare = 1e-5;

/// Standard deviation of a rotation's noise and of the linear model's residual, rad an axis.
constexpr double kNoiseRad = 0.02;
/// One frame in three is used; neighbouring ones carry the same information.
constexpr std::size_t kEvery = 3;
/// Candidate priors of how far a wearer's skin is from the standard; the held-out prompts select one.
struct SkinPrior {
  double spread;  ///< Standard deviation of a slope, as a share of the standard slope's size.
  /// Weight of a frame. A prompt's fifty or so frames share one unknown gain: the lower the weight, the less
  /// that gain is attributed to the skin.
  double frame_weight;
};
constexpr SkinPrior kSkinPriors[] = {{0.1, 1.0 / 48}, {0.2, 1.0 / 12}, {0.35, 1.0 / 12}, {0.5, 1.0 / 3}};
/// Least standard deviation of a slope, rad.
constexpr double kSlopeFloor = 0.01;
/// Rounds of expectation-maximisation. More shrink every slope: errors of the weights, held by the prompts
/// alone, grow.
constexpr int kRounds = 5;
constexpr std::size_t kPromptsAHeldOut = 4;

/// How far an expression is reached `since_s` after its begin: mean and mean square over people's latency.
struct Reach {
  double mean = 0, square = 0;
};

Reach reach(const PromptedExpression& prompt, double since_s) {
  constexpr int kLatenesses = 16;
  const double length_s = to_seconds(prompt.end - prompt.begin);
  const double hold_s = prompt.held ? length_s - prompt.rise_s : std::max(0.1, length_s - 3 * prompt.rise_s);
  Reach out;
  for (int i = 0; i < kLatenesses; ++i) {
    const double late_s = kLateFirst_s + (kLatestAnswer_s - kLateFirst_s) * (i + 0.5) / kLatenesses;
    const double rise_s = prompt.rise_s, at = since_s - late_s;
    const double reached = minimum_jerk(at / rise_s) * (1 - minimum_jerk((at - rise_s - hold_s) / rise_s));
    out.mean += reached / kLatenesses;
    out.square += reached * reached / kLatenesses;
  }
  return out;
}

/// One frame to learn from: the sensors' rotations, and the prior of the weights.
struct Frame {
  VectorXd turn;               // Rotation vectors, 3n, rad; 0 for missing sensors.
  std::vector<Index> present;  // Rows of present sensors.
  VectorXd mean, variance;     // Prior of the weights.
  std::size_t prompt = 0;
};

/// Posterior of a frame's weights, given slopes.
struct Posterior {
  VectorXd weights;
  MatrixXd taken;  // Posterior covariance = prior - taken^T taken.
  double surprise = 0;
};

Posterior posterior_of(const Frame& frame, const MatrixXd& slopes) {
  const auto rows = static_cast<Index>(frame.present.size());
  MatrixXd observation(rows, kShapes);
  VectorXd innovation(rows);
  for (Index i = 0; i < rows; ++i) {
    observation.row(i) = slopes.row(frame.present[static_cast<std::size_t>(i)]);
    innovation[i] =
        frame.turn[frame.present[static_cast<std::size_t>(i)]] - observation.row(i).dot(frame.mean);
  }
  const MatrixXd cross = observation * frame.variance.asDiagonal();
  MatrixXd spread = cross * observation.transpose();
  spread.diagonal().array() += kNoiseRad * kNoiseRad;
  const Eigen::LLT<MatrixXd> factor(spread);
  const VectorXd solved = factor.solve(innovation);
  Posterior out;
  out.weights = frame.mean + cross.transpose() * solved;
  out.taken = factor.matrixL().solve(cross);
  const double log_determinant = 2 * MatrixXd(factor.matrixL()).diagonal().array().log().sum();
  out.surprise = 0.5 * (innovation.dot(solved) + log_determinant +
                        static_cast<double>(rows) * std::log(2 * std::numbers::pi));
  return out;
}

/// Prior of the slopes: mean and inverse variance of each; and a frame's weight against it.
struct SlopePrior {
  MatrixXd mean, precision;
  double frame_weight;
};

SlopePrior prior_around(const MatrixXd& slopes, const SkinPrior& candidate) {
  SlopePrior prior{slopes, MatrixXd(slopes.rows(), slopes.cols()), candidate.frame_weight};
  for (Index s = 0; s < slopes.rows() / 3; ++s)
    for (Index k = 0; k < kShapes; ++k) {
      const double size = slopes.block<3, 1>(3 * s, k).norm() / std::sqrt(3.0);
      const double sigma = std::hypot(candidate.spread * size, kSlopeFloor);
      prior.precision.block<3, 1>(3 * s, k).setConstant(1 / (sigma * sigma));
    }
  return prior;
}

/// Maximum a posteriori slopes: expectation-maximisation over the frames of the prompts in `learnt`.
MatrixXd learn(const std::vector<Frame>& frames, const SlopePrior& prior,
               const std::vector<std::uint8_t>& learnt) {
  const Index rows = prior.mean.rows();
  const double precision = prior.frame_weight / (kNoiseRad * kNoiseRad);
  MatrixXd slopes = prior.mean;
  for (int round = 0; round < kRounds; ++round) {
    // Sensors missing in some frames have sums of their own.
    std::vector<MatrixXd> square(static_cast<std::size_t>(rows / 3), MatrixXd::Zero(kShapes, kShapes));
    MatrixXd cross = MatrixXd::Zero(kShapes, rows);
    MatrixXd everywhere = MatrixXd::Zero(kShapes, kShapes);
    for (const Frame& frame : frames) {
      if (learnt[frame.prompt] == 0) continue;
      const Posterior posterior = posterior_of(frame, slopes);
      MatrixXd second = posterior.weights * posterior.weights.transpose();
      second.noalias() -= posterior.taken.transpose() * posterior.taken;
      second.diagonal() += frame.variance;
      const bool all = static_cast<Index>(frame.present.size()) == rows;
      if (all) everywhere += second;
      for (const Index row : frame.present) {
        cross.col(row) += posterior.weights * frame.turn[row];
        if (!all && row % 3 == 0) square[static_cast<std::size_t>(row / 3)] += second;
      }
    }
    for (Index row = 0; row < rows; ++row) {
      MatrixXd information = precision * (everywhere + square[static_cast<std::size_t>(row / 3)]);
      information.diagonal() += prior.precision.row(row).transpose();
      const VectorXd right =
          precision * cross.col(row) + prior.precision.row(row).cwiseProduct(prior.mean.row(row)).transpose();
      slopes.row(row) = information.llt().solve(right).transpose();
    }
  }
  return slopes;
}

/// Mean negative log likelihood a row over the frames of held-out prompts.
double mean_surprise(const std::vector<Frame>& frames, const MatrixXd& slopes,
                     const std::vector<std::uint8_t>& learnt) {
  double sum = 0, rows = 0;
  for (const Frame& frame : frames) {
    if (learnt[frame.prompt] != 0) continue;
    sum += posterior_of(frame, slopes).surprise;
    rows += static_cast<double>(frame.present.size());
  }
  return rows > 0 ? sum / rows : 0;
}

/// The frames of the prompts, in the model's order of sensors.
std::vector<Frame> frames_of(std::span<const model::FeatureFrame> features,
                             std::span<const PromptedExpression> prompts,
                             const std::vector<std::ptrdiff_t>& places) {
  constexpr Duration kLate = from_seconds(kLatestAnswer_s);
  std::vector<Frame> frames;
  std::size_t seen = 0;
  for (const model::FeatureFrame& feature : features) {
    Frame frame;
    frame.mean = VectorXd::Zero(kShapes);
    frame.variance = VectorXd::Constant(kShapes, kRestSquare);
    std::optional<std::size_t> prompt;
    // Where prompts overlap, by latency, both contribute.
    for (std::size_t p = 0; p < prompts.size(); ++p) {
      if (feature.time < prompts[p].begin || feature.time >= prompts[p].end + kLate) continue;
      prompt = p;
      const Reach reached = reach(prompts[p], to_seconds(feature.time - prompts[p].begin));
      for (Index k = 0; k < kShapes; ++k) {
        const double target = prompts[p].target[static_cast<std::size_t>(k)];
        const double mean = target > 0 ? target * kGainMean * reached.mean : kUnaskedMean * reached.mean;
        const double square =
            target > 0 ? target * target * (kGainMean * kGainMean + kGainSigma * kGainSigma) * reached.square
                       : kUnaskedSquare * reached.square;
        frame.mean[k] += mean;
        frame.variance[k] += square - (target > 0 ? mean * mean : 0);
      }
    }
    if (!prompt || seen++ % kEvery != 0) continue;
    for (const std::size_t lid : {face::shape("eyeBlink_L"), face::shape("eyeBlink_R")})
      frame.variance[static_cast<Index>(lid)] += kBlinkSquare;
    frame.prompt = *prompt;
    frame.turn = VectorXd::Zero(3 * static_cast<Index>(places.size()));
    for (std::size_t s = 0; s < places.size(); ++s) {
      if (places[s] < 0) continue;
      const model::SensorFeature& measured = feature.sensors[static_cast<std::size_t>(places[s])];
      const Quat q = quat_of(measured.rotation);
      if (!measured.has_rotation || !q.coeffs().allFinite()) continue;
      frame.turn.segment<3>(3 * static_cast<Index>(s)) = log_rotation(q);
      for (Index axis = 0; axis < 3; ++axis) frame.present.push_back(3 * static_cast<Index>(s) + axis);
    }
    if (!frame.present.empty()) frames.push_back(std::move(frame));
  }
  return frames;
}

/// 1 for prompts to learn from, 0 for held-out ones, whose shapes the former ask for too.
std::vector<std::uint8_t> without_held_out(std::span<const PromptedExpression> prompts,
                                           const std::vector<std::uint8_t>& shown) {
  std::vector<int> asked(face::kShapeCount, 0);
  const auto ask = [&](const PromptedExpression& prompt, int change) {
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      if (prompt.target[k] > 0) asked[k] += change;
  };
  std::size_t count = 0, held_out = 0;
  for (std::size_t p = 0; p < prompts.size(); ++p)
    if (shown[p] != 0) ask(prompts[p], 1), ++count;
  std::vector<std::uint8_t> learnt = shown;
  for (std::size_t p = 0; p < prompts.size() && kPromptsAHeldOut * (held_out + 1) <= count; ++p) {
    if (shown[p] == 0) continue;
    ask(prompts[p], -1);
    bool others = true;
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      others = others && (prompts[p].target[k] == 0 || asked[k] > 0);
    if (others) {
      learnt[p] = 0;
      ++held_out;
    } else {
      ask(prompts[p], 1);
    }
  }
  return learnt;
}

}  // namespace

Result<Personalisation> personalise(std::span<const model::FeatureFrame> features,
                                    std::span<const PromptedExpression> prompts,
                                    const std::vector<std::string>& rig_sensors, model::ModelFile& file) {
  if (!file.skin)
    return fail(ErrorCode::unsupported, "this model knows no skin that it could be brought to", "model file",
                "use one that can be personalised, such as models/live.safetensors");
  if (!std::ranges::equal(file.shapes, face::kShapeNames) ||
      file.skin->standard.size() != 3 * file.features.sensors.size() * face::kShapeCount)
    return fail(ErrorCode::mismatch, "the model's outputs are not the 53 ICT shapes in their order",
                "model file", "train it with this version of Mien");
  const std::vector<std::ptrdiff_t> places = sensor::sensor_places(file.features.sensors, rig_sensors);
  if (sensor::none_placed(places))
    return fail(ErrorCode::mismatch, "the rig has none of the model's sensors", "model file",
                "use a model that was trained for this rig");
  const std::vector<Frame> frames = frames_of(features, prompts, places);
  std::vector<std::uint8_t> shown(prompts.size(), 0);
  for (const Frame& frame : frames) shown[frame.prompt] = 1;
  Personalisation report;
  report.frames = frames.size();
  report.prompts = static_cast<std::size_t>(std::ranges::count(shown, 1));
  if (report.prompts < kLeastPrompts)
    return fail(ErrorCode::not_found,
                fmt::format("only {} prompted expressions with sensors are there to learn a wearer from",
                            report.prompts),
                "personalise",
                "record a full prologue (mien perform --prologue full, mien record --prompts)");

  model::Skin& skin = *file.skin;
  const MatrixXd before =
      Eigen::Map<const RowMajor>(skin.standard.data(), 3 * static_cast<Index>(places.size()), kShapes)
          .cast<double>();
  std::vector<std::uint8_t> learnt = without_held_out(prompts, shown);
  if (learnt == shown)
    return fail(ErrorCode::not_found, "no expression is asked for twice, so what is learnt cannot be judged",
                "personalise",
                "record a full prologue (mien perform --prologue full, mien record --prompts)");
  report.surprise_before = mean_surprise(frames, before, learnt);
  report.surprise_after = std::numeric_limits<double>::infinity();
  SkinPrior best = kSkinPriors[0];
  for (const SkinPrior& candidate : kSkinPriors) {
    const double after =
        mean_surprise(frames, learn(frames, prior_around(before, candidate), learnt), learnt);
    if (!(after < report.surprise_after)) continue;
    report.surprise_after = after;
    best = candidate;
  }
  report.taken = report.surprise_after < report.surprise_before;
  if (!report.taken) return report;
  std::ranges::fill(learnt, std::uint8_t{1});
  const RowMajor after = learn(frames, prior_around(before, best), learnt).cast<float>();
  skin.wearer.assign(after.data(), after.data() + after.size());
  // It belongs to the skin that it was learnt with.
  file.correction.reset();
  return report;
}

}  // namespace mien::tracker
