#include "lab/confidence_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "mien/core/median.h"
#include "mien/face/region_names.h"
#include "mien/tracker/provenance.h"

namespace mien::lab {
namespace {

std::string name_of(const synthetic::ConfidenceRow& row) {
  if (!row.fault.empty()) return fmt::format("{}: {}", row.who, row.fault);
  return row.lost == 0 ? row.who : fmt::format("{}, {} lost", row.who, row.lost);
}

measure::LinePlot empty_diagram(std::string title, std::string y_label) {
  measure::LinePlot plot;
  plot.title = std::move(title);
  plot.x_label = "confidence";
  plot.y_label = std::move(y_label);
  plot.y_low = 0;
  plot.y_high = 1;
  plot.height = 420;
  plot.lines.push_back({"true confidence", {0, 1}, {0, 1}});
  return plot;
}

measure::Line line_of(std::string name, const solve::Reliability& reliability) {
  measure::Line line{std::move(name), {}, {}};
  line.points = true;
  for (const solve::Reliability::Bin& bin : reliability.bins()) {
    if (bin.frames == 0) continue;
    line.x.push_back(bin.confidence / bin.frames);
    line.y.push_back(bin.within / bin.frames);
  }
  return line;
}

measure::LinePlot diagram(const std::vector<synthetic::ConfidenceRow>& rows) {
  measure::LinePlot plot =
      empty_diagram("Reliability: how often it came true against what was said", "share within 0.1");
  for (const synthetic::ConfidenceRow& row : rows) plot.lines.push_back(line_of(name_of(row), row.all));
  return plot;
}

/// Without faults a line a row; with them one of all together, and the one that is kept the least.
measure::LinePlot regions_diagram(const std::vector<synthetic::ConfidenceRow>& rows,
                                  const std::vector<synthetic::ConfidenceRow>& faults) {
  measure::LinePlot plot =
      empty_diagram("Reliability of regions: a mean error of at most 0.1", "share of frames and regions");
  for (const synthetic::ConfidenceRow& row : rows)
    if (row.lost == 0) plot.lines.push_back(line_of(name_of(row), row.regions.all));
  if (faults.empty()) return plot;
  solve::RegionTally all;
  for (const synthetic::ConfidenceRow& row : faults) all.add(row.regions);
  const auto error = [](const synthetic::ConfidenceRow& row) { return row.regions.all.expected_error(); };
  const synthetic::ConfidenceRow& worst = *std::ranges::max_element(faults, {}, error);
  plot.lines.push_back(line_of("all faults", all.all));
  plot.lines.push_back(line_of(name_of(worst), worst.regions.all));
  return plot;
}

/// Region by region, over all rows together.
measure::LinePlot each_region(const std::vector<synthetic::ConfidenceRow>& rows,
                              const std::vector<synthetic::ConfidenceRow>& faults) {
  solve::RegionTally all;
  for (const synthetic::ConfidenceRow& row : rows) all.add(row.regions);
  for (const synthetic::ConfidenceRow& row : faults) all.add(row.regions);
  measure::LinePlot plot = empty_diagram("Region by region, all rows together", "share of frames");
  for (std::size_t r = 0; r < face::kShapeRegionCount; ++r)
    plot.lines.push_back(line_of(std::string(face::kShapeRegionNames[r]), all.each[r]));
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

measure::Table confidence_table(const std::vector<synthetic::ConfidenceRow>& rows) {
  measure::Table out;
  out.caption = "Calibration error (ECE) and correlation with the truth, beside what was said before";
  out.columns = {"",    "people",          "called measured, %", "r of 0.5 or more, %", "before, %",
                 "ECE", "ECE of each one", "ECE moving",         "ECE before",          "kept"};
  for (const synthetic::ConfidenceRow& row : rows)
    out.rows.push_back(
        {name_of(row), fmt::format("{}", row.people), fmt::format("{:.1f}", 100 * row.measured),
         fmt::format("{:.1f}", 100 * row.followed.share()),
         fmt::format("{:.1f}", 100 * row.followed_before.share()),
         fmt::format("{:.3f}", row.all.expected_error()),
         fmt::format("{:.3f} ({:.3f} to {:.3f})", upper_median(row.single), row.single.front(),
                     row.single.back()),
         fmt::format("{:.3f}", row.moving.expected_error()),
         fmt::format("{:.3f}", row.all_before.expected_error()), synthetic::kept(row) ? "yes" : "no"});
  return out;
}

measure::Table regions_table(const std::vector<synthetic::ConfidenceRow>& rows,
                             const std::vector<synthetic::ConfidenceRow>& faults) {
  measure::Table out;
  out.caption = "Confidence of regions: calibration error (ECE) and area under the ROC curve (AUC)";
  out.columns = {"", "people", "within, %", "ECE", "ECE of each one", "AUC"};
  for (const std::string_view region : face::kShapeRegionNames) {
    out.columns.push_back(fmt::format("{}: ECE", region));
    out.columns.emplace_back("AUC");
  }
  out.columns.emplace_back("kept");
  for (const auto* list : {&rows, &faults})
    for (const synthetic::ConfidenceRow& row : *list) {
      double frames = 0, within = 0;
      for (const solve::Reliability::Bin& bin : row.regions.all.bins()) {
        frames += bin.frames;
        within += bin.within;
      }
      std::vector<std::string>& cells = out.rows.emplace_back();
      cells = {name_of(row),
               fmt::format("{}", row.people),
               fmt::format("{:.1f}", frames > 0 ? 100 * within / frames : 0),
               fmt::format("{:.3f}", row.regions.all.expected_error()),
               fmt::format("{:.3f} ({:.3f} to {:.3f})", upper_median(row.regions_single),
                           row.regions_single.front(), row.regions_single.back()),
               fmt::format("{:.3f}", row.regions.roc.area())};
      for (std::size_t r = 0; r < face::kShapeRegionCount; ++r) {
        cells.push_back(fmt::format("{:.3f}", row.regions.each[r].expected_error()));
        cells.push_back(fmt::format("{:.3f}", row.regions.roc_each[r].area()));
      }
      cells.emplace_back(synthetic::regions_kept(row) ? "yes" : "no");
    }
  return out;
}

}  // namespace

measure::Report confidence_report(const std::vector<synthetic::ConfidenceRow>& rows,
                                  const std::vector<synthetic::ConfidenceRow>& faults,
                                  const model::ConfidenceTable& table, const std::string& subtitle) {
  measure::Report report("How true the confidence is", subtitle);
  report.plot(diagram(rows));
  report.table(confidence_table(rows));
  if (!faults.empty()) {
    report.heading("Under faults");
    report.table(confidence_table(faults));
  }
  if (table.regions) {
    report.heading("Regions");
    report.plot(regions_diagram(rows, faults));
    report.plot(each_region(rows, faults));
    report.table(regions_table(rows, faults));
  }
  report.table(shapes(table));
  return report;
}

}  // namespace mien::lab
