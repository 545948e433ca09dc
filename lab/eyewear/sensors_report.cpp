#include "lab/eyewear/sensors_report.h"

#include <fmt/format.h>

#include <utility>

namespace mien::lab {
namespace {

constexpr const char* kSensorsTitle = "Markers from photo-reflective eyewear";

std::string mm(double value) {
  return fmt::format("{:.2f}", value);
}

std::vector<std::string> cells(const std::string& name, const SensorsRow& row) {
  std::vector<std::string> out = cells_of(row, sensors_columns());
  out.insert(out.begin(), name);
  return out;
}

measure::Table sensors_table(std::string caption) {
  measure::Table table = table_of(std::move(caption), {}, sensors_columns());
  table.columns.insert(table.columns.begin(), "");
  return table;
}

measure::Table overview(const SensorsStudy& study) {
  measure::Table table = sensors_table("Error of the markers, mm, beside the published one");
  for (const SensorsMethod* method : {&study.faithful, &study.faithful16}) {
    const PublishedSensors& published = method == &study.faithful ? kPublished20 : kPublished16;
    table.rows.push_back(
        cells(fmt::format("published method, {} sensors", method->sensors), method->overall));
    table.rows.push_back(
        {"as published", mm(published.mean_mm), "-", mm(published.eyes_mm), mm(published.mouth_mm)});
  }
  table.rows.push_back(cells("mean pose", study.mean_pose.overall));
  table.strong_rows = {0};
  return table;
}

measure::Table minute_table(const MinuteStudy& minute) {
  measure::Table table =
      sensors_table("After one minute of the wearer's own, without motion capture but for \"linear\", mm");
  for (const auto* methods : {&minute.methods, &minute.conditions})
    for (const SensorsMethod& method : *methods)
      table.rows.push_back(cells(fmt::format("{}, {} sensors", method.name, method.sensors), method.overall));
  table.strong_rows = {2};
  return table;
}

measure::Table wearers(const SensorsStudy& study) {
  measure::Table table = sensors_table("By wearer and by expressions, all sensors, mm");
  for (std::size_t w = 0; w < study.faithful.wearers.size(); ++w)
    table.rows.push_back(cells(fmt::format("wearer {}: {} of {} samples rejected", w + 1,
                                           study.training[w].outliers, study.training[w].samples),
                               study.faithful.wearers[w]));
  for (std::size_t s = 0; s < kTestSets; ++s)
    table.rows.push_back(cells(fmt::format("set {}", sensors_test_set_name(static_cast<SensorsTestSet>(s))),
                               study.faithful.sets[s]));
  return table;
}

measure::BarPlot by_marker(const SensorsStudy& study, const MinuteStudy& minute) {
  measure::BarPlot plot;
  plot.title = "Mean error of each marker";
  plot.value_label = "mm";
  plot.series = {"published method", "without the ear hooks", "mean pose", "learned, one minute"};
  for (std::size_t m = 0; m < study.markers.size(); ++m)
    plot.groups.push_back({fmt::format("{}", m + 1),
                           {study.faithful.markers[m].mean_mm, study.faithful16.markers[m].mean_mm,
                            study.mean_pose.markers[m].mean_mm, minute.learned().markers[m].mean_mm},
                           {}});
  return plot;
}

}  // namespace

const Columns<SensorsRow>& sensors_columns() {
  static const Columns<SensorsRow> columns = {
      {"mean_mm", "mean", "{:.2f}", [](const SensorsRow& row) { return row.all.mean_mm; }},
      {"rmse_mm", "RMSE", "{:.2f}", [](const SensorsRow& row) { return row.all.rmse_mm; }},
      {"eyes_mm", "eyes, nose", "{:.2f}", [](const SensorsRow& row) { return row.eyes_nose.mean_mm; }},
      {"mouth_mm", "mouth", "{:.2f}", [](const SensorsRow& row) { return row.mouth.mean_mm; }},
      {"eyes_rmse_mm", "", "", [](const SensorsRow& row) { return row.eyes_nose.rmse_mm; }},
      {"mouth_rmse_mm", "", "", [](const SensorsRow& row) { return row.mouth.rmse_mm; }}};
  return columns;
}

measure::Report minute_report(const MinuteStudy& minute, const std::vector<std::string>& motions,
                              const std::string& subtitle) {
  measure::Report report(kSensorsTitle, subtitle);
  report.table(minute_table(minute));
  for (std::size_t m = 0; m < motions.size(); ++m) {
    measure::Table table = sensors_table(motions[m] + ", mm");
    for (const SensorsMethod& method : minute.methods)
      table.rows.push_back(cells(method.name, method.tests[m]));
    report.table(table);
  }
  return report;
}

measure::Report sensors_report(const SensorsStudy& study, const MinuteStudy& minute,
                               const std::string& subtitle) {
  measure::Report report(kSensorsTitle, subtitle);
  report.key_figures({{"Mean error", mm(study.faithful.overall.all.mean_mm) + " mm",
                       fmt::format("published {} mm", mm(kPublished20.mean_mm))},
                      {"Eyes and nose", mm(study.faithful.overall.eyes_nose.mean_mm) + " mm",
                       fmt::format("published {} mm", mm(kPublished20.eyes_mm))},
                      {"Mouth", mm(study.faithful.overall.mouth.mean_mm) + " mm",
                       fmt::format("published {} mm", mm(kPublished20.mouth_mm))}});
  report.table(overview(study));
  report.table(minute_table(minute));
  report.bars(by_marker(study, minute));
  measure::Table names;
  names.caption = "Markers by number, mean error, mm";
  names.columns = {"", "marker", "published method", "without the ear hooks", "mean pose", "learned"};
  for (std::size_t m = 0; m < study.markers.size(); ++m) {
    std::vector<std::string>& row = names.rows.emplace_back();
    row = {fmt::format("{}", m + 1), study.markers[m]};
    for (const SensorsMethod* method :
         {&study.faithful, &study.faithful16, &study.mean_pose, &minute.learned()})
      row.push_back(mm(method->markers[m].mean_mm));
  }
  report.table(wearers(study));
  report.table(names);
  return report;
}

}  // namespace mien::lab
