#include "mien/phone/time_alignment.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <ranges>
#include <string_view>
#include <utility>

#include "mien/core/rotation.h"
#include "mien/core/time.h"

namespace mien::phone {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Both sides less their mean over so long around: headings wander, and resting faces differ. Longer keeps
/// slow expressions; shorter leaves what tells time best, the fast ones.
constexpr double kWindowS = 1.0;
/// Means over so long. Longer takes away more of the sensors' noise, and of what tells time.
constexpr double kSmoothS = 0.07;
/// What a phone tells is sampled anew so often, so that linear interpolation between is exact enough.
constexpr double kToldHz = 240;
/// A stretch of a take that is judged by itself, s.
constexpr double kBlockS = 10;
/// A sensor counts that was there for this share of what came after the first was calibrated.
constexpr double kSensorThere = 0.8;
/// Ridge of the regressions, a share of a signal's mean square.
constexpr double kRidge = 1e-2;
/// A channel that moves less than this, root mean square of its weight, tells nothing.
constexpr double kLeastMotion = 0.01;
/// Of two offsets farther apart than this at most one is right, s; the other must be worse by this share.
constexpr double kPeakS = 1.0, kSecondPeak = 0.8;

/// Told shapes that skin feels, by the beginnings of their names: their mean is one channel. The first two
/// are what agreement is said of.
constexpr std::array<std::string_view, 12> kChannels = {
    "jawOpen",      "mouthSmile", "mouthPucker",  "mouthFunnel", "mouthUpperUp", "mouthLowerDown",
    "mouthStretch", "cheekPuff",  "browInnerUp_", "browDown",    "eyeBlink",     "noseSneer"};
constexpr std::size_t kJudged = 2;

/// Rows of a signal at a steady rate, less their means around; rows that are not valid are zero.
struct Signal {
  double rate_hz = kFrameRateHz;
  MatrixXd rows;
  std::vector<char> valid;
  [[nodiscard]] Index size() const { return rows.rows(); }
};

/// Makes each valid row the mean of the valid ones around it less that over a longer window: neither noise
/// nor what stays. Both windows are centred, so that nothing becomes late.
void keep_the_middle_band(Signal& signal) {
  const Index count = signal.size();
  MatrixXd sums = MatrixXd::Zero(count + 1, signal.rows.cols());
  VectorXd counts = VectorXd::Zero(count + 1);
  for (Index t = 0; t < count; ++t) {
    const bool valid = signal.valid[static_cast<std::size_t>(t)] != 0;
    if (!valid) signal.rows.row(t).setZero();
    sums.row(t + 1) = sums.row(t) + signal.rows.row(t);
    counts[t + 1] = counts[t] + (valid ? 1 : 0);
  }
  const auto mean = [&](Index t, double window_s) {
    const auto half = static_cast<Index>(std::lround(0.5 * window_s * signal.rate_hz));
    const Index from = std::max<Index>(0, t - half), to = std::min(count, t + half + 1);
    return Eigen::RowVectorXd((sums.row(to) - sums.row(from)) / (counts[to] - counts[from]));
  };
  for (Index t = 0; t < count; ++t)
    if (signal.valid[static_cast<std::size_t>(t)] != 0)
      signal.rows.row(t) = mean(t, kSmoothS) - mean(t, kWindowS);
}

/// Rotation vectors of the sensors that were there for most of it once they were calibrated, one row a frame
/// of the grid.
Signal skin_signal(std::span<const model::FeatureFrame> skin) {
  const std::size_t sensors = skin.empty() ? 0 : skin.front().sensors.size();
  // Before the calibration nothing is known of any.
  const auto any = [](const model::FeatureFrame& frame) {
    return std::ranges::any_of(frame.sensors, &model::SensorFeature::has_rotation);
  };
  const auto calibrated = std::ranges::subrange(std::ranges::find_if(skin, any), skin.end());
  std::vector<std::size_t> used;
  for (std::size_t s = 0; s < sensors; ++s) {
    const auto there = std::ranges::count_if(
        calibrated, [&](const model::FeatureFrame& frame) { return frame.sensors[s].has_rotation; });
    if (there > 0 && static_cast<double>(there) >= kSensorThere * static_cast<double>(calibrated.size()))
      used.push_back(s);
  }
  Signal out;
  if (used.empty()) return out;
  const auto row_of = [&](const model::FeatureFrame& frame) {
    return static_cast<Index>(std::lround(to_seconds(frame.time - skin.front().time) * kFrameRateHz));
  };
  const Index count = row_of(skin.back()) + 1;
  out.rows = MatrixXd::Zero(count, 3 * static_cast<Index>(used.size()));
  out.valid.assign(static_cast<std::size_t>(count), 0);
  for (const model::FeatureFrame& frame : skin) {
    const Index row = row_of(frame);
    bool all = true;
    for (std::size_t u = 0; u < used.size(); ++u) {
      const model::SensorFeature& sensor = frame.sensors[used[u]];
      const Quat q = quat_of(sensor.rotation);
      all = all && sensor.has_rotation && q.coeffs().allFinite();
      if (all) out.rows.row(row).segment<3>(3 * static_cast<Index>(u)) = log_rotation(q).transpose();
    }
    out.valid[static_cast<std::size_t>(row)] = all ? 1 : 0;
  }
  keep_the_middle_band(out);
  return out;
}

/// The channels that move, one row every 1 / kToldHz of the phone's time; `judged` of them are jaw and smile.
struct Told {
  Signal signal;
  std::size_t judged = 0;
};

Told told_signal(const face::Motion& told) {
  const face::MotionCurve curve(told);
  const auto count = static_cast<Index>(told.duration_s() * kToldHz) + 1;
  Signal all{kToldHz, MatrixXd::Zero(count, static_cast<Index>(kChannels.size())), {}};
  all.valid.assign(static_cast<std::size_t>(count), 0);
  for (Index t = 0; t < count; ++t) {
    const double time_s = static_cast<double>(t) / kToldHz;
    const face::MotionFrame frame = curve.at(time_s);
    if (!frame.has_face) continue;
    all.valid[static_cast<std::size_t>(t)] = 1;
    for (std::size_t c = 0; c < kChannels.size(); ++c) {
      double sum = 0, shapes = 0;
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        if (face::kShapeNames[k].starts_with(kChannels[c])) sum += double{frame.weights[k]}, ++shapes;
      all.rows(t, static_cast<Index>(c)) = sum / shapes;
    }
  }
  keep_the_middle_band(all);
  const auto valid = static_cast<double>(std::ranges::count(all.valid, 1));
  std::vector<Index> moving;
  Told out;
  for (std::size_t c = 0; c < kChannels.size(); ++c) {
    const double rms = std::sqrt(all.rows.col(static_cast<Index>(c)).squaredNorm() / std::max(1.0, valid));
    if (rms < kLeastMotion) continue;
    moving.push_back(static_cast<Index>(c));
    if (c < kJudged) ++out.judged;
  }
  out.signal.rate_hz = kToldHz;
  out.signal.valid = std::move(all.valid);
  out.signal.rows.resize(count, static_cast<Index>(moving.size()));
  for (std::size_t m = 0; m < moving.size(); ++m)
    out.signal.rows.col(static_cast<Index>(m)) = all.rows.col(moving[m]);
  return out;
}

/// The rows that both sides have at one alignment: skin's, and what is told of the same moment.
struct Pairs {
  MatrixXd skin, told;
  std::vector<Index> frames;  // Of the skin's rows.
};

Pairs pairs_at(const Signal& skin, const Signal& told, const TimeAlignment& at) {
  Pairs out;
  out.skin.resize(skin.size(), skin.rows.cols());
  out.told.resize(skin.size(), told.rows.cols());
  Index count = 0;
  for (Index t = 0; t < skin.size(); ++t) {
    if (skin.valid[static_cast<std::size_t>(t)] == 0) continue;
    const double place = at.to_phone_s(static_cast<double>(t) / skin.rate_hz) * told.rate_hz;
    if (!(place >= 0) || place >= static_cast<double>(told.size() - 1)) continue;
    const auto before = static_cast<Index>(place);
    if (told.valid[static_cast<std::size_t>(before)] == 0 ||
        told.valid[static_cast<std::size_t>(before) + 1] == 0)
      continue;
    const double share = place - static_cast<double>(before);
    out.skin.row(count) = skin.rows.row(t);
    out.told.row(count) = (1 - share) * told.rows.row(before) + share * told.rows.row(before + 1);
    out.frames.push_back(t);
    ++count;
  }
  out.skin.conservativeResize(count, Eigen::NoChange);
  out.told.conservativeResize(count, Eigen::NoChange);
  return out;
}

/// The linear map from skin to what is told: rows are skin's columns.
MatrixXd regression(const MatrixXd& skin, const MatrixXd& told) {
  MatrixXd square = skin.transpose() * skin;
  square.diagonal().array() += kRidge * square.trace() / static_cast<double>(square.rows()) + 1e-12;
  return square.llt().solve(skin.transpose() * told);
}

/// Negative logarithm of the profile likelihood, nats, each channel with its own residual variance.
double profile(const Signal& skin, const Signal& told, const TimeAlignment& at) {
  const Pairs pairs = pairs_at(skin, told, at);
  if (pairs.frames.size() < 2 * static_cast<std::size_t>(skin.rows.cols())) return 0;
  const MatrixXd residual = pairs.told - pairs.skin * regression(pairs.skin, pairs.told);
  double sum = 0;
  for (Index c = 0; c < residual.cols(); ++c)
    sum += std::log((residual.col(c).squaredNorm() + 1e-12) / (pairs.told.col(c).squaredNorm() + 1e-12));
  return 0.5 * static_cast<double>(pairs.frames.size()) * sum;
}

/// Offsets and how well each agrees, by cross-correlation of signals at a low rate.
class CoarseSearch {
 public:
  CoarseSearch(const Signal& skin, const Signal& told)
      : rate_hz_(static_cast<double>(skin.size()) / skin.rate_hz > 600 ? 10 : 20),
        skin_(thinned(skin)),
        told_(thinned(told)) {
    // Few directions are enough to find a peak.
    constexpr Index kDirections = 12;
    const MatrixXd square = skin_.rows.transpose() * skin_.rows;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(square);
    const Index most = std::min<Index>(kDirections, square.rows());
    MatrixXd basis = solver.eigenvectors().rightCols(most);
    for (Index d = 0; d < most; ++d)
      basis.col(d) /= std::sqrt(std::max(1e-12, solver.eigenvalues()[square.rows() - most + d]));
    skin_.rows = skin_.rows * basis;
  }

