#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <string_view>
#include <utility>

#include "lab/imu/placement/placement_study.h"
#include "mien/core/units.h"

namespace mien::lab {
namespace {

std::string told_percent(double share) {
  return fmt::format("{:.1f} %", 100 * share);
}

std::string interval_text(const measure::SeedFigures& figures, int decimals) {
  if (figures.empty()) return "-";
  const measure::Interval value = measure::mean_interval(figures);
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
  std::vector<PlacementRow> rows;
  std::vector<std::size_t> strong;
  for (const PlacementRow& row : study.sets) {
    if (row.sensors.size() == study.chosen.size()) strong.push_back(rows.size());
    rows.push_back(row);
    for (const PlacementRow* paper : {&study.paper_five, &study.paper})
      if (row.sensors.size() == paper->sensors.size()) rows.push_back(*paper);
  }
  measure::Table table = table_of(
      "Sets by the linear bound; of the groups of shapes what is left of their prior standard deviation (1: "
      "nothing is known of them)",
      rows, placement_columns());
  table.strong_rows = strong;
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

const Columns<PlacementRow>& placement_columns() {
  using Row = PlacementRow;
  static const Columns<Row> columns = [] {
    Columns<Row> out = {
        {"", "", "{}", &Row::title},
        {"sensors", "", "", &Row::sensors},
        {"rms_vertex_mm", "RMS, mm", "{:.3f}", &Row::rms_vertex_mm},
        {"pve_mm", "PVE, mm", "{:.3f}", [](const Row& row) { return row.bound.pve_mm.mean; }},
        {"pve_face_mm", "", "", [](const Row& row) { return or_null(optional_mean(row.bound.pve_face_mm)); }},
        {"lmk_mm", "", "", [](const Row& row) { return or_null(optional_mean(row.bound.lmk_mm)); }},
        {"mse", "MSE", "{:.5f}", [](const Row& row) { return row.bound.mse; }},
        {"groups_left", "", "",
         [](const Row& row) {
           Json groups;
           for (std::size_t g = 0; g < kShapeGroups.size(); ++g)
             groups[std::string(kShapeGroups[g])] = row.group_ratios[g];
           return groups;
         }},
        {"left", "", "",
         [](const Row& row) { return by_shape([&](std::size_t k) { return row.bound.left[k]; }); }}};
    for (std::size_t g = 0; g < kShapeGroups.size(); ++g)
      out.push_back(
          {"", std::string(kShapeGroups[g]), "{:.2f}", [g](const Row& row) { return row.group_ratios[g]; }});
    return out;
  }();
  return columns;
}

const Columns<TrainedPlacement>& trained_columns() {
  using Row = TrainedPlacement;
  static const Columns<Row> columns = {
      {"", "", "{}", &Row::title},
      {"name", "", "", &Row::name},
      {"sensors", "sensors", "{}", &Row::sensors},
      {"device_pve_mm", "", "", [](const Row& row) { return row.device.pve_mm; }},
      {"device_mse", "", "", [](const Row& row) { return row.device.mse; }},
      {"lab_pve_mm", "", "", [](const Row& row) { return row.lab.pve_mm; }},
      {"lab_mse", "", "", [](const Row& row) { return row.lab.mse; }},
      {"", "PVE device, mm", "{}", [](const Row& row) { return interval_text(row.device.pve_mm, 3); }},
      {"", "MSE device", "{}", [](const Row& row) { return interval_text(row.device.mse, 4); }},
      {"", "PVE lab, mm", "{}", [](const Row& row) { return interval_text(row.lab.pve_mm, 3); }},
      {"", "MSE lab", "{}", [](const Row& row) { return interval_text(row.lab.mse, 4); }}};
  return columns;
}

Columns<std::size_t> candidate_columns(const PlacementStudy& study) {
  const auto of = [&study](std::size_t i) -> const SensorCandidate& { return study.candidates[i]; };
  return {{"name", "candidate", "{}", [of](std::size_t i) { return of(i).name; }},
          {"area", "area", "{}", [of](std::size_t i) { return of(i).area; }},
          {"side", "", "", [of](std::size_t i) { return std::string(1, of(i).side); }},
          {"position_m", "", "",
           [of](std::size_t i) {
             const Vec3& p = of(i).position_m;
             return Json{p.x(), p.y(), p.z()};
           }},
          {"", "x y z", "{}",
           [of](std::size_t i) {
             const Vec3 p_mm = kMmPerM * of(i).position_m;
             return fmt::format("{:.0f} {:.0f} {:.0f}", p_mm.x(), p_mm.y(), p_mm.z());
           }},
          {"alone", "alone", "{:.1f} %", [&study](std::size_t i) { return study.alone[i]; }, 100},
          {"tells", "tells", "{}", [&study](std::size_t i) { return top_shapes(study.alone_posterior[i]); }}};
}

measure::Table placement_trained_table(const PlacementStudy& study, const PlacementTrainingRequest& request) {
  return table_of(
      fmt::format(
          "Networks with the same budget (trainings a set: {}; steps of each: {}; virtual performers: "
          "{}), on {} people whom nobody trained on: mean, 95 % interval",
          request.seeds, request.steps, request.data.performers, request.test_people),
      study.trained, trained_columns());
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
  measure::Table chosen_sites = table_of(
      "The chosen sensors: place on the built-in head (frame H, mm), share of the objective that each tells "
      "alone, and which shapes (share of their variance)",
      study.chosen, candidate_columns(study));
  chosen_sites.columns.insert(chosen_sites.columns.begin(), "");
  for (std::size_t i = 0; i < chosen_sites.rows.size(); ++i)
    chosen_sites.rows[i].insert(chosen_sites.rows[i].begin(), std::to_string(i + 1));
  report.table(chosen_sites);
  const std::vector<std::string> verdicts = placement_verdicts(study, request);
  if (!study.trained.empty() || !verdicts.empty()) report.heading("By short trainings");
  if (!study.trained.empty()) report.table(placement_trained_table(study, request.training));
  for (const std::string& sentence : verdicts) report.text(sentence);
  report.heading("The published table");
  report.table(placement_paper_table(study));
  report.text(placement_paper_words(study));
  report.heading("Candidates");
  std::vector<std::size_t> listed(study.grid_begin);
  std::iota(listed.begin(), listed.end(), std::size_t{0});
  report.table(table_of("Candidates, each alone: share of the objective that it tells, and which shapes",
                        listed, candidate_columns(study)));
  report.text(fmt::format("Left and right differ by {:.1f} % of the most that a site tells, on average.",
                          100 * study.left_right));
  report.text(placement_legend(request));
  return report;
}

}  // namespace mien::lab
