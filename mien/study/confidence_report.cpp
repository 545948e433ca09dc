#include "mien/study/confidence_report.h"

#include <fmt/format.h>

#include "mien/core/median.h"
#include "mien/tracker/provenance.h"

namespace mien::study {
namespace {

std::string name_of(const ConfidenceRow& row) {
  return row.lost == 0 ? row.who : fmt::format("{}, {} lost", row.who, row.lost);
}

measure::LinePlot diagram(const std::vector<ConfidenceRow>& rows) {
  measure::LinePlot plot;
  plot.title = "Reliability: how often it came true against what was said";
  plot.x_label = "confidence";
  plot.y_label = "share within 0.1";
  plot.y_low = 0;
  plot.y_high = 1;
  plot.height = 420;
  plot.lines.push_back({"true confidence", {0, 1}, {0, 1}});
  for (const ConfidenceRow& row : rows) {
    measure::Line line{name_of(row), {}, {}};
    for (const Reliability::Bin& bin : row.all.bins()) {
      if (bin.frames == 0) continue;
      line.x.push_back(bin.confidence / bin.frames);
      line.y.push_back(bin.within / bin.frames);
    }
    plot.lines.push_back(std::move(line));
  }
  return plot;
}

measure::Table shapes(const model::ConfidenceTable& table) {
  measure::Table out;
  out.caption = fmt::format("What the sensors explain of each shape's variance; measured from {:.2f} on",
                            table.measured_from);
  out.columns = {"shape", "all sensors", "half of its sensors", "called, with all"};
  const std::size_t whole = table.coverage_bins() - 1;
  const std::size_t half = model::confidence_bin(table.coverage_edges, 0.5F);
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const bool measured = tracker::provenance_of(table, k, whole) == face::Provenance::measured;
    out.rows.push_back(
        {std::string(face::kShapeNames[k]), fmt::format("{:.2f}", table.explained_by(k, whole)),
         fmt::format("{:.2f}", table.explained_by(k, half)), measured ? "measured" : "predicted"});
  }
  return out;
}

}  // namespace

measure::Table confidence_table(const std::vector<ConfidenceRow>& rows) {
  measure::Table out;
  out.caption = "Calibration error (ECE) and correlation with the truth, beside what was said before";
  out.columns = {"",    "people",          "called measured, %", "r of 0.5 or more, %", "before, %",
                 "ECE", "ECE of each one", "ECE moving",         "ECE before",          "kept"};
  for (const ConfidenceRow& row : rows)
    out.rows.push_back({name_of(row), fmt::format("{}", row.people),
                        fmt::format("{:.1f}", 100 * row.measured),
                        fmt::format("{:.1f}", 100 * row.followed.share()),
                        fmt::format("{:.1f}", 100 * row.followed_before.share()),
                        fmt::format("{:.3f}", row.all.expected_error()),
                        fmt::format("{:.3f} ({:.3f} to {:.3f})", upper_median(row.single), row.single.front(),
                                    row.single.back()),
                        fmt::format("{:.3f}", row.moving.expected_error()),
                        fmt::format("{:.3f}", row.all_before.expected_error()), kept(row) ? "yes" : "no"});
  return out;
}

measure::Report confidence_report(const std::vector<ConfidenceRow>& rows, const model::ConfidenceTable& table,
                                  const std::string& subtitle) {
  measure::Report report("How true the confidence is", subtitle);
  report.plot(diagram(rows));
  report.table(confidence_table(rows));
  report.table(shapes(table));
  return report;
}

}  // namespace mien::study
