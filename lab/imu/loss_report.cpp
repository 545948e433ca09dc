#include "lab/imu/loss_report.h"

#include <fmt/format.h>

#include <algorithm>

namespace mien::lab {
namespace {

std::string percent(double share) {
  return fmt::format("{:+.1f} %", 100 * share);
}

std::string allowed(double rise) {
  return fmt::format("at most {} is promised", percent(rise));
}

/// Error against the share that was lost, beginning with the clean condition.
measure::Line curve(const LossStudy& study, Fault fault, const std::string& name) {
  measure::Line line{name, {0}, {study.rows.front().mse}};
  for (const LossRow& row : study.rows)
    if (row.condition.fault == fault) {
      line.x.push_back(row.condition.amount);
      line.y.push_back(row.mse);
    }
  return line;
}

measure::LinePlot curves(const LossStudy& study) {
  measure::LinePlot plot;
  plot.title = "Weight error against lost packets";
  plot.x_label = "packets lost beyond the rig's own (%)";
  plot.y_label = "MSE";
  plot.lines = {curve(study, Fault::loss, "each by itself"),
                curve(study, Fault::bursts, "in bursts of ten packets")};
  double most = 0;
  for (const measure::Line& line : plot.lines) most = std::max(most, line.x.back());
  const double promised = (1 + kRiseAllowedAt10Percent) * study.rows.front().mse;
  plot.lines.push_back({"promised at 10 %", {0, most}, {promised, promised}});
  plot.lines.push_back({"mean pose", {0, most}, {study.mean_pose_mse, study.mean_pose_mse}});
  return plot;
}

measure::BarPlot sensors(const LossStudy& study) {
  measure::BarPlot plot;
  plot.title = "Weight error without one sensor";
  plot.value_label = "MSE";
  plot.series = {"MSE"};
  plot.groups.push_back({"all there", {study.rows.front().mse}, {}});
  for (const LossRow& row : study.rows)
    if (row.condition.fault == Fault::sensor_silent)
      plot.groups.push_back({row.condition.sensor, {row.mse}, {}});
  return plot;
}

}  // namespace

const Columns<LossRow>& loss_columns() {
  static const Columns<LossRow> columns = {
      {"condition", "", "{}", [](const LossRow& row) { return row.condition.name(); }},
      {"frames", "", "", &LossRow::frames},
      {"mse", "MSE", "{:.5f}", &LossRow::mse},
      {"rise", "rise, %", "{:+.1f}", &LossRow::rise, 100},
      {"given_up", "given up, %", "{:+.1f}", &LossRow::given_up, 100},
      {"mse_observed", "MSE of 42", "{:.5f}", &LossRow::mse_observed},
      {"pve_mm", "PVE, mm", "{:.3f}", &LossRow::pve_mm},
      {"observed", "observed, %", "{:.1f}", &LossRow::observed, 100},
      {"rotation_rms_deg", "rotation, °", "{:.1f}", &LossRow::rotation_rms_deg},
      {"largest_step", "largest step", "{:.3f}", &LossRow::largest_step},
      {"truth_step", "truth's", "{:.3f}", &LossRow::truth_step},
      {"unsound_frames", "unsound", "{}", &LossRow::unsound},
      {"mistold_frames", "mistold", "{}", &LossRow::mistold},
      {"performance_mse", "", "", &LossRow::performance_mse}};
  return columns;
}

measure::Report loss_report(const LossStudy& study, const std::string& subtitle) {
  measure::Report report("Accuracy against loss", subtitle);
  const LossRow& clean = study.rows.front();
  std::vector<measure::KeyFigure> figures = {{"Weight MSE, clean", fmt::format("{:.5f}", clean.mse),
                                              fmt::format("mean pose {:.5f}", study.mean_pose_mse)}};
  if (const LossRow* tenth = study.find(Fault::loss, 10))
    figures.push_back({"With 10 % lost", percent(tenth->rise), allowed(kRiseAllowedAt10Percent)});
  if (const LossRow* worst = study.worst_sensor())
    figures.push_back({"Without " + worst->condition.sensor + ", the worst to lose", percent(worst->rise),
                       allowed(kRiseAllowedWithoutASensor)});
  figures.push_back({"Promises", study.kept() ? "kept" : "not kept", ""});
  figures.push_back({"Frames not sound", fmt::format("{}", study.unsound() + study.mistold()), "of all"});
  report.key_figures(figures);
  report.plot(curves(study));
  if (study.worst_sensor() != nullptr) report.bars(sensors(study));
  measure::Table table = table_of("Every condition, on the same performances", study.rows, loss_columns());
  table.strong_rows = {0};
  report.table(table);
  report.text(
      "Each condition is the same performances heard through a worse network or from devices in trouble, the "
      "prologue too. The rig's own faults, lost packets among them, are there in every one, also in the "
      "clean. Rise is of the MSE, against clean. Given up is the share gone of what the model knows, by "
      "which "
      "it beats the mean pose when all is well: 100 is as good as knowing nothing. Felt is the share of the "
      "face sensors' rotations that the model was given; rotation is how far these are off, RMS. Largest "
      "step is "
      "the largest change of any weight from one frame to the next, beside the truth's own. Unsound are "
      "frames with a weight that is no number or outside 0 to 1; mistold are frames that say measured where "
      "no sensor was there, or do not where all were. MSE and PVE: docs/reference/metrics.md.");
  return report;
}

}  // namespace mien::lab
