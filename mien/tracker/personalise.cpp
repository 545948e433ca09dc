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

/// How people answer prompts, in means and standard deviations: as the design's virtual performers miss
/// theirs (gain 0.6 to 1.2, 0.15 to 0.6 s late, one to three of the other shapes at up to 0.3). Nobody has
/// measured real people's yet.
constexpr double kGainMean = 0.9, kGainSigma = 0.17;
constexpr double kLateFirst_s = 0.15;
/// A shape that nobody asked for, while the expression is held: its mean, and its mean square.
constexpr double kUnaskedMean = 0.007, kUnaskedSquare = 0.0014;
/// Lids close when they like.
constexpr double kBlinkSquare = 0.01;
/// Where nothing is asked.
constexpr double kRestSquare = 1e-5;

/// One sigma of a rotation's noise, rad an axis, and of what slopes that are linear leave.
constexpr double kNoiseRad = 0.02;
/// One frame in three is looked at; neighbouring ones say the same.
constexpr std::size_t kEvery = 3;
/// How unlike the standard skin wearers are, from hardly to very much. Which of these a wearer is, the
/// prompts that were not learnt from decide.
struct Unlikeness {
  double spread;  ///< One sigma of a slope, as a share of how much the shape turns that sensor.
  /// What a frame counts for. A prompt has some fifty frames, all with one gain that nobody knows: the less
  /// they count, the less that gain passes for the skin's.
  double frame_weight;
};
constexpr Unlikeness kUnlike[] = {{0.1, 1.0 / 48}, {0.2, 1.0 / 12}, {0.35, 1.0 / 12}, {0.5, 1.0 / 3}};
/// A slope's least sigma, rad.
constexpr double kSlopeFloor = 0.01;
/// More rounds make every slope smaller than it is: errors in the weights, which only the prompts hold, grow.
constexpr int kRounds = 5;
constexpr std::size_t kPromptsAHeldOut = 4;

/// How far an expression is reached `since_s` after it was asked for: mean and mean square over how late
/// people are.
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

/// One frame to learn from: what the sensors said, and what is known of the weights beforehand.
struct Frame {
  VectorXd turn;             // 3n, rad; of missing sensors 0.
  std::vector<Index> there;  // Its rows that were there.
  VectorXd mean, variance;   // Of the weights.
  std::size_t prompt = 0;
};

/// A frame's answer to one guess of the slopes.
struct Posterior {
  VectorXd weights;
  MatrixXd taken;  // What the sensors took from the prior's covariance.
  double surprise = 0;
};

Posterior answer(const Frame& frame, const MatrixXd& slopes) {
  const auto rows = static_cast<Index>(frame.there.size());
  MatrixXd observation(rows, kShapes);
  VectorXd innovation(rows);
  for (Index i = 0; i < rows; ++i) {
    observation.row(i) = slopes.row(frame.there[static_cast<std::size_t>(i)]);
    innovation[i] = frame.turn[frame.there[static_cast<std::size_t>(i)]] - observation.row(i).dot(frame.mean);
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

/// What a prior of the slopes is: its mean, and one over its variance, entry by entry; and what a frame
/// counts for beside it.
struct SlopePrior {
  MatrixXd mean, precision;
  double frame_weight;
};

SlopePrior prior_around(const MatrixXd& slopes, const Unlikeness& unlike) {
  SlopePrior prior{slopes, MatrixXd(slopes.rows(), slopes.cols()), unlike.frame_weight};
  for (Index s = 0; s < slopes.rows() / 3; ++s)
    for (Index k = 0; k < kShapes; ++k) {
      const double size = slopes.block<3, 1>(3 * s, k).norm() / std::sqrt(3.0);
      const double sigma = std::hypot(unlike.spread * size, kSlopeFloor);
      prior.precision.block<3, 1>(3 * s, k).setConstant(1 / (sigma * sigma));
    }
  return prior;
}

/// The likeliest slopes: expectation-maximisation over frames whose prompt `learnt` says.
MatrixXd learn(const std::vector<Frame>& frames, const SlopePrior& prior,
               const std::vector<std::uint8_t>& learnt) {
  const Index rows = prior.mean.rows();
  const double precision = prior.frame_weight / (kNoiseRad * kNoiseRad);
  MatrixXd slopes = prior.mean;
  for (int round = 0; round < kRounds; ++round) {
    // A sensor that was away from some frames has sums of its own.
    std::vector<MatrixXd> square(static_cast<std::size_t>(rows / 3), MatrixXd::Zero(kShapes, kShapes));
    MatrixXd cross = MatrixXd::Zero(kShapes, rows);
    MatrixXd everywhere = MatrixXd::Zero(kShapes, kShapes);
    for (const Frame& frame : frames) {
      if (learnt[frame.prompt] == 0) continue;
      const Posterior posterior = answer(frame, slopes);
      MatrixXd second = posterior.weights * posterior.weights.transpose();
      second.noalias() -= posterior.taken.transpose() * posterior.taken;
      second.diagonal() += frame.variance;
      const bool all = static_cast<Index>(frame.there.size()) == rows;
      if (all) everywhere += second;
      for (const Index row : frame.there) {
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

/// Mean surprise a row over frames whose prompt was not learnt.
double surprise(const std::vector<Frame>& frames, const MatrixXd& slopes,
                const std::vector<std::uint8_t>& learnt) {
  double sum = 0, rows = 0;
  for (const Frame& frame : frames) {
    if (learnt[frame.prompt] != 0) continue;
    sum += answer(frame, slopes).surprise;
    rows += static_cast<double>(frame.there.size());
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
    // One prompt's end is another's beginning, and both show.
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
      const model::SensorFeature& said = feature.sensors[static_cast<std::size_t>(places[s])];
      const Quat q(said.rotation[0], said.rotation[1], said.rotation[2], said.rotation[3]);
      if (!said.has_rotation || !q.coeffs().allFinite()) continue;
      frame.turn.segment<3>(3 * static_cast<Index>(s)) = log_rotation(q);
      for (Index axis = 0; axis < 3; ++axis) frame.there.push_back(3 * static_cast<Index>(s) + axis);
    }
    if (!frame.there.empty()) frames.push_back(std::move(frame));
  }
  return frames;
}

/// Which prompts are learnt from while the rest, whose shapes these ask for too, tell how well: 1 each.
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
  report.surprise_before = surprise(frames, before, learnt);
  report.surprise_after = std::numeric_limits<double>::infinity();
  Unlikeness best = kUnlike[0];
  for (const Unlikeness& unlike : kUnlike) {
    const double after = surprise(frames, learn(frames, prior_around(before, unlike), learnt), learnt);
    if (!(after < report.surprise_after)) continue;
    report.surprise_after = after;
    best = unlike;
  }
  report.taken = report.surprise_after < report.surprise_before;
  if (!report.taken) return report;
  std::ranges::fill(learnt, std::uint8_t{1});
  const RowMajor after = learn(frames, prior_around(before, best), learnt).cast<float>();
  skin.wearer.assign(after.data(), after.data() + after.size());
  return report;
}

}  // namespace mien::tracker
