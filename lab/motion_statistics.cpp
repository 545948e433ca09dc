#include "lab/motion_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "mien/core/median.h"

namespace mien::lab {

namespace {

using face::kShapeCount;
using face::kShapeNames;

constexpr double kRate_hz = 30;
constexpr double kActive = 0.1;

double percentile(std::vector<float>& values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, values.begin() + at);
  return values[static_cast<std::size_t>(at)];
}

/// The other side of a shape with sides, itself else.
std::size_t twin_of(std::size_t k) {
  if (kShapeNames[k].ends_with("_L")) return k + 1;
  if (kShapeNames[k].ends_with("_R")) return k - 1;
  return k;
}

/// A name as a cell of a table: a stroke would end it.
std::string in_cell(const std::string& name) {
  std::string out;
  for (const char c : name) {
    if (c == '|') out += '\\';
    out += c == '\n' || c == '\r' ? ' ' : c;
  }
  return out;
}

struct Samples {
  std::vector<face::BlendshapeWeights> weights;
  std::array<double, kShapeCount> speed_squares{};
  std::size_t steps = 0;
};

void collect(const face::Motion& motion, Samples& samples) {
  if (motion.frames.empty()) return;
  const face::MotionCurve curve(motion);
  const double begin_s = motion.frames.front().time_s;
  const auto count = static_cast<std::size_t>((motion.frames.back().time_s - begin_s) * kRate_hz) + 1;
  bool follows = false;
  for (std::size_t i = 0; i < count; ++i) {
    const face::MotionFrame frame = curve.at(begin_s + static_cast<double>(i) / kRate_hz);
    if (frame.has_face) {
      if (follows) {
        const face::BlendshapeWeights& before = samples.weights.back();
        for (std::size_t k = 0; k < kShapeCount; ++k) {
          const double speed = (frame.weights[k] - before[k]) * kRate_hz;
          samples.speed_squares[k] += speed * speed;
        }
        ++samples.steps;
      }
      samples.weights.push_back(frame.weights);
    }
    follows = frame.has_face;
  }
}

}  // namespace

