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
#include "mien/model/causal_network.h"
#include "mien/model/network_correction.h"
#include "mien/tracker/causal_tracker.h"
#include "mien/tracker/model_input.h"
#include "mien/tracker/worn_anew.h"

namespace mien::tracker {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr auto kAnswers = static_cast<Index>(face::kShapeCount);
/// How often the performance is worn anew. More cost time and change little; half as many cost a tenth of the
/// gain.
constexpr std::size_t kWearings = 24;
/// Stretches of the cross-validation. Neighbouring frames are alike, so a stretch is held out as one ...
constexpr std::size_t kStretches = 8;
/// ... of which one frame in so many is judged, and no more than these are learnt from, evenly spread: they
/// are as good as all, and five minutes are learnt in half a minute.
constexpr std::size_t kJudgedEvery = 4;
constexpr std::size_t kMostFrames = 4'500;
/// Candidate penalties of the ridge, a share of the mean square of the inputs: one for all of them, since a
/// hidden unit that hardly moves is hardly heard by the output layer either.
constexpr std::array kRidges = {0.3, 1.0, 3.0, 10.0, 30.0};
/// A frame counts by the reciprocal of its skin's error and so much, mm: then it is the mean error that
/// becomes least, and not that of the widest expressions.
constexpr double kUsualError_mm = 0.3;
/// The largest ridge is taken that has all but this share of the best one's gain: another day differs by more
/// than the wearings that are drawn.
constexpr double kGainGivenUp = 0.1;
/// A shape's error must become smaller by this share, and by so many standard errors of its mean over the
/// stretches: what one stretch alone taught, the next one unlearns.
constexpr double kLeastGain = 0.02, kSure = 1.5;
/// Rows that are added to a regression's sums at once.
constexpr Index kBlock = 256;

/// Weighted sums of a regression.
struct Sums {
  MatrixXd inputs, cross;  // Of the former the lower triangle.
  double weight = 0;       // Of the rows.

