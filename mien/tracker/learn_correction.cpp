#include "mien/tracker/learn_correction.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "mien/core/random.h"
#include "mien/core/time.h"
#include "mien/tracker/causal_tracker.h"
#include "mien/tracker/worn_anew.h"

namespace mien::tracker {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of this frame, and of a twentieth and about a seventh of a second ago.
constexpr std::array<std::size_t, 3> kLags = {0, 3, 9};
constexpr auto kAnswers = static_cast<Index>(face::kShapeCount);
constexpr Index kInputs = static_cast<Index>(kLags.size()) * kAnswers;
/// How often the performance is worn anew. More cost time and change little.
constexpr std::size_t kWearings = 12;
/// Stretches of the cross-validation. Neighbouring frames are alike, so a stretch is held out as one ...
constexpr std::size_t kStretches = 8;
/// ... of which one frame in so many is judged, and no more than these are learnt from: five minutes' worth.
constexpr std::size_t kJudgedEvery = 3;
constexpr std::size_t kMostFrames = 18'000;
/// Candidate weights of the prior, a share of the frames that are learnt from.
constexpr std::array kRidges = {1e-2, 3e-2, 1e-1, 3e-1, 1.0, 3.0, 10.0};
/// Of that, what is an ordinary ridge on inputs of unit variance; the rest is the general face's.
constexpr double kRidge = 0.3;
/// An input of a shape that hardly moves is not made large: added to its standard deviation.
constexpr double kScaleFloor = 1e-2;
/// A frame counts by the reciprocal of its skin's error and so much, mm: then it is the mean error that
/// becomes least, and not that of the widest expressions.
constexpr double kUsualError_mm = 0.3;
/// The largest ridge is taken that has all but this share of the best one's gain: another day differs by more
/// than the wearings that are drawn.
constexpr double kGainGivenUp = 0.1;
/// A shape's error must become smaller by this share, and by so many standard errors of its mean over the
/// stretches: what one stretch alone taught, the next one unlearns.
constexpr double kLeastGain = 0.02, kSure = 1.5;

using Answers = std::vector<face::BlendshapeWeights>;

/// Weighted sums of a regression.
struct Sums {
  MatrixXd inputs = MatrixXd::Zero(kInputs, kInputs);
  MatrixXd cross = MatrixXd::Zero(kInputs, kAnswers);
  VectorXd squares = VectorXd::Zero(kInputs);  // Of the inputs, unweighted.
  double weight = 0, frames = 0;

