#include "mien/measure/evaluation_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <numeric>

#include "mien/core/time.h"

namespace mien::measure {
namespace {

const std::string kNothing = "–";

std::string number(double value, int decimals) {
  return fmt::format("{:.{}f}", value, decimals);
}

std::string number(const std::optional<double>& value, int decimals) {
  return value ? number(*value, decimals) : kNothing;
}

std::string spread(const std::optional<MeanStd>& value) {
  return value ? fmt::format("{:.3f} ± {:.3f}", value->mean, value->std) : kNothing;
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

/// A curve over time: a point a frame, as far as a drawing that can be zoomed has them; of longer takes each
/// point is the mean of its frames, so that pages stay light.
Line curve(const std::string& name, const std::vector<float>& values) {
  constexpr std::size_t kPoints = 6000;
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

/// An error of the model, and of ridge, over time.
LinePlot over_time(const std::string& what, std::string unit, const Evaluation& evaluation,
                   std::vector<float> Metrics::*values) {
  LinePlot plot{.title = what + ", frame by frame", .x_label = "time (s)", .y_label = std::move(unit)};
  plot.lines.push_back(curve("model", evaluation.model.*values));
  if (evaluation.ridge) plot.lines.push_back(curve("ridge", (*evaluation.ridge).*values));
  return plot;
}

std::string against(double ours, const std::optional<double>& ridge) {
  return ridge && *ridge > 0 ? fmt::format("{:.2f} of ridge's {:.3g}", ours / *ridge, *ridge) : "";
}

/// Leaves out the columns that hold nothing but dashes.
Table without_empty_columns(Table table) {
  for (std::size_t c = table.columns.size(); c-- > 0;) {
    if (std::ranges::any_of(table.rows, [&](const auto& row) { return row[c] != kNothing; })) continue;
    const auto at = static_cast<std::ptrdiff_t>(c);
    table.columns.erase(table.columns.begin() + at);
    for (auto& row : table.rows) row.erase(row.begin() + at);
  }
  return table;
}

/// "measured", or where it came about in several ways "measured 62 %, held 38 %", the most frequent first.
std::string ways(const std::array<double, kProvenanceCount>& shares) {
  std::vector<std::size_t> order(kProvenanceCount);
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::greater{}, [&](std::size_t p) { return shares[p]; });
  std::vector<std::string> said;
  for (const std::size_t p : order)
    if (const std::string_view name = provenance_name(static_cast<face::Provenance>(p)); shares[p] == 1)
      return std::string(name);
    else if (shares[p] > 0)
      said.push_back(fmt::format("{} {:.0f} %", name, 100 * shares[p]));
  return fmt::format("{}", fmt::join(said, ", "));
}

/// Its rows are those of row(); the first is what the others are compared with.
Table metrics_table(const char* caption) {
  return {caption,
          {"", "PVE, mm", "PVE face, mm", "landmarks, mm", "MSE", "MSE of 42", "jitter", "blink F1"},
          {},
          {0}};
}

Table beside_baselines(const Evaluation& evaluation) {
  Table table = metrics_table("The model beside its baselines, on the same frames");
  table.rows.push_back(row("model", evaluation.model));
  if (evaluation.blinking) table.rows.push_back(row("model, with blinks", *evaluation.blinking));
  if (evaluation.ridge) table.rows.push_back(row("ridge, one frame", *evaluation.ridge));
  table.rows.push_back(row("hold last second", evaluation.hold_last));
  table.rows.push_back(row("mean pose", evaluation.mean_pose));
  return without_empty_columns(std::move(table));
}

/// What the rows and columns of beside_baselines() mean: of those alone that are there.
std::string baselines_explained(const Table& table, bool ridge) {
  const auto has = [&](const char* column) { return std::ranges::count(table.columns, column) > 0; };
  std::string text =
      "PVE is the mean distance of all vertices between the captured face and the true one, in millimetres";
  if (has("landmarks, mm")) text += "; landmarks are the 68 of Multi-PIE";
  text +=
      ". MSE is the weights' squared error, MSE of 42 that of a fixed list of shapes, whatever the sensors: "
      "all but gaze, eyeWide and mouthShrugUpper. ";
  if (ridge) text += "Ridge is linear on one frame of the model's own features. ";
  text +=
      "Hold last second is the truth of a second ago, which nobody who captures has: hard to beat where "
      "little moves. ";
  if (has("jitter"))
    text += "Jitter is the third difference of the landmarks over the truth's: 1 is as lively as the truth. ";
  if (has("blink F1"))
    text += "Blink F1 is 0 where no blink was found: no sensor of the default rig sits on a lid. ";
  return text + "Definitions: docs/reference/metrics.md.";
}

Table every_shape(const Evaluation& evaluation) {
  const auto& scores = evaluation.model.per_shape;
  std::vector<std::size_t> order(face::kShapeCount);
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::size_t k) { return std::pair(-scores[k].mae, k); });
  Table table;
  table.caption = "Every shape, worst first";
  table.columns = {"shape", "mean absolute error", "correlation", "ridge's error", "provenance"};
  for (const std::size_t k : order)
    table.rows.push_back({std::string(face::kShapeNames[k]), number(scores[k].mae, 3),
                          number(scores[k].pearson, 2),
                          evaluation.ridge ? number(evaluation.ridge->per_shape[k].mae, 3) : kNothing,
                          evaluation.provenance ? ways((*evaluation.provenance)[k]) : kNothing});
  return without_empty_columns(std::move(table));
}

Table without_steps(const Evaluation& evaluation) {
  Table table = metrics_table("With one step of shaping left out");
  table.rows.push_back(row("all steps", evaluation.model));
  for (const Ablation& one : evaluation.ablations)
    table.rows.push_back(
        row(fmt::format("without {}{}", one.without, one.changed ? "" : " (no bit changes)"), one.metrics));
  return without_empty_columns(std::move(table));
}

}  // namespace

