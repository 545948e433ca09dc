#include "mien/measure/evaluation_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "mien/core/time.h"

namespace mien::measure {
namespace {

std::string number(double value, int decimals) {
  return fmt::format("{:.{}f}", value, decimals);
}

std::string number(const std::optional<double>& value, int decimals) {
  return value ? number(*value, decimals) : "–";
}

std::string spread(const std::optional<MeanStd>& value) {
  return value ? fmt::format("{:.3f} ± {:.3f}", value->mean, value->std) : "–";
}

std::vector<std::string> row(const std::string& name, const Metrics& m) {
  return {name,
          spread(m.pve_mm),
          spread(m.pve_face_mm),
          spread(m.lmk_mm),
          number(m.mse, 4),
          number(m.mse_observed, 4),
          number(m.jitter_ratio, 2),
          number(m.blink_f1, 2)};
}

/// A curve over time, thinned so that a page with minutes of motion stays light: each point the mean of its
/// frames.
Line curve(const std::string& name, const std::vector<float>& values) {
  constexpr std::size_t kPoints = 1200;
  const std::size_t step = std::max<std::size_t>(1, values.size() / kPoints);
  Line line{name, {}, {}};
  for (std::size_t i = 0; i < values.size(); i += step) {
    const std::size_t end = std::min(values.size(), i + step);
    double sum = 0;
    for (std::size_t j = i; j < end; ++j) sum += values[j];
    line.x.push_back(static_cast<double>(i) / kFrameRateHz);
    line.y.push_back(sum / static_cast<double>(end - i));
  }
  return line;
}

std::string against(double ours, const std::optional<double>& ridge) {
  return ridge && *ridge > 0 ? fmt::format("{:.2f} of ridge's {:.3g}", ours / *ridge, *ridge) : "";
}

}  // namespace

Report evaluation_report(const Evaluation& evaluation, const EvaluationContext& context) {
  Report report("Capture against truth",
                fmt::format("{} frames of {} take{} on the face {}, {} profile, {}", evaluation.frames,
                            evaluation.takes, evaluation.takes == 1 ? "" : "s", context.face, context.devices,
                            asked_how(context)));
  for (const std::string& sentence : baselines_ahead(evaluation)) report.text(sentence);
  const Metrics& m = evaluation.model;
  const auto ridge = [&](auto&& pick) -> std::optional<double> {
    if (!evaluation.ridge) return std::nullopt;
    return pick(*evaluation.ridge);
  };
  std::vector<KeyFigure> figures;
  figures.push_back({"Vertex error", number(m.pve_mm.mean, 3) + " mm",
                     against(m.pve_mm.mean, ridge([](const Metrics& r) { return r.pve_mm.mean; }))});
  if (m.lmk_mm)
    figures.push_back(
        {"Landmark error", number(m.lmk_mm->mean, 3) + " mm",
         against(m.lmk_mm->mean, ridge([](const Metrics& r) { return r.lmk_mm ? r.lmk_mm->mean : 0.0; }))});
  figures.push_back(
      {"Weight MSE", number(m.mse, 4), against(m.mse, ridge([](const Metrics& r) { return r.mse; }))});
  if (m.jitter_ratio) figures.push_back({"Jitter", number(*m.jitter_ratio, 2), "1 is the truth's own"});
  report.key_figures(figures);

  Table table;
  table.caption = "The model beside its baselines, on the same frames";
  table.columns = {"",    "PVE, mm",      "PVE face, mm", "landmarks, mm",
                   "MSE", "MSE observed", "jitter",       "blink F1"};
  table.rows.push_back(row("model", m));
  if (evaluation.ridge) table.rows.push_back(row("ridge, one frame", *evaluation.ridge));
  table.rows.push_back(row("hold last second", evaluation.hold_last));
  table.rows.push_back(row("mean pose", evaluation.mean_pose));
  table.strong_rows = {0};
  report.table(table);
  report.text(
      "PVE is the mean distance of all vertices between the captured face and the true one, in "
      "millimetres; landmarks are the 68 of Multi-PIE. MSE is the weights' squared error, MSE observed "
      "that of the shapes that sensors on the skin can measure. Ridge is linear on one frame of the "
      "model's own features. Hold last second is the truth of a second ago, which nobody who captures "
      "has: hard to beat where little moves. Jitter is the third difference of the weights over the "
      "truth's: 1 is as lively as the truth. Blink F1 is 0 where no blink was found: no sensor of the "
      "default rig sits on a lid. Definitions: docs/reference/metrics.md.");

  LinePlot vertices;
  vertices.title = "Vertex error, frame by frame";
  vertices.x_label = "time (s)";
  vertices.y_label = "PVE (mm)";
  vertices.lines.push_back(curve("model", m.pve_mm_curve));
  if (evaluation.ridge) vertices.lines.push_back(curve("ridge", evaluation.ridge->pve_mm_curve));
  vertices.lines.push_back(curve("mean pose", evaluation.mean_pose.pve_mm_curve));
  report.plot(vertices);

  LinePlot weights;
  weights.title = "Weight error, frame by frame";
  weights.x_label = "time (s)";
  weights.y_label = "MSE";
  weights.lines.push_back(curve("model", m.mse_curve));
  if (evaluation.ridge) weights.lines.push_back(curve("ridge", evaluation.ridge->mse_curve));
  report.plot(weights);

  std::vector<std::size_t> order(face::kShapeCount);
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::size_t k) { return std::pair(-m.per_shape[k].mae, k); });
  Table shapes;
  shapes.caption = "Every shape, worst first";
  shapes.columns = {"shape", "mean absolute error", "correlation", "ridge's error", "observed by skin"};
  for (const std::size_t k : order)
    shapes.rows.push_back({std::string(face::kShapeNames[k]), number(m.per_shape[k].mae, 3),
                           number(m.per_shape[k].pearson, 2),
                           evaluation.ridge ? number(evaluation.ridge->per_shape[k].mae, 3) : "–",
                           is_observable(k) ? "yes" : "hardly"});
  report.table(shapes);
  return report;
}

}  // namespace mien::measure