MotionStatistics motion_statistics(std::span<const face::Motion> motions, std::string name) {
  MotionStatistics out;
  out.name = std::move(name);
  constexpr auto kSize = static_cast<Eigen::Index>(kShapeCount);
  out.correlation = Eigen::MatrixXd::Zero(kSize, kSize);
  Samples samples;
  for (const face::Motion& motion : motions) collect(motion, samples);
  const std::size_t frames = samples.weights.size();
  if (frames < 2 || samples.steps == 0) return out;
  out.duration_s = static_cast<double>(frames) / kRate_hz;

  Eigen::MatrixXd x(static_cast<Eigen::Index>(frames), kSize);
  for (std::size_t i = 0; i < frames; ++i)
    for (std::size_t k = 0; k < kShapeCount; ++k) {
      x(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = samples.weights[i][k];
      out.active_shapes += samples.weights[i][k] > kActive ? 1.0 / static_cast<double>(frames) : 0.0;
    }
  const Eigen::RowVectorXd mean = x.colwise().mean();
  x.rowwise() -= mean;
  const Eigen::MatrixXd covariance = x.transpose() * x / static_cast<double>(frames);
  out.dimensions = covariance.trace() * covariance.trace() / std::max(1e-12, covariance.squaredNorm());

  std::vector<float> values(frames);
  std::vector<double> quickness;
  for (std::size_t k = 0; k < kShapeCount; ++k) {
    const auto e = static_cast<Eigen::Index>(k);
    ShapeStatistics& shape = out.shapes[k];
    for (std::size_t i = 0; i < frames; ++i) values[i] = samples.weights[i][k];
    shape.mean = mean[e];
    shape.deviation = std::sqrt(covariance(e, e));
    shape.rest = percentile(values, 0.10);
    shape.p95 = percentile(values, 0.95);
    shape.speed_per_s = std::sqrt(samples.speed_squares[k] / static_cast<double>(samples.steps));
    if (shape.deviation > 1e-6) quickness.push_back(shape.speed_per_s / shape.deviation);
    constexpr double kShare = 1.0 / static_cast<double>(kShapeCount);
    out.mean_weight += kShare * shape.mean;
    out.mean_deviation += kShare * shape.deviation;
    out.mean_rest += kShare * shape.rest;
    out.mean_p95 += kShare * shape.p95;
    out.mean_speed_per_s += kShare * shape.speed_per_s;
  }
  if (!quickness.empty()) out.quickness_per_s = upper_median(std::move(quickness));
  double pairs = 0;
  double sides = 0;
  for (std::size_t a = 0; a < kShapeCount; ++a)
    for (std::size_t b = 0; b < kShapeCount; ++b) {
      const auto row = static_cast<Eigen::Index>(a);
      const auto column = static_cast<Eigen::Index>(b);
      const double scale = out.shapes[a].deviation * out.shapes[b].deviation;
      if (scale < 1e-12) continue;
      const double r = covariance(row, column) / scale;
      out.correlation(row, column) = r;
      if (a >= b) continue;
      if (twin_of(a) == b) {
        out.side_correlation += r;
        ++sides;
      } else {
        out.mean_abs_correlation += std::abs(r);
        ++pairs;
      }
    }
  out.side_correlation /= std::max(1.0, sides);
  out.mean_abs_correlation /= std::max(1.0, pairs);
  return out;
}

MotionStatistics mean_statistics(std::span<const MotionStatistics> people, std::string name) {
  MotionStatistics out;
  out.name = std::move(name);
  constexpr auto kSize = static_cast<Eigen::Index>(kShapeCount);
  out.correlation = Eigen::MatrixXd::Zero(kSize, kSize);
  if (people.empty()) return out;
  const double share = 1 / static_cast<double>(people.size());
  constexpr double ShapeStatistics::*kValues[] = {&ShapeStatistics::mean, &ShapeStatistics::deviation,
                                                  &ShapeStatistics::rest, &ShapeStatistics::p95,
                                                  &ShapeStatistics::speed_per_s};
  for (const MotionStatistics& one : people) {
    for (const MotionSummary& summary : kMotionSummaries)
      out.*summary.value += (summary.value == &MotionStatistics::duration_s ? 1 : share) * one.*summary.value;
    for (std::size_t k = 0; k < kShapeCount; ++k)
      for (const auto member : kValues) out.shapes[k].*member += share * (one.shapes[k].*member);
    out.correlation += share * one.correlation;
  }
  return out;
}

double correlation_agreement(const MotionStatistics& a, const MotionStatistics& b) {
  if (a.correlation.size() != b.correlation.size()) return 0;
  std::vector<double> x;
  std::vector<double> y;
  for (Eigen::Index row = 0; row < a.correlation.rows(); ++row)
    for (Eigen::Index column = row + 1; column < a.correlation.cols(); ++column) {
      x.push_back(a.correlation(row, column));
      y.push_back(b.correlation(row, column));
    }
  const auto count = static_cast<Eigen::Index>(x.size());
  Eigen::Map<Eigen::VectorXd> u(x.data(), count);
  Eigen::Map<Eigen::VectorXd> v(y.data(), count);
  u.array() -= u.mean();
  v.array() -= v.mean();
  const double scale = u.norm() * v.norm();
  return scale > 0 ? u.dot(v) / scale : 0;
}

std::string comparison_markdown(std::span<const MotionStatistics> columns, std::size_t compared) {
  std::string text;
  const auto head = [&] {
    text += "| |";
    for (const auto& column : columns) text += fmt::format(" {} |", in_cell(column.name));
    text += "\n|---|";
    for (std::size_t i = 0; i < columns.size(); ++i) text += "---|";
    text += '\n';
  };
  const auto row = [&](std::string_view label, auto value, int digits) {
    text += fmt::format("| {} |", label);
    for (const auto& column : columns) text += fmt::format(" {:.{}f} |", value(column), digits);
    text += '\n';
  };
  head();
  for (const MotionSummary& summary : kMotionSummaries)
    row(
        summary.label, [&](const MotionStatistics& s) { return s.*summary.value; }, summary.digits);
  for (const MotionStatistics& other : columns.first(std::min(compared, columns.size())))
    row(
        "agreement of correlations with " + in_cell(other.name),
        [&](const MotionStatistics& s) { return correlation_agreement(s, other); }, 2);
  text += "\nStandard deviation of every shape:\n\n";
  head();
  for (std::size_t k = 0; k < kShapeCount; ++k)
    row(
        kShapeNames[k], [k](const MotionStatistics& s) { return s.shapes[k].deviation; }, 3);
  return text;
}

}  // namespace mien::lab