  void add(const MatrixXd& more_inputs, const MatrixXd& residuals, const VectorXd& weights) {
    const MatrixXd weighted = weights.asDiagonal() * more_inputs;
    inputs.noalias() += weighted.transpose() * more_inputs;
    cross.noalias() += weighted.transpose() * residuals;
    squares += more_inputs.colwise().squaredNorm().transpose();
    weight += weights.sum();
    frames += static_cast<double>(more_inputs.rows());
  }
  void add(const Sums& other, double sign = 1) {
    inputs += sign * other.inputs;
    cross += sign * other.cross;
    squares += sign * other.squares;
    weight += sign * other.weight;
    frames += sign * other.frames;
  }
};

/// From inputs to residuals. `prior`: second moment of the inputs over which the residuals are to be nothing,
/// as heavy as `penalty` times the frames that are learnt from.
MatrixXd ridge_map(const Sums& sums, const MatrixXd& prior, double penalty) {
  return (sums.inputs / sums.weight + penalty * prior).ldlt().solve(sums.cross / sums.weight);
}

/// Second moment of answers of now and before over people in general: of the training set's weights, where
/// the model knows it (Skin::covariance). A face changes little in three frames, and more in nine.
MatrixXd general_inputs(const model::ModelFile& file) {
  MatrixXd out = MatrixXd::Zero(kInputs, kInputs);
  if (!file.skin) return out;
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const MatrixXd covariance =
      Eigen::Map<const RowMajor>(file.skin->covariance.data(), kAnswers, kAnswers).cast<double>();
  const VectorXd mean = Eigen::Map<const Eigen::VectorXf>(file.mean_pose.data(), kAnswers).cast<double>();
  // Correlations of a weight with itself over the lags; usual of speech.
  constexpr double kAlike[3][3] = {{1, 0.95, 0.8}, {0.95, 1, 0.9}, {0.8, 0.9, 1}};
  for (std::size_t a = 0; a < kLags.size(); ++a)
    for (std::size_t b = 0; b < kLags.size(); ++b)
      out.block(static_cast<Index>(a) * kAnswers, static_cast<Index>(b) * kAnswers, kAnswers, kAnswers) =
          kAlike[a][b] * covariance + mean * mean.transpose();
  return out;
}

/// What two shapes together move: sum over the vertices of the dot product, over their number, mm^2.
MatrixXd skin_metric(const face::Face& face) {
  std::vector<Vec3f> moved(face.neutral_m.size());
  MatrixXd metric = MatrixXd::Zero(kAnswers, kAnswers);
  constexpr double kMm2 = 1e6;
  for (Index a = 0; a < kAnswers; ++a) {
    const face::Shape& first = face.shapes[static_cast<std::size_t>(a)];
    std::ranges::fill(moved, Vec3f::Zero());
    for (std::size_t i = 0; i < first.vertex.size(); ++i) moved[first.vertex[i]] = first.delta_m[i];
    for (Index b = 0; b <= a; ++b) {
      const face::Shape& second = face.shapes[static_cast<std::size_t>(b)];
      double sum = 0;
      for (std::size_t i = 0; i < second.vertex.size(); ++i)
        sum += double{moved[second.vertex[i]].dot(second.delta_m[i])};
      metric(a, b) = metric(b, a) = kMm2 * sum / static_cast<double>(face.neutral_m.size());
    }
  }
  return metric;
}

/// Root mean square of each row's vertex errors, mm.
VectorXd skin_errors(const MatrixXd& residuals, const MatrixXd& metric) {
  return (residuals * metric).cwiseProduct(residuals).rowwise().sum().cwiseMax(0).cwiseSqrt();
}

/// What is left of frames that a map was not fitted to.
struct Judgement {
  double skin_mm = 0;                           // Mean over the frames.
  VectorXd squares = VectorXd::Zero(kAnswers);  // Of each shape, likewise.
  // The same of each stretch alone, a column each.
  MatrixXd by_stretch = MatrixXd::Zero(kAnswers, static_cast<Index>(kStretches));
  [[nodiscard]] double mse() const { return squares.mean(); }
};

/// Whether what a shape gains in each stretch is beyond chance. `before`: what it may gain.
bool is_gain(const Eigen::RowVectorXd& gains, double before) {
  const double mean = gains.mean(), count = static_cast<double>(gains.size());
  const double deviation = std::sqrt((gains.array() - mean).square().sum() / (count - 1));
  return mean > kLeastGain * before && mean > kSure * deviation / std::sqrt(count);
}

/// The frames that are learnt from, stretch after stretch, and what the model answers in every wearing.
class Lessons {
 public:
  Lessons(std::span<const TaughtFrame> taught, MatrixXd metric, MatrixXd general)
      : taught_(taught), metric_(std::move(metric)), general_(std::move(general)) {
    std::vector<std::size_t> known;
    for (std::size_t f = 0; f < taught.size(); ++f)
      if (taught[f].known) known.push_back(f);
    const std::size_t every = known.size() / kMostFrames + 1;
    for (std::size_t i = 0; i < known.size(); i += every)
      frames_[i * kStretches / known.size()].push_back(known[i]);
  }

  /// One more wearing; the first is as the sensors were worn.
  void add(const Answers& answers) {
    for (std::size_t s = 0; s < kStretches; ++s) {
      const MatrixXd residuals = residuals_of(answers, frames_[s]);
      const VectorXd weights = (skin_errors(residuals, metric_).array() + kUsualError_mm).inverse().matrix();
      sums_[s].add(inputs_of(answers, frames_[s]), residuals, weights);
    }
    wearings_.push_back(answers);
  }

