#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "lab/imu/placement/placement_study.h"
#include "mien/core/units.h"

namespace mien::lab {
namespace {

std::string told_percent(double share) {
  return fmt::format("{:.1f} %", 100 * share);
}

std::vector<std::string> set_cells(const PlacementRow& row) {
  std::vector<std::string> cells = {row.title, fmt::format("{:.3f}", row.rms_vertex_mm),
                                    fmt::format("{:.3f}", row.bound.pve_mm.mean),
                                    fmt::format("{:.5f}", row.bound.mse)};
  for (const double ratio : row.group_ratios) cells.push_back(fmt::format("{:.2f}", ratio));
  return cells;
}

std::string place_text(const Vec3& p_m) {
  return fmt::format("{:.0f} {:.0f} {:.0f}", kMmPerM * p_m.x(), kMmPerM * p_m.y(), kMmPerM * p_m.z());
}

std::string interval_text(const SeedFigures& figures, int decimals) {
  if (figures.empty()) return "-";
  const Interval value = mean_interval(figures);
  return fmt::format("{:.{}f} ± {:.{}f}", value.mean, decimals, 0.5 * (value.high - value.low), decimals);
}

/// What the area's sites are, as shares of their mean.
double area_mean(const std::vector<PaperSiteFelt>& sites, std::string_view area,
                 double (*value)(const PaperSiteFelt&)) {
  double sum = 0, count = 0;
  for (const PaperSiteFelt& site : sites)
    if (site.site.area == area) {
      sum += value(site);
      ++count;
    }
  return count > 0 ? sum / count : 0;
}

double paper_value(const PaperSiteFelt& s) {
  return s.site.variation;
}
double acceleration_value(const PaperSiteFelt& s) {
  return s.acceleration;
}

/// The number of the area's site that feels most.
int strongest_site(const std::vector<PaperSiteFelt>& sites, std::string_view area,
                   double (*value)(const PaperSiteFelt&)) {
  int number = 0;
  double most = -1;
  for (const PaperSiteFelt& site : sites)
    if (site.site.area == area && value(site) > most) {
      most = value(site);
      number = site.site.number;
    }
  return number;
}

/// The set that was asked for.
const PlacementRow& chosen_row(const PlacementStudy& study) {
  return *std::ranges::find(study.sets, study.chosen.size(),
                            [](const PlacementRow& row) { return row.sensors.size(); });
}

measure::LinePlot placement_curve(const PlacementStudy& study) {
  measure::LinePlot plot;
  plot.title = "What a set of sensors leaves, by how many there are";
  plot.x_label = "sensors";
  plot.y_label = "RMS vertex error (mm)";
  measure::Line greedy{.name = "greedy", .x = {}, .y = {}, .points = true};
  for (const PlacementRow& row : study.sets) {
    greedy.x.push_back(static_cast<double>(row.sensors.size()));
    greedy.y.push_back(row.rms_vertex_mm);
  }
  measure::Line paper{.name = "the paper's", .x = {}, .y = {}, .points = true};
  for (const PlacementRow* row : {&study.paper_five, &study.paper}) {
    paper.x.push_back(static_cast<double>(row->sensors.size()));
    paper.y.push_back(row->rms_vertex_mm);
  }
  plot.lines = {std::move(greedy), std::move(paper)};
  plot.y_low = 0;
  return plot;
}

std::string objective_words(PlacementObjective objective) {
  switch (objective) {
    case PlacementObjective::vertex:
      return "the expected squared displacement of the skin's vertices";
    case PlacementObjective::mse:
      return "the expected squared error of the 53 weights";
    case PlacementObjective::groups:
      return "the expected squared error of the weights, brows, eyes, cheeks, mouth and jaw counting alike";
  }
  return {};
}

measure::Table placement_sets_table(const PlacementStudy& study) {
  measure::Table table;
  table.caption =
      "Sets by the linear bound; of the groups of shapes what is left of their prior standard deviation (1: "
      "nothing is known of them)";
  table.columns = {"", "RMS, mm", "PVE, mm", "MSE"};
  for (const std::string_view group : kShapeGroups) table.columns.emplace_back(group);
  for (const PlacementRow& row : study.sets) {
    if (row.sensors.size() == study.chosen.size()) table.strong_rows.push_back(table.rows.size());
    table.rows.push_back(set_cells(row));
    if (row.sensors.size() == study.paper_five.sensors.size())
      table.rows.push_back(set_cells(study.paper_five));
    if (row.sensors.size() == study.paper.sensors.size()) table.rows.push_back(set_cells(study.paper));
  }
  return table;
}

measure::Table placement_sites_table(const PlacementStudy& study) {
  measure::Table table;
  table.caption =
      "The chosen sensors: place on the built-in head (frame H, mm), share of the objective that each tells "
      "alone, and which shapes (share of their variance)";
  table.columns = {"", "sensor", "x y z", "alone", "tells"};
  for (std::size_t i = 0; i < study.chosen.size(); ++i) {
    const std::size_t c = study.chosen[i];
    table.rows.push_back({fmt::format("{}", i + 1), study.candidates[c].name,
                          place_text(study.candidates[c].position_m), told_percent(study.alone[c]),
                          top_shapes(study.alone_posterior[c])});
  }
  return table;
}

measure::Table placement_candidates_table(const PlacementStudy& study) {
  measure::Table table;
  table.caption = "Candidates, each alone: share of the objective that it tells, and which shapes";
  table.columns = {"candidate", "area", "x y z", "alone", "tells"};
  for (std::size_t i = 0; i < study.grid_begin; ++i)
    table.rows.push_back({study.candidates[i].name, study.candidates[i].area,
                          place_text(study.candidates[i].position_m), told_percent(study.alone[i]),
                          top_shapes(study.alone_posterior[i])});
  return table;
}

measure::Table placement_paper_table(const PlacementStudy& study) {
  measure::Table table;
  table.caption =
      "The paper's Table 2 beside the same areas moved by virtual people; in brackets: against the "
      "area's mean. * is used by the paper's rig";
  table.columns = {
      "site", "paper, 1e-3", "skin's acceleration, (m/s2)2", "accelerometer, (m/s2)2", "rotation RMS, deg",
      "alone"};
  const std::vector<PaperSiteFelt>& sites = study.paper_sites.sites;
  for (const PaperSiteFelt& site : sites) {
    const std::string_view area = site.site.area;
    double alone = 0, sides = 0;
    for (std::size_t i = 0; i < study.grid_begin; ++i)
      if (const PaperSite* of = paper_site_of(study.candidates[i]);
          of != nullptr && of->name == site.site.name) {
        alone += study.alone[i];
        ++sides;
      }
    table.rows.push_back({fmt::format("{} {}{}", area, site.site.number, site.site.used ? " *" : ""),
                          fmt::format("{:.2f} ({:.2f})", site.site.variation,
                                      site.site.variation / area_mean(sites, area, paper_value)),
                          fmt::format("{:.4f} ({:.2f})", site.acceleration,
                                      site.acceleration / area_mean(sites, area, acceleration_value)),
                          fmt::format("{:.3f}", site.accelerometer), fmt::format("{:.2f}", site.rotation_deg),
                          sides > 0 ? told_percent(alone / sides) : "-"});
  }
  return table;
}

std::string placement_paper_words(const PlacementStudy& study) {
  const PaperSitesStudy& felt = study.paper_sites;
  std::string words = fmt::format(
      "Rank correlation with the paper's table over all sites, each as a share of its area's mean: {:+.2f} "
      "for the skin's acceleration, {:+.2f} for what an accelerometer reads, {:+.2f} for the rotation.",
      felt.acceleration.all, felt.accelerometer.all, felt.rotation.all);
  for (std::size_t a = 0; a < kPaperAreas.size(); ++a) {
    const int paper = strongest_site(felt.sites, kPaperAreas[a], paper_value);
    const int ours = strongest_site(felt.sites, kPaperAreas[a], acceleration_value);
    if (paper == 0) continue;
    words += fmt::format(" {}: {} is strongest in the paper, {} here ({}; rank correlation {:+.2f}).",
                         kPaperAreas[a], paper, ours, paper == ours ? "they agree" : "they do not agree",
                         felt.acceleration.areas[a]);
  }
  return words +
         " The paper gives neither units nor coordinates nor how the areas were moved; its unused sites were "
         "placed here by anatomy (rigs/candidates.toml). So orders can be compared, magnitudes cannot; and "
         "an order of four or five says little.";
}

std::string placement_legend(const PlacementRequest& request) {
  return fmt::format(
      "The bound is what one frame of orientations tells at best by a linear map: noise of {:.2g} degrees an "
      "axis, shapes independent beforehand with a standard deviation of {:.2g}. Sites are chosen one step "
      "after the other so that {} becomes least; {}. RMS is the root of the expected squared displacement of "
      "the skin's vertices, PVE the mean displacement. Between the sites of the default rig the built-in "
      "skin "
      "is nobody's measurement. Method: docs/method/placement.md.",
      kDegPerRad * request.settings.noise_rad, request.settings.prior, objective_words(request.objective),
      request.settings.one_sided ? "each side for itself" : "left and right alike");
}

std::vector<std::string> placement_remarks(const PlacementStudy& study) {
  std::vector<std::string> words;
  constexpr double kUnseen = 0.99;  // Posterior over prior.
  std::vector<std::string_view> unseen;
  const PlacementRow& chosen = chosen_row(study);
  for (std::size_t g = 0; g < kShapeGroups.size(); ++g)
    if (chosen.group_ratios[g] > kUnseen) unseen.push_back(kShapeGroups[g]);
  if (!unseen.empty())
    words.push_back(
        fmt::format("The chosen {} tell nothing of {}: the objective hardly counts them. `--objective "
                    "groups` counts brows, "
                    "eyes, cheeks, mouth and jaw alike.",
                    chosen.sensors.size(), fmt::join(unseen, " and ")));
  if (!study.without_mirror.empty())
    words.push_back(
        fmt::format("Not chosen from, since nothing mirrors them on the other side: {}. `--one-sided` takes "
                    "each side for "
                    "itself.",
                    fmt::join(study.without_mirror, ", ")));
  return words;
}

}  // namespace

measure::Table placement_trained_table(const PlacementStudy& study, const PlacementTrainingRequest& request) {
  measure::Table table;
  table.caption = fmt::format(
      "Networks with the same budget (trainings a set: {}; steps of each: {}; virtual performers: {}), on {} "
      "people whom nobody trained on: mean, 95 % interval",
      request.seeds, request.steps, request.data.performers, request.test_people);
  table.columns = {"", "sensors", "PVE device, mm", "MSE device", "PVE lab, mm", "MSE lab"};
  for (const TrainedPlacement& row : study.trained)
    table.rows.push_back({row.title, fmt::format("{}", row.sensors), interval_text(row.device.pve_mm, 3),
                          interval_text(row.device.mse, 4), interval_text(row.lab.pve_mm, 3),
                          interval_text(row.lab.mse, 4)});
  return table;
}

std::vector<std::string> placement_verdicts(const PlacementStudy& study, const PlacementRequest& request) {
  std::vector<std::string> words;
  if (request.quick && !study.contests.empty()) {
    words.emplace_back("Trainings so short and people so few show that it works, and compare nothing.");
  } else {
    for (const PlacementContest& one : study.contests) words.push_back(one.verdict());
  }
  if (!study.not_trained.empty()) words.push_back(study.not_trained);
  return words;
}

Result<measure::Report> placement_report(const PlacementStudy& study, const PlacementRequest& request,
                                         const std::string& subtitle) {
  measure::Report report("Where to glue sensors", subtitle);
  const PlacementRow& chosen = chosen_row(study);
  const PlacementRow* same = nullptr;  // Of the paper's that has as many sensors.
  for (const PlacementRow* paper : {&study.paper, &study.paper_five})
    if (paper->sensors.size() == chosen.sensors.size()) same = paper;
  std::vector<measure::KeyFigure> figures = {
      {fmt::format("Vertex error of the chosen {}, by the bound", chosen.sensors.size()),
       fmt::format("{:.3f} mm", chosen.rms_vertex_mm),
       same != nullptr ? fmt::format("RMS; {} {:.3f}", same->title, same->rms_vertex_mm) : "RMS"}};
  if (!request.quick)
    for (const PlacementContest& one : study.contests)
      figures.push_back({fmt::format("{} against {}", one.ours, one.paper),
                         fmt::format("{:+.1f} %", 100 * one.device.mean),
                         fmt::format("vertex error by trainings, {:+.1f} to {:+.1f}", 100 * one.device.low,
                                     100 * one.device.high)});
  report.key_figures(figures);
  for (const std::string& sentence : placement_remarks(study)) report.text(sentence);
  MIEN_TRY_ASSIGN(const std::vector<std::byte> png, render::encode_png(study.picture));
  report.image(
      png,
      "What one sensor would tell at each place, as a share of the objective; dots are the chosen sensors");
  report.plot(placement_curve(study));
  report.table(placement_sets_table(study));
  report.table(placement_sites_table(study));
  const std::vector<std::string> verdicts = placement_verdicts(study, request);
  if (!study.trained.empty() || !verdicts.empty()) report.heading("By short trainings");
  if (!study.trained.empty()) report.table(placement_trained_table(study, request.training));
  for (const std::string& sentence : verdicts) report.text(sentence);
  report.heading("The published table");
  report.table(placement_paper_table(study));
  report.text(placement_paper_words(study));
  report.heading("Candidates");
  report.table(placement_candidates_table(study));
  report.text(fmt::format("Left and right differ by {:.1f} % of the most that a site tells, on average.",
                          100 * study.left_right));
  report.text(placement_legend(request));
  return report;
}

}  // namespace mien::lab