  /// The best offset within a window, s, and how far the best one that is another falls behind it (0 to 1:
  /// its share of the best).
  struct Found {
    double offset_s = 0;
    double second = 0;
  };
  [[nodiscard]] std::optional<Found> find(double least_s, double most_s) const {
    const auto first = static_cast<Index>(std::floor(std::max(least_s, -seconds(told_)) * rate_hz_));
    const auto last = static_cast<Index>(std::ceil(std::min(most_s, seconds(skin_)) * rate_hz_));
    std::vector<double> scores;
    for (Index lag = first; lag <= last; ++lag) scores.push_back(score(lag));
    if (scores.empty()) return std::nullopt;
    const auto best = std::ranges::max_element(scores);
    if (!(*best > 0)) return std::nullopt;
    double second = 0;
    for (auto other = scores.begin(); other != scores.end(); ++other)
      if (std::abs(static_cast<double>(other - best)) > kPeakS * rate_hz_) second = std::max(second, *other);
    return Found{static_cast<double>(first + (best - scores.begin())) / rate_hz_, second / *best};
  }

 private:
  [[nodiscard]] double seconds(const Signal& signal) const {
    return static_cast<double>(signal.size()) / rate_hz_;
  }
  /// Means of the valid rows of each piece.
  [[nodiscard]] Signal thinned(const Signal& signal) const {
    const auto step = static_cast<Index>(std::lround(signal.rate_hz / rate_hz_));
    const Index count = signal.size() / step;
    Signal out{rate_hz_, MatrixXd::Zero(count, signal.rows.cols()), {}};
    out.valid.assign(static_cast<std::size_t>(count), 0);
    for (Index t = 0; t < count; ++t) {
      const auto begin = signal.valid.begin() + t * step;
      if (std::count(begin, begin + step, 1) < step) continue;
      out.valid[static_cast<std::size_t>(t)] = 1;
      out.rows.row(t) = signal.rows.middleRows(t * step, step).colwise().mean();
    }
    return out;
  }
  /// Nats, about; 0 where too little overlaps. `lag`: skin's row at the told one's first.
  [[nodiscard]] double score(Index lag) const {
    const Index begin = std::max<Index>(0, lag), end = std::min(skin_.size(), lag + told_.size());
    const double rows = static_cast<double>(end - begin);
    if (rows < kLeastOverlapS * rate_hz_) return 0;
    const auto told = told_.rows.middleRows(begin - lag, end - begin);
    const auto skin = skin_.rows.middleRows(begin, end - begin);
    const MatrixXd square = skin.transpose() * skin;
    const MatrixXd cross = skin.transpose() * told;
    const MatrixXd solved =
        (square + 1e-6 * MatrixXd::Identity(square.rows(), square.cols())).ldlt().solve(cross);
    const double spent = static_cast<double>(square.rows());
    double sum = 0;
    for (Index c = 0; c < told.cols(); ++c) {
      const double all = told.col(c).squaredNorm() + 1e-12;
      const double left = std::max(1e-3, 1 - cross.col(c).dot(solved.col(c)) / all);
      sum -= std::log(std::min(1.0, left * rows / std::max(1.0, rows - spent)));
    }
    return 0.5 * rows * sum;
  }