Table eyes_and_lips_table(const Evaluation& evaluation) {
  Table table;
  table.caption = "Eyes, lids and lips";
  table.columns = {"",   "gaze median, °", "gaze p90, °", "openness r", "eyes shut, %", "lips closed F1",
                   "ECE"};
  const bool shuts = evaluation.model.truth_shut > 0 || evaluation.model.shut > 0;
  const auto add = [&](const char* name, const Metrics& metrics, const std::optional<double>& ece) {
    const EyesAndLips of = metrics.eyes_and_lips.value_or(EyesAndLips{});
    table.rows.push_back({name, of.gaze_deg ? number(of.gaze_deg->median, 1) : kNothing,
                          of.gaze_deg ? number(of.gaze_deg->p90, 1) : kNothing,
                          number(of.openness_pearson, 2), shuts ? number(100 * metrics.shut, 1) : kNothing,
                          number(of.lip_gap_f1, 2), number(ece, 3)});
  };
  if (shuts) {
    Metrics truth;
    truth.shut = evaluation.model.truth_shut;
    add("truth", truth, {});
  }
  add("model", evaluation.model, evaluation.ece);
  if (evaluation.blinking) add("model, with blinks", *evaluation.blinking, {});
  if (evaluation.ridge) add("ridge, one frame", *evaluation.ridge, {});
  add("hold last second", evaluation.hold_last, {});
  add("mean pose", evaluation.mean_pose, {});
  table = without_empty_columns(std::move(table));
  if (table.columns.size() == 1) table.rows.clear();
  return table;
}

Table motion_table(const Evaluation& evaluation) {
  Table table;
  table.caption = "About each shape's own rest";
  table.columns = {"", "PVE, mm", "MSE"};
  const auto add = [&](const char* name, const Metrics& metrics) {
    if (const auto& of = metrics.about_rest)
      table.rows.push_back({name, number(of->pve_mm, 3), number(of->mse, 4)});
  };
  add("model", evaluation.model);
  if (evaluation.ridge) add("ridge, one frame", *evaluation.ridge);
  add("hold last second", evaluation.hold_last);
  add("mean pose", evaluation.mean_pose);
  return table;
}

Table wears_table(const Evaluation& evaluation) {
  Table table;
  table.columns = {"", "mean", "95 % from", "to"};
  if (!evaluation.wears) return table;
  const Wears& wears = *evaluation.wears;
  table.caption = fmt::format("The model over {} wears of the sensors", wears.count);
  const auto add = [&](const char* name, const Interval& of, int decimals) {
    table.rows.push_back(
        {name, number(of.mean, decimals), number(of.low, decimals), number(of.high, decimals)});
  };
  add("PVE, mm", wears.pve_mm, 3);
  add("MSE", wears.mse, 4);
  add("PVE about rest, mm", wears.pve_about_rest_mm, 3);
  add("MSE about rest", wears.mse_about_rest, 4);
  return table;
}

Report evaluation_report(const Evaluation& evaluation, const EvaluationContext& context) {
  Report report(
      "Capture against truth",
      fmt::format("{} frames of {} take{} on the face {}, {} profile, {}; model {}", evaluation.frames,
                  evaluation.takes, evaluation.takes == 1 ? "" : "s", context.face, context.devices,
                  asked_how(context), std::filesystem::path(context.model).filename().string()));
  for (const std::string& sentence : caveats(context)) report.text(sentence);
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

  const Table table = beside_baselines(evaluation);
  report.table(table);
  report.text(baselines_explained(table, evaluation.ridge.has_value()));

  if (const Table wears = wears_table(evaluation); !wears.rows.empty()) report.table(wears);
  if (const Table motion = motion_table(evaluation); !motion.rows.empty()) {
    report.table(motion);
    report.text(
        "As an avatar shows it that has a neutral of its own: each shape of an estimate is shifted so that "
        "its "
        "10th percentile over a take is the truth's.");
  }
  if (const Table eyes = eyes_and_lips_table(evaluation); !eyes.rows.empty()) report.table(eyes);

  if (!evaluation.ablations.empty()) {
    report.table(without_steps(evaluation));
    report.text(
        "Each row leaves one step of shaping out and keeps the others: what is worse without it is what it "
        "is worth on these takes. What each does: docs/method/shaping.md.");
  }

  LinePlot vertices = over_time("Vertex error", "PVE (mm)", evaluation, &Metrics::pve_mm_curve);
  vertices.lines.push_back(curve("mean pose", evaluation.mean_pose.pve_mm_curve));
  report.plot(vertices);
  report.plot(over_time("Weight error", "MSE", evaluation, &Metrics::mse_curve));

  report.table(every_shape(evaluation));
  if (evaluation.provenance)
    report.text(
        "Provenance is what the answer itself says of a shape, as the page of a session shows it. Measured: "
        "the model's own table says that the sensors which sent explain enough of it, in people whom the "
        "model never met. Predicted: they tell too little of it, so the answer is a guess.");
  return report;
}

}  // namespace mien::measure
