#include "lab/motion_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "mien/core/median.h"
#include "mien/core/random.h"
#include "mien/performer/performer.h"
#include "mien/performer/script.h"
#include "mien/performer/style.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

using performer::Block;

constexpr std::array kVirtualKinds = {Block::range_of_motion, Block::free, Block::expressions, Block::reading,
                                      Block::acted};

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

struct MotionSamples {
  std::vector<face::BlendshapeWeights> weights;
  std::array<double, kShapeCount> speed_squares{};
  std::size_t steps = 0;
};

void collect(const face::Motion& motion, MotionSamples& samples) {
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
  MotionSamples samples;
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

Result<std::vector<MotionStatistics>> virtual_motion(const VirtualMotionRequest& request,
                                                     const Progress& progress) {
  if (request.performers < 1 || !(request.seconds >= 1))
    return fail(ErrorCode::bad_usage, "nobody moves", "study motion", "ask for a performer and a second");
  const auto people = static_cast<std::size_t>(request.performers);
  std::vector<MotionStatistics> each(kVirtualKinds.size() * people);
  MIEN_TRY(
      virt::for_each_performer(each.size(), request.threads, progress, [&](std::size_t i) -> Result<void> {
        const Random person = Random(request.seed).fork("person", i % people);
        Random drawn = person.fork("style");
        const std::array motions = {
            performer::perform(performer::default_script(kVirtualKinds[i / people], request.seconds),
                               performer::draw_style(drawn), person.fork("motion"))};
        each[i] = motion_statistics(motions, {});
        return {};
      }));
  std::vector<MotionStatistics> out;
  for (std::size_t k = 0; k < kVirtualKinds.size(); ++k)
    out.push_back(mean_statistics(std::span(each).subspan(k * people, people),
                                  std::string(performer::block_name(kVirtualKinds[k]))));
  return out;
}

std::vector<measure::Table> motion_tables(std::span<const MotionStatistics> columns, std::size_t compared) {
  std::vector<measure::Table> tables = {{.caption = "Means over shapes"},
                                        {.caption = "Standard deviation of every shape"}};
  for (measure::Table& table : tables) {
    table.columns.emplace_back("");
    for (const MotionStatistics& column : columns) table.columns.push_back(column.name);
  }
  const auto row = [&](measure::Table& table, std::string label, auto value, int digits) {
    std::vector<std::string>& cells = table.rows.emplace_back();
    cells.push_back(std::move(label));
    for (const MotionStatistics& column : columns)
      cells.push_back(fmt::format("{:.{}f}", value(column), digits));
  };
  for (const MotionSummary& summary : kMotionSummaries)
    row(
        tables[0], std::string(summary.label), [&](const MotionStatistics& s) { return s.*summary.value; },
        summary.digits);
  for (const MotionStatistics& other : columns.first(std::min(compared, columns.size())))
    row(
        tables[0], "agreement of correlations with " + other.name,
        [&](const MotionStatistics& s) { return correlation_agreement(s, other); }, 2);
  for (std::size_t k = 0; k < kShapeCount; ++k)
    row(
        tables[1], std::string(kShapeNames[k]),
        [k](const MotionStatistics& s) { return s.shapes[k].deviation; }, 3);
  return tables;
}

}  // namespace mien::lab