  explicit Sums(Index width) : inputs(MatrixXd::Zero(width, width)), cross(MatrixXd::Zero(width, kAnswers)) {}
  void add(const MatrixXd& more_inputs, const MatrixXd& residuals, const VectorXd& weights) {
    const VectorXd roots = weights.cwiseSqrt();
    const MatrixXd weighted = roots.asDiagonal() * more_inputs;
    inputs.selfadjointView<Eigen::Lower>().rankUpdate(weighted.transpose());
    cross.noalias() += weighted.transpose() * (roots.asDiagonal() * residuals);
    weight += weights.sum();
  }
  void add(const Sums& other, double sign = 1) {
    inputs += sign * other.inputs;
    cross += sign * other.cross;
    weight += sign * other.weight;
  }
};

/// From inputs to residuals. `penalty`: a share of the inputs' mean square.
MatrixXd ridge_map(const Sums& sums, double penalty) {
  MatrixXd moments = sums.inputs / sums.weight;
  moments.diagonal().array() += penalty * moments.diagonal().mean();
  return moments.selfadjointView<Eigen::Lower>().ldlt().solve(sums.cross / sums.weight);
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

/// Where a frame that is learnt from belongs.
struct Place {
  std::size_t stretch = 0;
  bool judged = false;
};

/// Of each frame that is learnt from, its stretch; none of those that are not known, or spared.
std::vector<std::optional<Place>> places_of(std::span<const TaughtFrame> taught) {
  const auto known = static_cast<std::size_t>(std::ranges::count_if(taught, &TaughtFrame::known));
  const std::size_t every = known / kMostFrames + 1;
  std::vector<std::optional<Place>> places(taught.size());
  std::size_t seen = 0;
  for (std::size_t f = 0; f < taught.size(); ++f) {
    if (!taught[f].known) continue;
    const std::size_t i = seen++;
    if (i % every == 0) places[f] = Place{i * kStretches / known, i / every % kJudgedEvery == 0};
  }
  return places;
}

/// Inputs and residuals of all wearings in the frames that are learnt from. An input is what the output layer
/// reads, and 1; a residual is what was taught less the answer, a weight each.
class Lessons {
 public:
  /// `wearings`: how often each frame comes; the first is as the sensors were worn.
  Lessons(MatrixXd metric, Index width, std::size_t wearings)
      : metric_(std::move(metric)), wearings_(static_cast<Index>(wearings)), sums_(kStretches, Sums(width)) {}

  /// One frame of all wearings, a row each.
  void add(const Place& place, const Rows& inputs, const Rows& residuals) {
    if (place.stretch != stretch_ || rows_ + inputs.rows() > block_inputs_.rows()) flush();
    stretch_ = place.stretch;
    if (block_inputs_.rows() == 0) {
      const Index rows = std::max(kBlock, inputs.rows());
      block_inputs_.resize(rows, inputs.cols());
      block_residuals_.resize(rows, kAnswers);
    }
    block_inputs_.middleRows(rows_, inputs.rows()) = inputs.cast<double>();
    block_residuals_.middleRows(rows_, inputs.rows()) = residuals.cast<double>();
    rows_ += inputs.rows();
    if (!place.judged) return;
    std::vector<float>& kept = judged_inputs_[stretch_];
    kept.insert(kept.end(), inputs.data(), inputs.data() + inputs.size());
    std::vector<float>& left = judged_residuals_[stretch_];
    left.insert(left.end(), residuals.data(), residuals.data() + residuals.size());
  }
  /// All have been added.
  void end() { flush(); }

  [[nodiscard]] MatrixXd fitted(double penalty) const { return fitted_without(kStretches, penalty); }
  /// Held-out errors with this ridge; none: of the answers as they are. As worn: of the first wearing alone.
  /// Shapes that are not corrected are named.
  [[nodiscard]] Judgement judged(std::optional<double> penalty, bool as_worn,
                                 const std::vector<Index>& uncorrected = {}) const {
    Judgement out;
    double count = 0;
    for (std::size_t s = 0; s < kStretches; ++s) {
      const auto rows = static_cast<Index>(judged_residuals_[s].size()) / kAnswers;
      const Eigen::Map<const Rows> residuals(judged_residuals_[s].data(), rows, kAnswers);
      Rows left = residuals;
      if (penalty) {
        MatrixXd map = fitted_without(s, *penalty);
        for (const Index k : uncorrected) map.col(k).setZero();
        left.noalias() -=
            Eigen::Map<const Rows>(judged_inputs_[s].data(), rows, map.rows()) * map.cast<float>();
      }
      const MatrixXd counted =
          left(Eigen::seq(0, rows - 1, as_worn ? wearings_ : 1), Eigen::all).cast<double>();
      out.skin_mm += skin_errors(counted, metric_).sum();
      out.by_stretch.col(static_cast<Index>(s)) = counted.colwise().squaredNorm().transpose();
      count += static_cast<double>(counted.rows());
    }
    out.skin_mm /= count;
    // Stretches are of one length.
    out.by_stretch *= static_cast<double>(kStretches) / count;
    out.squares = out.by_stretch.rowwise().mean();
    return out;
  }

 private:
  void flush() {
    if (rows_ == 0) return;
    const MatrixXd residuals = block_residuals_.topRows(rows_);
    const VectorXd weights = (skin_errors(residuals, metric_).array() + kUsualError_mm).inverse().matrix();
    sums_[stretch_].add(block_inputs_.topRows(rows_), residuals, weights);
    rows_ = 0;
  }
  [[nodiscard]] MatrixXd fitted_without(std::size_t stretch, double penalty) const {
    Sums sums(sums_.front().inputs.rows());
    for (const Sums& one : sums_) sums.add(one);
    if (stretch < kStretches) sums.add(sums_[stretch], -1);
    return ridge_map(sums, penalty);
  }

  MatrixXd metric_;
  Index wearings_;
  std::vector<Sums> sums_;                                                       // A stretch each.
  std::array<std::vector<float>, kStretches> judged_inputs_, judged_residuals_;  // Row after row.
  std::size_t stretch_ = 0;
  MatrixXd block_inputs_, block_residuals_;
  Index rows_ = 0;  // In the block.
};

/// What was taught less what was answered; nothing where both are at the same end, beyond which weights do
/// not go.
float residual(float taught, float answer) {
  return (taught <= 0 && answer < 0) || (taught >= 1 && answer > 1) ? 0 : taught - answer;
}

/// Lets the network see the performance in every wearing at once, and gathers what it lacks. False: stopped.
bool gather(std::span<const model::FeatureFrame> features, std::span<const TaughtFrame> taught,
            const model::CausalNetwork& network, const ModelInput& input, std::size_t sensors,
            Lessons& lessons, const Progress& progress) {
  const std::size_t wearings = 1 + sensors + kWearings;
  const auto rows = static_cast<Index>(wearings);
  const auto width = static_cast<Index>(network.architecture().d_model);
  std::vector<WornAnew> anew;
  for (std::size_t w = 1 + sensors; w < wearings; ++w)
    anew.emplace_back(sensors, WearingSpread{}, Random(1).fork("worn anew", w));
  std::vector<ModelInput> encoders(wearings, input);
  std::vector<model::CausalNetwork::State> states;
  for (std::size_t w = 0; w < wearings; ++w) states.emplace_back(network);
  std::vector<model::CausalNetwork::State*> together;
  for (model::CausalNetwork::State& state : states) together.push_back(&state);
  model::CausalNetwork::Workspace workspace(network, wearings);
  Rows conditions(rows, static_cast<Index>(network.architecture().condition));
  Rows answers(rows, kAnswers), inputs(rows, width + 1), residuals(rows, kAnswers);
  inputs.rightCols(1).setOnes();
  const std::vector<std::optional<Place>> places = places_of(taught);
  const auto row_of = [](Rows& matrix, std::size_t row) {
    return std::span(matrix.row(static_cast<Index>(row)).data(), static_cast<std::size_t>(matrix.cols()));
  };
  constexpr std::size_t kAsked = 64;  // Frames between two questions whether to go on.
  model::FeatureFrame worn;
  for (std::size_t f = 0; f < features.size(); ++f) {
    if (f % kAsked == 0 &&
        !progress(0.9 * static_cast<double>(f) / static_cast<double>(features.size()), "wearing anew"))
      return false;
    for (std::size_t w = 0; w < wearings; ++w) {
      worn = features[f];
      if (w > sensors)
        anew[w - 1 - sensors].apply(worn);
      else if (w > 0)
        worn.sensors[w - 1] = {};
      encoders[w].encode(worn, row_of(conditions, w));
    }
    network.step({conditions.data(), static_cast<std::size_t>(conditions.size())}, together, workspace,
                 {answers.data(), static_cast<std::size_t>(answers.size())});
    if (!places[f]) continue;
    for (std::size_t w = 0; w < wearings; ++w) {
      std::ranges::copy(workspace.hidden(w), row_of(inputs, w).begin());
      for (Index k = 0; k < kAnswers; ++k) {
        const auto row = static_cast<Index>(w);
        residuals(row, k) =
            residual(taught[f].weights[static_cast<std::size_t>(k)], 0.5F * (answers(row, k) + 1));
      }
    }
    lessons.add(*places[f], inputs, residuals);
  }
  lessons.end();
  return true;
}

/// The map as a network's output layer has it: outputs are nominally in [-1, 1], twice as wide as weights.
model::Correction correction_of(const MatrixXd& map, const model::ModelFile& file) {
  const Rows rows =
      (2 * map.transpose()).cast<float>().cwiseMax(-model::kMostCorrection).cwiseMin(model::kMostCorrection);
  model::Correction correction{.network = model::correction_key(file.network), .weights = {}, .bias = {}};
  for (Index k = 0; k < rows.rows(); ++k) {
    const float* row = rows.row(k).data();
    correction.weights.insert(correction.weights.end(), row, row + rows.cols() - 1);
    correction.bias.push_back(rows(k, rows.cols() - 1));
  }
  return correction;
}

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
  // Its checks hold here too.
  MIEN_TRY_ASSIGN(const CausalTracker tracker, CausalTracker::create(std::move(bare), rig_sensors));

  const std::size_t sensors = rig_sensors.size();
  Lessons lessons(skin_metric(face), static_cast<Index>(file.architecture.d_model) + 1,
                  1 + sensors + kWearings);
  const auto stopped = [] { return fail(ErrorCode::cancelled, "stopped while learning"); };
  if (!gather(features, taught, tracker.network(), ModelInput(tracker.file(), rig_sensors), sensors, lessons,
              progress))
    return stopped();

  const Judgement before = lessons.judged(std::nullopt, false);
  // Each candidate's held-out error, weights' and skin's alike, as shares of the answers' own: 2 is no gain.
  // A face none of whose shapes moves a vertex is judged by the weights alone.
  std::array<Judgement, kRidges.size()> judgements;
  std::array<double, kRidges.size()> scores{};
  for (std::size_t c = 0; c < kRidges.size(); ++c) {
    if (!progress(0.9 + 0.1 * static_cast<double>(c) / kRidges.size(), "learning")) return stopped();
    judgements[c] = lessons.judged(kRidges[c], false);
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
  const Judgement as_worn = lessons.judged(std::nullopt, true),
                  corrected = lessons.judged(penalty, true, uncorrected);
  report.mse_before = as_worn.mse();
  report.mse_after = corrected.mse();
  report.skin_before_mm = as_worn.skin_mm;
  report.skin_after_mm = corrected.skin_mm;
  report.taken = report.shapes > 0 && report.mse_after < report.mse_before &&
                 (report.skin_after_mm < report.skin_before_mm || !(report.skin_before_mm > 0));
  if (!report.taken) return report;
  MatrixXd map = lessons.fitted(penalty);
  for (const Index k : uncorrected) map.col(k).setZero();
  file.correction = correction_of(map, file);
  progress(1, "learnt");
  return report;
}

}  // namespace mien::tracker
