#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "lab/imu/live_study.h"
#include "mien/core/time.h"

namespace mien::lab {
namespace {

/// "0.70 ± 0.14"; of one performer the figure alone.
std::string figure(const LiveMethod& method, std::size_t measure) {
  const std::optional<measure::MeanStd> value = method.over(static_cast<Measure>(measure));
  const int decimals = kMeasures[measure].decimals;
  if (!value) return "-";
  if (method.performers.size() < 2) return fmt::format("{:.{}f}", value->mean, decimals);
  return fmt::format("{:.{}f} ± {:.{}f}", value->mean, decimals, value->std, decimals);
}

measure::BarPlot plot_of(std::string_view group, const LiveSet& set) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  measure::BarPlot plot{
      .title = fmt::format("{}: vertex error", group), .value_label = "PVE (mm)", .series = {}, .groups = {}};
  for (const LiveRow& row : set.rows) {
    if (names_of(row.condition).group != group) continue;
    measure::BarPlot::Group bars{row.title, {}, {}};
    plot.series.clear();
    for (const LiveMethod& method : row.methods) {
      const std::optional<measure::MeanStd> value = method.over(Measure::pve);
      plot.series.push_back(method.name);
      bars.values.push_back(value ? value->mean : kNone);
      bars.spread.push_back(value ? value->std : kNone);
    }
    plot.groups.push_back(std::move(bars));
  }
  return plot;
}

/// The first model, where all is as in training, against a line through one frame.
std::vector<measure::KeyFigure> key_figures(const LiveSet& set) {
  std::vector<measure::KeyFigure> figures;
  for (const LiveRow& row : set.rows) {
    if (row.condition != LiveCondition::lab && row.condition != LiveCondition::seen) continue;
    const std::optional<measure::MeanStd> live = row.methods.front().over(Measure::pve);
    const LiveMethod* ridge = row.find(kRidge);
    const std::optional<measure::MeanStd> line = ridge != nullptr ? ridge->over(Measure::pve) : std::nullopt;
    if (live)
      figures.push_back({fmt::format("{}, {}", row.methods.front().name, row.title),
                         fmt::format("{:.3f} mm", live->mean),
                         line ? fmt::format("vertex error; ridge {:.3f}", line->mean) : "vertex error"});
  }
  return figures;
}

std::string live_legend() {
  return "Mean ± standard deviation over performers, each with a face, a style and devices of their own; "
         "every method "
         "on the same frames. Felt: share of the face sensors' rotations that were there; off: how far these "
         "lie from the truth, RMS. A window network sees up to a second of the future and answers a second "
         "late; "
         "the models by name answer frame by frame. Hold last is the truth of a second ago. The sensor bound "
         "is what "
         "one frame of rotations with that error tells at best by a linear map, shapes being independent "
         "beforehand "
         "and as wide as the performer's are around the mean pose: what knows more than that, of faces or of "
         "the past, "
         "can be below it. All else: docs/reference/metrics.md.";
}

}  // namespace

measure::Table live_table(const LiveSet& set) {
  measure::Table table;
  table.caption = set.who;
  table.columns.emplace_back("");
  for (const MeasureNames& measure : kMeasures) table.columns.emplace_back(measure.head);
  for (const LiveRow& row : set.rows) {
    table.strong_rows.push_back(table.rows.size());
    table.rows.push_back({fmt::format(
        "{} ({} performer{}, {:.0f} s, {:.1f} % observed, {:.1f}° off)", row.title,
        row.methods.front().performers.size(), row.methods.front().performers.size() == 1 ? "" : "s",
        static_cast<double>(row.frames) / kFrameRateHz, 100 * row.observed, row.rotation_rms_deg)});
    for (const LiveMethod& method : row.methods) {
      std::vector<std::string>& cells = table.rows.emplace_back();
      cells.push_back(method.name);
      for (std::size_t m = 0; m < kMeasureCount; ++m) cells.push_back(figure(method, m));
    }
  }
  return table;
}

measure::Report live_report(const LiveStudy& study, const std::string& subtitle) {
  measure::Report report("The live model beside the others", subtitle);
  for (const LiveSet& set : study.sets) {
    if (study.sets.size() > 1) report.heading(set.who);
    if (const std::vector<measure::KeyFigure> figures = key_figures(set); !figures.empty())
      report.key_figures(figures);
    std::string_view last;
    for (const LiveConditionNames& condition : kLiveConditions) {
      if (condition.group == last) continue;
      last = condition.group;
      if (const measure::BarPlot plot = plot_of(last, set); !plot.groups.empty()) report.bars(plot);
    }
    report.table(live_table(set));
  }
  report.text(live_legend());
  return report;
}

}  // namespace mien::lab
