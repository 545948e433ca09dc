#include "lab/motion_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/core/median.h"
#include "mien/core/random.h"
#include "mien/performer/canvas.h"
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

void collect(const face::Motion& motion, std::vector<MotionRun>& runs) {
  if (motion.frames.empty()) return;
  const face::MotionCurve curve(motion);
  const double begin_s = motion.frames.front().time_s;
  const auto count = static_cast<std::size_t>((motion.frames.back().time_s - begin_s) * kRate_hz) + 1;
  bool follows = false;
  for (std::size_t i = 0; i < count; ++i) {
    const face::MotionFrame frame = curve.at(begin_s + static_cast<double>(i) / kRate_hz);
    if (frame.has_face) {
      if (!follows) runs.emplace_back();
      runs.back().push_back(frame.weights);
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
  std::vector<MotionRun> runs;
  for (const face::Motion& motion : motions) collect(motion, runs);
  std::vector<face::BlendshapeWeights> weights;
  std::array<double, kShapeCount> speed_squares{};
  for (const MotionRun& run : runs) {
    for (std::size_t i = 1; i < run.size(); ++i)
      for (std::size_t k = 0; k < kShapeCount; ++k) {
        const double speed = (run[i][k] - run[i - 1][k]) * kRate_hz;
        speed_squares[k] += speed * speed;
      }
    weights.insert(weights.end(), run.begin(), run.end());
  }
  const std::size_t frames = weights.size(), steps = frames - runs.size();
  if (frames < 2 || steps == 0) return out;
  static_cast<MotionRhythm&>(out) = motion_rhythm(runs, kRate_hz);
  out.duration_s = static_cast<double>(frames) / kRate_hz;

  Eigen::MatrixXd x(static_cast<Eigen::Index>(frames), kSize);
  for (std::size_t i = 0; i < frames; ++i)
    for (std::size_t k = 0; k < kShapeCount; ++k) {
      x(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = weights[i][k];
      out.active_shapes += weights[i][k] > kActive ? 1.0 / static_cast<double>(frames) : 0.0;
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
    for (std::size_t i = 0; i < frames; ++i) values[i] = weights[i][k];
    shape.mean = mean[e];
    shape.deviation = std::sqrt(covariance(e, e));
    shape.rest = percentile(values, 0.10);
    shape.p95 = percentile(values, 0.95);
    shape.speed_per_s = std::sqrt(speed_squares[k] / static_cast<double>(steps));
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
      if (performer::other_side(a) == b) {
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

std::vector<MotionValue> motion_values(const MotionStatistics& motion) {
  std::vector<MotionValue> out;
  for (const MotionSummary& summary : kMotionSummaries)
    if (summary.value != &MotionStatistics::duration_s)
      out.push_back({std::string(summary.name), motion.*summary.value});
  std::array<std::array<double, kShapeGroupNames.size()>, kShapeGroupNames.size()> sums{}, pairs{};
  for (std::size_t a = 0; a < kShapeCount; ++a)
    for (std::size_t b = a + 1; b < kShapeCount; ++b) {
      if (performer::other_side(a) == b) continue;
      const auto [first, second] =
          std::minmax({static_cast<std::size_t>(group_of(a)), static_cast<std::size_t>(group_of(b))});
      sums[first][second] +=
          std::abs(motion.correlation(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)));
      ++pairs[first][second];
    }
  for (std::size_t a = 0; a < kShapeGroupNames.size(); ++a)
    for (std::size_t b = a; b < kShapeGroupNames.size(); ++b)
      out.push_back(
          {fmt::format("{} with {}", kShapeGroupNames[a], kShapeGroupNames[b]), sums[a][b] / pairs[a][b]});
  for (std::size_t k = 0; k < kShapeCount; ++k) {
    const ShapeStatistics& shape = motion.shapes[k];
    for (const auto& [what, value] : {std::pair{"mean", shape.mean}, std::pair{"deviation", shape.deviation},
                                      std::pair{"rest", shape.rest}, std::pair{"95th percentile", shape.p95},
                                      std::pair{"speed", shape.speed_per_s}})
      out.push_back({fmt::format("{} of {}", what, kShapeNames[k]), value});
  }
  return out;
}

std::vector<MotionSpread> motion_spreads(std::span<const MotionStatistics> people,
                                         std::span<const MotionStatistics> compared) {
  std::vector<MotionSpread> out;
  std::vector<std::vector<float>> values;
  for (const MotionStatistics& one : people) {
    const std::vector<MotionValue> all = motion_values(one);
    out.resize(all.size());
    values.resize(all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      out[i].name = all[i].name;
      values[i].push_back(static_cast<float>(all[i].value));
    }
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].low = percentile(values[i], 0.05);
    out[i].median = percentile(values[i], 0.5);
    out[i].high = percentile(values[i], 0.95);
  }
  for (const MotionStatistics& one : compared) {
    const std::vector<MotionValue> all = motion_values(one);
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i].compared.push_back(static_cast<float>(all[i].value));  // As the percentiles.
  }
  return out;
}

Result<std::vector<VirtualKind>> virtual_motion(const VirtualMotionRequest& request,
                                                const Progress& progress) {
  if (request.performers < 1 || !(request.seconds >= 1))
    return fail(ErrorCode::bad_usage, "nobody moves", "study motion", "ask for a performer and a second");
  const auto people = static_cast<std::size_t>(request.performers);
  std::vector<VirtualKind> out;
  for (const Block kind : kVirtualKinds)
    out.push_back({std::string(performer::block_name(kind)), std::vector<MotionStatistics>(people)});
  out.push_back({"training", std::vector<MotionStatistics>(people)});
  MIEN_TRY(virt::for_each_performer(
      out.size() * people, request.threads, progress, [&](std::size_t i) -> Result<void> {
        const Random person = Random(request.seed).fork("person", i % people);
        const std::size_t kind = i / people;
        Random drawn = person.fork("style"), chosen = person.fork("script");
        const performer::Script script = kind < kVirtualKinds.size()
                                             ? performer::default_script(kVirtualKinds[kind], request.seconds)
                                             : performer::random_script(request.seconds, chosen);
        const std::array motions = {
            performer::perform(script, performer::draw_style(drawn), person.fork("motion"))};
        out[kind].people[i % people] = motion_statistics(motions, {});
        return {};
      }));
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

measure::Table spread_table(std::span<const MotionSpread> spreads, std::span<const std::string> names) {
  const auto outside = [&](const MotionSpread& spread) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < spread.compared.size(); ++i) count += spread.holds(i) ? 0 : 1;
    return count;
  };
  std::vector<const MotionSpread*> shown;
  std::vector<std::size_t> held(names.size(), 0);
  for (const MotionSpread& spread : spreads) {
    if (outside(spread) > 0) shown.push_back(&spread);
    for (std::size_t i = 0; i < names.size(); ++i) held[i] += spread.holds(i) ? 1 : 0;
  }
  std::ranges::stable_sort(shown, std::greater{},
                           [&](const MotionSpread* spread) { return outside(*spread); });
  measure::Table table{.caption = "Outside of 90 % of virtual people", .columns = {""}};
  table.columns.insert(table.columns.end(), names.begin(), names.end());
  table.columns.insert(table.columns.end(), {"5 %", "median", "95 %"});
  std::vector<std::string>& first = table.rows.emplace_back();
  first.push_back(fmt::format("inside, of {}", spreads.size()));
  for (const std::size_t count : held) first.push_back(fmt::format("{}", count));
  first.insert(first.end(), {"", "", ""});
  for (const MotionSpread* spread : shown) {
    std::vector<std::string>& cells = table.rows.emplace_back();
    cells.push_back(spread->name);
    for (std::size_t i = 0; i < names.size(); ++i)
      cells.push_back(fmt::format("{:.3f}{}", spread->compared[i], spread->holds(i) ? "" : " !"));
    for (const double value : {spread->low, spread->median, spread->high})
      cells.push_back(fmt::format("{:.3f}", value));
  }
  return table;
}

}  // namespace mien::lab