  [[nodiscard]] MatrixXd fitted(double penalty) const { return fitted_without(kStretches, penalty); }
  /// Held-out errors of the first `wearings`, with this ridge; none: of the answers as they are. Shapes that
  /// are not corrected are named.
  [[nodiscard]] Judgement judged(std::optional<double> penalty, std::size_t wearings,
                                 const std::vector<Index>& uncorrected = {}) const {
    Judgement out;
    double count = 0;
    for (std::size_t s = 0; s < kStretches; ++s) {
      MatrixXd map = penalty ? fitted_without(s, *penalty) : MatrixXd();
      if (penalty)
        for (const Index k : uncorrected) map.col(k).setZero();
      std::vector<std::size_t> frames;
      for (std::size_t i = 0; i < frames_[s].size(); i += kJudgedEvery) frames.push_back(frames_[s][i]);
      for (std::size_t w = 0; w < wearings; ++w) {
        MatrixXd residuals = residuals_of(wearings_[w], frames);
        if (penalty) residuals.noalias() -= inputs_of(wearings_[w], frames) * map;
        out.skin_mm += skin_errors(residuals, metric_).sum();
        out.by_stretch.col(static_cast<Index>(s)) += residuals.colwise().squaredNorm().transpose();
        count += static_cast<double>(residuals.rows());
      }
    }
    out.skin_mm /= count;
    // Stretches are of one length.
    out.by_stretch *= static_cast<double>(kStretches) / count;
    out.squares = out.by_stretch.rowwise().mean();
    return out;
  }
  [[nodiscard]] std::size_t wearings() const { return wearings_.size(); }

 private:
  [[nodiscard]] MatrixXd residuals_of(const Answers& answers, std::span<const std::size_t> frames) const {
    MatrixXd out(static_cast<Index>(frames.size()), kAnswers);
    for (std::size_t row = 0; row < frames.size(); ++row)
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        out(static_cast<Index>(row), static_cast<Index>(k)) =
            double{taught_[frames[row]].weights[k]} - double{answers[frames[row]][k]};
    return out;
  }
  [[nodiscard]] static MatrixXd inputs_of(const Answers& answers, std::span<const std::size_t> frames) {
    MatrixXd out(static_cast<Index>(frames.size()), kInputs);
    for (std::size_t row = 0; row < frames.size(); ++row)
      for (std::size_t l = 0; l < kLags.size(); ++l) {
        const face::BlendshapeWeights& answer = answers[frames[row] - std::min(frames[row], kLags[l])];
        for (std::size_t k = 0; k < face::kShapeCount; ++k)
          out(static_cast<Index>(row), static_cast<Index>(l * face::kShapeCount + k)) = double{answer[k]};
      }
    return out;
  }
  [[nodiscard]] MatrixXd fitted_without(std::size_t stretch, double penalty) const {
    Sums sums;
    for (const Sums& one : sums_) sums.add(one);
    MatrixXd prior = general_;
    prior.diagonal() +=
        kRidge * ((sums.squares / sums.frames).cwiseSqrt().array() + kScaleFloor).square().matrix();
    if (stretch < kStretches) sums.add(sums_[stretch], -1);
    return ridge_map(sums, prior, penalty);
  }

  std::span<const TaughtFrame> taught_;
  MatrixXd metric_, general_;
  std::array<std::vector<std::size_t>, kStretches> frames_;
  std::array<Sums, kStretches> sums_;
  std::vector<Answers> wearings_;
};

}  // namespace

