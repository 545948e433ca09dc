#include <fmt/format.h>

#include <array>
#include <utility>
#include <vector>

#include "lab/imu/ablation/ablation_study.h"

namespace mien::lab {
namespace {

constexpr std::array kShownSets = {TestSet::device, TestSet::lab, TestSet::strangers, TestSet::recorded,
                                   TestSet::seen};

std::string title_of(TestSet set) {
  switch (set) {
    case TestSet::device:
      return "People like those of the training, device profile";
    case TestSet::lab:
      return "The same people, lab profile";
    case TestSet::strangers:
      return "People unlike those of the training, device profile";
    case TestSet::recorded:
      return "Recorded performances, device profile";
    case TestSet::seen:
      return "People who were trained on, lab profile";
  }
  return {};
}

/// Without an interval where one figure is all there is.
std::string percent(const std::optional<measure::Interval>& change) {
  if (!change) return "–";
  if (!(change->half() > 0)) return fmt::format("{:+.1f} %", 100 * change->mean);
  return fmt::format("{:+.1f} ± {:.1f} %", 100 * change->mean, 100 * change->half());
}

std::string with_interval(const measure::SeedFigures& figures) {
  const measure::Interval of = measure::mean_interval(figures);
  if (!(of.half() > 0)) return fmt::format("{:.3f}", of.mean);
  return fmt::format("{:.3f} ± {:.3f}", of.mean, of.half());
}

const AblationResult* find_row(const AblationStudy& study, std::string_view name) {
  for (const AblationResult& row : study.rows)
    if (row.row.name == name) return &row;
  return nullptr;
}

std::string group_title(const std::string& group) {
  if (group == "sensors") return "sensors";
  if (group == "data") return "data";
  if (group == "networks") return "networks";
  if (group == "windows") return "windows";
  return "trained before, by a budget of their own";
}

/// A row of CAPUS's Table 1 over its first.
struct PaperChange {
  const char* row;
  double pve, lmk, mse;
};
constexpr std::array kPaperChanges = {
    PaperChange{"five_sensors", 0.078 / 0.075 - 1, 0.129 / 0.126 - 1, 0.0082 / 0.0075 - 1},
    PaperChange{"five_upper", 0.078 / 0.075 - 1, 0.129 / 0.126 - 1, 0.0082 / 0.0075 - 1},
    PaperChange{"third_of_people", 0.089 / 0.075 - 1, 0.150 / 0.126 - 1, 0.0093 / 0.0075 - 1}};

measure::BarPlot changes_plot(const AblationStudy& study) {
  measure::BarPlot plot;
  plot.title = "Vertex error, people like those of the training, device profile; bars of 95 % confidence";
  plot.value_label = "PVE (mm)";
  plot.series = {"PVE"};
  for (const auto* rows : {&study.rows, &study.shipped})
    for (const AblationResult& row : *rows) {
      const SeedErrors& errors = row.on(TestSet::device);
      if (errors.empty()) continue;
      const measure::Interval of = measure::mean_interval(errors.pve_mm);
      plot.groups.push_back({row.row.title, {of.mean}, {of.half()}});
    }
  return plot;
}

measure::Table ablation_table(const AblationStudy& study, TestSet set) {
  measure::Table table;
  table.caption = title_of(set);
  table.columns = {"", "PVE, mm", "change of PVE", "landmarks, mm", "MSE", "change of MSE", "jitter"};
  std::string group;
  for (const auto* rows : {&study.rows, &study.shipped})
    for (const AblationResult& row : *rows) {
      const SeedErrors& errors = row.on(set);
      if (errors.empty()) continue;
      if (row.row.group != group) {
        group = row.row.group;
        table.rows.push_back({group_title(group)});
      }
      const auto figures = [&](measure::SeedFigures SeedErrors::*measure) {
        return figures_of(row, set, measure);
      };
      table.rows.push_back({row.row.title, with_interval(figures(&SeedErrors::pve_mm)),
                            percent(change_of(study, row, set)), with_interval(figures(&SeedErrors::lmk_mm)),
                            fmt::format("{:.4f}", measure::mean_interval(errors.mse).mean),
                            percent(change_of(study, row, set, &SeedErrors::mse)),
                            fmt::format("{:.2f}", measure::mean_interval(errors.jitter).mean)});
      if (&row == study.rows.data()) table.strong_rows.push_back(table.rows.size() - 1);
    }
  return table;
}

measure::Table beside_the_paper(const AblationStudy& study) {
  measure::Table table;
  table.caption = "Change against all sensors and all data, beside CAPUS's Table 1 and the linear bound";
  table.columns = {"", "", "PVE", "landmarks", "MSE"};
  const AblationResult& base = study.rows.front();
  for (const PaperChange& paper : kPaperChanges) {
    const AblationResult* row = find_row(study, paper.row);
    if (row == nullptr) continue;
    const auto share = [](double value) { return fmt::format("{:+.0f} %", 100 * value); };
    table.rows.push_back({row->row.title, "CAPUS", share(paper.pve), share(paper.lmk), share(paper.mse)});
    for (const TestSet set : {TestSet::device, TestSet::lab}) {
      const auto change = [&](measure::SeedFigures SeedErrors::*measure) {
        return percent(change_of(study, *row, set, measure));
      };
      table.rows.push_back({"", set == TestSet::device ? "here, device" : "here, lab",
                            change(&SeedErrors::pve_mm), change(&SeedErrors::lmk_mm),
                            change(&SeedErrors::mse)});
    }
    if (row->row.sensors != base.row.sensors && base.bound_mse > 0)
      table.rows.push_back({"", "linear bound, one frame", share(row->bound_pve_mm / base.bound_pve_mm - 1),
                            "–", share(row->bound_mse / base.bound_mse - 1)});
  }
  return table;
}

std::string ablation_legend(const AblationStudy& study, const std::string& takes) {
  return fmt::format(
      "Every network but the shipped ones was trained for as many steps, each of as many frames. Recurrent "
      "networks answer frame by frame, and but for one row changes from frame to frame are in their loss; "
      "transformers see a whole window, half of it from the future, and are not live. Figures are means over "
      "seeds and people, with the half width of their 95 % confidence interval (Student's t) over both; of "
      "shipped models over people, of recordings over seeds. The change is against the first row, of the "
      "same people in the same performances and the same seeds. Fewer sensors are worn anew: where each "
      "sits, the skin below it and its device's faults are drawn again, which widens their intervals. "
      "Virtual performers: {} people, {:.0f} minutes.{} People unlike those of the training move otherwise, "
      "and "
      "have skin as their face's mesh has it. PVE is the mean distance of all vertices between the captured "
      "face and the true one; MSE is of the 53 weights; jitter is the third difference of the landmarks over "
      "the truth's.",
      study.training_people, study.training_minutes, takes.empty() ? "" : fmt::format(" Takes: {}.", takes));
}

}  // namespace

std::optional<measure::Interval> change_of(const AblationStudy& study, const AblationResult& row, TestSet set,
                                           measure::SeedFigures SeedErrors::*measure) {
  // Of those who are trained on, rows with fewer people have others.
  const bool others = set == TestSet::seen && row.row.one_in > 1;
  if (&row == study.rows.data() || row.row.group == kShippedGroup || others) return std::nullopt;
  const measure::SeedFigures figures = figures_of(row, set, measure),
                             base = figures_of(study.rows.front(), set, measure);
  if (figures.size() != base.size() || base.empty() || figures.front().size() != base.front().size())
    return std::nullopt;
  return measure::change_interval(figures, base);
}

measure::Report ablation_report(const AblationStudy& study, const std::string& takes,
                                const std::string& subtitle) {
  measure::Report report("What fewer sensors, less data and other networks cost", subtitle);
  std::vector<measure::KeyFigure> keys;
  const auto key = [&](const char* name, const char* title) {
    const AblationResult* row = find_row(study, name);
    if (row == nullptr) return;
    const std::optional<measure::Interval> change = change_of(study, *row, TestSet::device);
    if (change)
      keys.push_back({title, fmt::format("{:+.0f} %", 100 * change->mean),
                      change->half() > 0 ? fmt::format("{:+.0f} to {:+.0f} % vertex error", 100 * change->low,
                                                       100 * change->high)
                                         : "vertex error; of one figure"});
  };
  key("five_sensors", "Five sensors instead of all");
  key("third_of_people", "A third of the people");
  key("diffusion", "Diffusion instead of recurrent");
  report.key_figures(keys);
  if (const measure::Table paper = beside_the_paper(study); !paper.rows.empty()) {
    report.table(paper);
    report.text(
        "CAPUS (AAAI 2025) trained and tried on recordings of its own, which nobody else has; its changes "
        "are shown, since its millimetres are of another face and unit. The linear bound is what one frame "
        "of orientations can tell at best, every shape independent of the others (mien study placement).");
  }
  report.bars(changes_plot(study));
  for (const TestSet set : kShownSets)
    if (const measure::Table table = ablation_table(study, set); !table.rows.empty()) report.table(table);
  report.text(ablation_legend(study, takes));
  return report;
}

}  // namespace mien::lab