  double rate_hz_;
  Signal skin_, told_;
};

/// Offset at the middle, and what drift adds at the ends, both s: two numbers of one scale.
TimeAlignment moved(TimeAlignment at, double offset_s, double ends_s) {
  at.offset_s += offset_s;
  at.drift_ppm += 1e6 * ends_s / (0.5 * at.overlap_s);
  return at;
}

/// Newton's method on a quadratic through six values.
TimeAlignment refine(const Signal& skin, const Signal& told, TimeAlignment at) {
  constexpr std::array kSteps_s = {1 / 60.0, 1 / 60.0, 1 / 120.0, 1 / 120.0, 1 / 240.0};
  // A drift beyond this is no crystal's.
  constexpr double kMostDriftPpm = 300;
  for (const double h : kSteps_s) {
    const auto value = [&](double u, double v) { return profile(skin, told, moved(at, h * u, h * v)); };
    const double middle = value(0, 0), u1 = value(1, 0), u2 = value(-1, 0), v1 = value(0, 1),
                 v2 = value(0, -1);
    Eigen::Matrix2d hessian;
    hessian(0, 0) = u1 + u2 - 2 * middle;
    hessian(1, 1) = v1 + v2 - 2 * middle;
    hessian(0, 1) = hessian(1, 0) = value(1, 1) - u1 - v1 + middle;
    const Eigen::Vector2d gradient(0.5 * (u1 - u2), 0.5 * (v1 - v2));
    Eigen::Vector2d step = Eigen::Vector2d::Zero();
    if (hessian.determinant() > 0 && hessian.trace() > 0) {
      step = -hessian.inverse() * gradient;
    } else {
      step = -gradient.normalized();
    }
    step = step.cwiseMax(-2).cwiseMin(2);
    at = moved(at, h * step[0], h * step[1]);
    at.drift_ppm = std::clamp(at.drift_ppm, -kMostDriftPpm, kMostDriftPpm);
  }
  return at;
}

/// Which block a frame belongs to, and how many there are.
struct Blocks {
  double begin_s = 0, length_s = 0;
  std::size_t count = 0;
  [[nodiscard]] std::size_t of(Index frame) const {
    const double place = (static_cast<double>(frame) / kFrameRateHz - begin_s) / length_s;
    return std::min(count - 1, static_cast<std::size_t>(std::max(0.0, place)));
  }
};

/// Share of each judged channel's variance that is foretold by the map from the other half's blocks: of all,
/// and of each block.
struct Agreement {
  double all = 0;
  std::vector<double> blocks;
};

Agreement agreement_of(const Pairs& pairs, const Blocks& blocks, std::size_t judged) {
  const auto columns = static_cast<Index>(judged);
  std::array<std::vector<Index>, 2> halves;
  for (std::size_t r = 0; r < pairs.frames.size(); ++r)
    halves[blocks.of(pairs.frames[r]) % 2].push_back(static_cast<Index>(r));
  std::vector<double> wrong(blocks.count, 0), all(blocks.count, 0);
  for (std::size_t half = 0; half < 2; ++half) {
    const MatrixXd map = regression(pairs.skin(halves[1 - half], Eigen::all),
                                    pairs.told(halves[1 - half], Eigen::seqN(0, columns)));
    for (const Index row : halves[half]) {
      const auto told = pairs.told.row(row).head(columns);
      const std::size_t block = blocks.of(pairs.frames[static_cast<std::size_t>(row)]);
      wrong[block] += (told - pairs.skin.row(row) * map).squaredNorm();
      all[block] += told.squaredNorm();
    }
  }
  Agreement out;
  double wrong_sum = 0, all_sum = 0;
  for (std::size_t b = 0; b < blocks.count; ++b) {
    out.blocks.push_back(all[b] > 0 ? 1 - wrong[b] / all[b] : 0);
    wrong_sum += wrong[b];
    all_sum += all[b];
  }
  out.all = all_sum > 0 ? 1 - wrong_sum / all_sum : 0;
  return out;
}

/// Each block's own offset less the line's, by one Gauss-Newton step from it, and the line's posterior.
void judge(const Pairs& pairs, const Blocks& blocks, const AlignmentPrior& prior, TimeAlignment& at) {
  const MatrixXd map = regression(pairs.skin, pairs.told);
  const MatrixXd foretold = pairs.skin * map;
  const MatrixXd residual = pairs.told - foretold;
  const auto rows = static_cast<double>(pairs.frames.size());
  VectorXd precision(residual.cols());
  for (Index c = 0; c < residual.cols(); ++c)
    precision[c] = rows / (residual.col(c).squaredNorm() + 1e-9 * rows);
  std::vector<double> information(blocks.count, 0), score(blocks.count, 0);
  for (std::size_t r = 1; r + 1 < pairs.frames.size(); ++r) {
    const auto row = static_cast<Index>(r);
    if (pairs.frames[r + 1] - pairs.frames[r - 1] != 2) continue;
    const auto slope = (0.5 * kFrameRateHz * (foretold.row(row + 1) - foretold.row(row - 1))).eval();
    const std::size_t block = blocks.of(pairs.frames[r]);
    information[block] += slope.cwiseAbs2().dot(precision);
    score[block] += slope.cwiseProduct(residual.row(row)).dot(precision);
  }
  at.blocks.assign(blocks.count, {});
  const double half_s = 0.5 * at.overlap_s;
  const auto base = [&](const AlignmentBlock& block) {
    return Eigen::Vector2d(1, (0.5 * (block.begin_s + block.end_s) - at.middle_s) / half_s);
  };
  // Residuals of neighbouring frames are alike, and what a linear map gets wrong differs from block to block
  // and is no less where more is felt. So information alone would trust few blocks too much: a block's weight
  // is its root, and how the blocks scatter about their own line (the residual variance) inflates the
  // covariance.
  Eigen::Matrix2d rooted = Eigen::Matrix2d::Zero();
  Eigen::Vector2d rooted_right = Eigen::Vector2d::Zero();
  double counted = 0;
  for (std::size_t b = 0; b < blocks.count; ++b) {
    AlignmentBlock& block = at.blocks[b];
    block.begin_s = blocks.begin_s + static_cast<double>(b) * blocks.length_s;
    block.end_s = block.begin_s + blocks.length_s;
    if (!(information[b] > 0)) continue;
    block.residual_s = score[b] / information[b];
    rooted += std::sqrt(information[b]) * base(block) * base(block).transpose();
    rooted_right += std::sqrt(information[b]) * block.residual_s * base(block);
    ++counted;
  }
  const Eigen::Vector2d line =
      counted > 2 ? Eigen::Vector2d(rooted.ldlt().solve(rooted_right)) : Eigen::Vector2d::Zero();
  double scatter = 0;
  for (std::size_t b = 0; b < blocks.count; ++b)
    scatter +=
        std::sqrt(information[b]) * std::pow(at.blocks[b].residual_s - base(at.blocks[b]).dot(line), 2);
  const double variance = scatter / std::max(1.0, counted - 2);
  Eigen::Matrix2d all = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (std::size_t b = 0; b < blocks.count; ++b) {
    AlignmentBlock& block = at.blocks[b];
    // Never more than of residuals that are white.
    const double weight =
        variance > 0 ? std::min(information[b], std::sqrt(information[b]) / variance) : information[b];
    block.sigma_s = weight > 0 ? 1 / std::sqrt(weight) : std::numeric_limits<double>::infinity();
    all += weight * base(block) * base(block).transpose();
    right += weight * block.residual_s * base(block);
  }
  const double ends_sigma_s = std::max(1e-6, 1e-6 * prior.drift_sigma_ppm * half_s);
  all(1, 1) += 1 / (ends_sigma_s * ends_sigma_s);
  right[1] += 1e-6 * (prior.drift_ppm - at.drift_ppm) * half_s / (ends_sigma_s * ends_sigma_s);
  const Eigen::Matrix2d covariance = all.inverse();
  const Eigen::Vector2d step = covariance * right;
  at = moved(std::move(at), step[0], step[1]);
  at.offset_sigma_s = std::sqrt(covariance(0, 0));
  at.drift_sigma_ppm = 1e6 * std::sqrt(covariance(1, 1)) / half_s;
  for (AlignmentBlock& block : at.blocks) block.residual_s -= base(block).dot(step);
}

/// Middle and length of what both have at this offset.
void set_overlap(const Signal& skin, const Signal& told, TimeAlignment& at) {
  const Pairs pairs = pairs_at(skin, told, at);
  if (pairs.frames.empty()) {
    at.overlap_s = 0;
    return;
  }
  const double begin_s = static_cast<double>(pairs.frames.front()) / skin.rate_hz;
  const double end_s = static_cast<double>(pairs.frames.back()) / skin.rate_hz;
  const double middle_s = 0.5 * (begin_s + end_s);
  at.offset_s = middle_s - at.to_phone_s(middle_s);
  at.middle_s = middle_s;
  at.overlap_s = end_s - begin_s;
}

}  // namespace