Result<LearntCorrection> learn_correction(std::span<const model::FeatureFrame> features,
                                          std::span<const TaughtFrame> taught,
                                          const std::vector<std::string>& rig_sensors, const face::Face& face,
                                          model::ModelFile& file, const Progress& progress) {
  if (file.architecture.kind != model::NetworkKind::causal)
    return fail(ErrorCode::unsupported, "a window model's answers cannot be corrected", "model file",
                "use a live model, such as models/live.safetensors");
  LearntCorrection report;
  report.frames = static_cast<std::size_t>(std::ranges::count_if(taught, &TaughtFrame::known));
  if (static_cast<double>(report.frames) < kLeastTaughtS * kFrameRateHz)
    return fail(ErrorCode::not_found,
                fmt::format("only {:.1f} s of truth are there to learn a wearer from",
                            static_cast<double>(report.frames) / kFrameRateHz),
                "personalise",
                fmt::format("record {:.0f} s or more, two minutes for what is possible", kLeastTaughtS));
  model::ModelFile bare = file;
  bare.correction.reset();
  MIEN_TRY_ASSIGN(CausalTracker tracker, CausalTracker::create(bare, rig_sensors));

  Lessons lessons(taught, skin_metric(face), general_inputs(file));
  const std::size_t sensors = rig_sensors.size(), rounds = 1 + sensors + kWearings;
  Answers answers(features.size());
  face::OutputFrame frame;
  model::FeatureFrame worn;
  for (std::size_t round = 0; round < rounds; ++round) {
    if (!progress(0.7 * static_cast<double>(round) / static_cast<double>(rounds), "wearing anew"))
      return fail(ErrorCode::cancelled, "stopped while learning");
    WornAnew anew(sensors, {}, Random(1).fork("worn anew", round));
    tracker.reset();
    for (std::size_t f = 0; f < features.size(); ++f) {
      worn = features[f];
      if (round > sensors)
        anew.apply(worn);
      else if (round > 0)
        worn.sensors[round - 1] = {};
      tracker.step(worn, frame);
      answers[f] = frame.weights;
    }
    lessons.add(answers);
  }

  const Judgement before = lessons.judged(std::nullopt, lessons.wearings());
  // Each candidate's held-out error, weights' and skin's alike, as shares of the answers' own: 2 is no gain.
  // A face none of whose shapes moves a vertex is judged by the weights alone.
  std::array<Judgement, kRidges.size()> judgements;
  std::array<double, kRidges.size()> scores{};
  for (std::size_t c = 0; c < kRidges.size(); ++c) {
    if (!progress(0.7 + 0.3 * static_cast<double>(c) / kRidges.size(), "learning"))
      return fail(ErrorCode::cancelled, "stopped while learning");
    judgements[c] = lessons.judged(kRidges[c], lessons.wearings());
    scores[c] = judgements[c].mse() / std::max(1e-12, before.mse()) +
                judgements[c].skin_mm / std::max(1e-12, before.skin_mm);
  }
  const double best = *std::ranges::min_element(scores);
  std::size_t chosen = kRidges.size() - 1;
  while (chosen > 0 && scores[chosen] > best + kGainGivenUp * std::max(0.0, 2 - best)) --chosen;
  const double penalty = kRidges[chosen];
  std::vector<Index> uncorrected;
  for (Index k = 0; k < kAnswers; ++k)
    if (!is_gain(before.by_stretch.row(k) - judgements[chosen].by_stretch.row(k), before.squares[k]))
      uncorrected.push_back(k);
  report.shapes = face::kShapeCount - uncorrected.size();
  const Judgement as_worn = lessons.judged(std::nullopt, 1),
                  corrected = lessons.judged(penalty, 1, uncorrected);
  report.mse_before = as_worn.mse();
  report.mse_after = corrected.mse();
  report.skin_before_mm = as_worn.skin_mm;
  report.skin_after_mm = corrected.skin_mm;
  report.taken = report.shapes > 0 && report.mse_after < report.mse_before &&
                 (report.skin_after_mm < report.skin_before_mm || !(report.skin_before_mm > 0));
  if (!report.taken) return report;
  MatrixXd map = lessons.fitted(penalty);
  for (const Index k : uncorrected) map.col(k).setZero();
  const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows =
      map.transpose().cast<float>().cwiseMax(-model::kMostCorrection).cwiseMin(model::kMostCorrection);
  model::Correction& correction = file.correction.emplace();
  correction.lags.assign(kLags.begin(), kLags.end());
  correction.weights.assign(rows.data(), rows.data() + rows.size());
  progress(1, "learnt");
  return report;
}

}  // namespace mien::tracker