Result<TimeAlignment> align(std::span<const model::FeatureFrame> skin, const face::Motion& told,
                            const std::optional<AlignmentPrior>& prior) {
  const auto too_little = [&](std::string what, const char* first = "") {
    return fail(ErrorCode::not_found, std::move(what), told.name,
                fmt::format("{}record at least {:.0f} s of speech or expressions with both at once", first,
                            kLeastOverlapS));
  };
  const Signal felt = skin_signal(skin);
  if (felt.size() == 0)
    return too_little("no sensor on the skin was calibrated and there for most of the take",
                      "calibrate first, and ");
  if (told.duration_s() < kLeastOverlapS)
    return too_little(fmt::format("what the phone tells is {:.1f} s long", told.duration_s()));
  const Told channels = told_signal(told);
  if (channels.judged == 0) return too_little("neither jaw nor smile moves in what the phone tells");
  const Signal& seen = channels.signal;

  const AlignmentPrior assumed = prior.value_or(AlignmentPrior{});
  const CoarseSearch search(felt, seen);
  constexpr double kAnywhere = std::numeric_limits<double>::max();
  const auto found =
      prior ? search.find(prior->offset_s - prior->offset_window_s, prior->offset_s + prior->offset_window_s)
            : search.find(-kAnywhere, kAnywhere);
  const auto disagree = [&](double agreement) {
    return fail(
        ErrorCode::mismatch,
        fmt::format("what the phone tells and how the skin turns do not agree at any offset (agreement "
                    "{:.2f}, {:.2f} is asked)",
                    agreement, kLeastAgreement),
        told.name, "use what the same performer's phone recorded in this take");
  };
  if (!found) return disagree(0);
  if (!prior && found->second > kSecondPeak)
    return fail(ErrorCode::mismatch,
                fmt::format("two offsets agree nearly as well ({:.0f} %)", 100 * found->second), told.name,
                "use what the same performer's phone recorded in this take");

  TimeAlignment at;
  at.offset_s = found->offset_s;
  set_overlap(felt, seen, at);
  if (at.overlap_s < kLeastOverlapS)
    return too_little(fmt::format("phone and sensors have {:.1f} s in common", at.overlap_s));
  at.drift_ppm = assumed.drift_ppm;
  at = refine(felt, seen, std::move(at));
  set_overlap(felt, seen, at);
  const Pairs pairs = pairs_at(felt, seen, at);
  if (pairs.frames.size() < 2 * static_cast<std::size_t>(felt.rows.cols()))
    return too_little("phone and sensors have too little in common");
  const auto count = static_cast<std::size_t>(std::clamp(std::floor(at.overlap_s / kBlockS), 4.0, 360.0));
  const Blocks blocks{at.middle_s - 0.5 * at.overlap_s, at.overlap_s / static_cast<double>(count), count};
  const Agreement agreement = agreement_of(pairs, blocks, channels.judged);
  if (!(agreement.all >= kLeastAgreement)) return disagree(agreement.all);
  at.agreement = agreement.all;
  judge(pairs, blocks, assumed, at);
  for (std::size_t b = 0; b < count; ++b) at.blocks[b].agreement = agreement.blocks[b];
  at.offset_s -= kSkinLagS;
  at.offset_sigma_s = std::hypot(at.offset_sigma_s, kSkinLagSigmaS);
  return at;
}

}  // namespace mien::phone
