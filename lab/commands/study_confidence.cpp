#include "lab/commands/studies.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/command.h"
#include "app/json_output.h"
#include "app/performance.h"
#include "app/seed_option.h"
#include "lab/commands/output.h"
#include "lab/eyewear/watched_wearer.h"
#include "lab/imu/faulty_person.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/core/error.h"
#include "mien/core/files.h"
#include "mien/core/median.h"
#include "mien/core/random.h"
#include "mien/eyewear/light_grid.h"
#include "mien/face/motion.h"
#include "mien/face/shape_region.h"
#include "mien/measure/report.h"
#include "mien/model/confidence.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"
#include "mien/synthetic/confidence.h"
#include "mien/synthetic/imu/watched_person.h"
#include "mien/synthetic/watched.h"
#include "mien/tracker/shape_confidence.h"

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

app::Json to_json(const solve::Reliability& reliability) {
  app::Json bins = app::Json::array();
  for (const solve::Reliability::Bin& bin : reliability.bins())
    if (bin.frames > 0)
      bins.push_back({{"frames", bin.frames},
                      {"confidence", bin.confidence / bin.frames},
                      {"within", bin.within / bin.frames}});
  return {{"expected_calibration_error", reliability.expected_error()}, {"bins", bins}};
}

app::Json range_of(const std::vector<double>& ascending) {
  return {{"median", upper_median(ascending)}, {"least", ascending.front()}, {"most", ascending.back()}};
}

app::Json to_json(const solve::RegionTally& regions) {
  app::Json out = to_json(regions.all);
  out["area_under_curve"] = regions.roc.area();
  app::Json& each = out["each"] = app::Json::object();
  for (std::size_t r = 0; r < face::kShapeRegionCount; ++r)
    each[std::string(face::kShapeRegionNames[r])] = {
        {"expected_calibration_error", regions.each[r].expected_error()},
        {"area_under_curve", regions.roc_each[r].area()}};
  return out;
}

/// "0.041 (0.020 to 0.066)": the median, the least and the most.
std::string range_text(const std::vector<double>& ascending) {
  return fmt::format("{:.3f} ({:.3f} to {:.3f})", upper_median(ascending), ascending.front(),
                     ascending.back());
}

/// What the table of all shapes shows, and the figures of regions as JSON has them.
const Columns<synthetic::ConfidenceRow>& confidence_columns() {
  using Row = synthetic::ConfidenceRow;
  static const Columns<Row> columns = {
      {"", "", "{}", name_of},
      {"who", "", "", &Row::who},
      {"fault", "", "", &Row::fault},
      {"lost", "", "", &Row::lost},
      {"people", "people", "{}", &Row::people},
      {"frames", "", "", &Row::frames},
      {"measured", "called measured, %", "{:.1f}", &Row::measured, 100},
      {"gaze_measured", "", "", &Row::gaze_measured},
      {"correlations", "", "", [](const Row& row) { return row.followed.pairs; }},
      {"correlations_kept", "r of 0.5 or more, %", "{:.1f}",
       [](const Row& row) { return row.followed.share(); }, 100},
      {"", "before, %", "{:.1f}", [](const Row& row) { return row.followed_before.share(); }, 100},
      {"all", "", "", [](const Row& row) { return to_json(row.all); }},
      {"", "ECE", "{:.3f}", [](const Row& row) { return row.all.expected_error(); }},
      {"ece_single", "", "", [](const Row& row) { return range_of(row.single); }},
      {"", "ECE of each one", "{}", [](const Row& row) { return range_text(row.single); }},
      {"moving", "", "", [](const Row& row) { return to_json(row.moving); }},
      {"", "ECE moving", "{:.3f}", [](const Row& row) { return row.moving.expected_error(); }},
      {"before", "", "",
       [](const Row& row) {
         return app::Json{{"correlations", row.followed_before.pairs},
                          {"correlations_kept", row.followed_before.share()},
                          {"all", to_json(row.all_before)}};
       }},
      {"", "ECE before", "{:.3f}", [](const Row& row) { return row.all_before.expected_error(); }},
      {"kept", "kept", "{}", [](const Row& row) { return synthetic::kept(row); }},
      {"regions", "", "", [](const Row& row) { return to_json(row.regions); }},
      {"regions_ece_single", "", "", [](const Row& row) { return range_of(row.regions_single); }},
      {"regions_kept", "", "", [](const Row& row) { return synthetic::regions_kept(row); }}};
  return columns;
}

measure::Table confidence_table(const std::vector<synthetic::ConfidenceRow>& rows) {
  return table_of("Calibration error (ECE) and correlation with the truth, beside what was said before", rows,
                  confidence_columns());
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
               range_text(row.regions_single),
               fmt::format("{:.3f}", row.regions.roc.area())};
      for (std::size_t r = 0; r < face::kShapeRegionCount; ++r) {
        cells.push_back(fmt::format("{:.3f}", row.regions.each[r].expected_error()));
        cells.push_back(fmt::format("{:.3f}", row.regions.roc_each[r].area()));
      }
      cells.emplace_back(synthetic::regions_kept(row) ? "yes" : "no");
    }
  return out;
}

/// The reliability diagram, the rows (study_confidence), the faults' (study_faults), the same of regions
/// where the table has maps, and what the sensors explain of each shape. `subtitle` says which model
/// answered.
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

/// A model whose confidence is studied, and whom it watches.
struct StudiedModel {
  using Group = Result<synthetic::WatchedGroup>;

  sensor::Rig rig;
  /// The model's own, as long as this object lives; none: nobody has measured it.
  std::optional<model::ConfidenceTable>* table = nullptr;
  /// The model with its table. Errors: the writer's.
  std::function<Result<void>(const std::string& path)> write;
  /// Virtual people with the rig's faults, `seconds` of performance each; `shifted`: people unlike those of
  /// training (synthetic::draw_shifted_person). Errors: the devices'; cancelled.
  std::function<Group(bool shifted, int people, double seconds, std::uint64_t seed, const std::string& title)>
      people;
  /// A recorded performance on the built-in face. Errors: the devices'.
  std::function<Group(std::string who, const face::Motion& motion, const Random& random)> recorded;
  /// Virtual people under every fault that the simulator knows; of every two one unlike those of training.
  /// Errors: the devices'.
  std::function<Result<synthetic::FaultyGroup>(int people, double seconds, std::uint64_t seed)> faulty;
};

std::string people_are(bool shifted, int people) {
  return fmt::format("{} {}", people, shifted ? "of other kinds" : "virtual people");
}
std::string faulty_people_are(int people) {
  return fmt::format("{} of both kinds", people);
}

StudiedModel imu_model(model::ModelFile model, const sensor::Rig& rig) {
  const auto file = std::make_shared<model::ModelFile>(std::move(model));
  const auto group = [=](std::string who, std::vector<synthetic::ImuPerson> all) -> StudiedModel::Group {
    return synthetic::watched_by(*file, rig.face_sensor_names(), std::move(who), std::move(all));
  };
  return {.rig = rig,
          .table = &file->confidence,
          .write = [=](const std::string& path) { return model::write_model(path, *file); },
          .people = [=](bool shifted, int people, double seconds, std::uint64_t seed,
                        const std::string& title) -> StudiedModel::Group {
            const auto watch = shifted ? synthetic::watch_shifted : synthetic::watch_virtual;
            MIEN_TRY_ASSIGN(auto all, watch(people, seconds, seed, rig, app::terminal_progress(title), 0));
            return group(people_are(shifted, people), std::move(all));
          },
          .recorded = [=](std::string who, const face::Motion& motion,
                          const Random& random) -> StudiedModel::Group {
            std::vector<synthetic::ImuPerson> one(1);
            MIEN_TRY_ASSIGN(one[0],
                            synthetic::watch_recorded(motion, builtin_face::make_builtin(), rig, random));
            return group(std::move(who), std::move(one));
          },
          .faulty =
              [=](int people, double seconds, std::uint64_t seed) {
                return faulty_people(*file, rig, faulty_people_are(people), people, seconds, true, seed);
              }};
}

StudiedModel eyewear_model(eyewear::MarkerNetworkFile model, const eyewear::MarkedFace& marked,
                           const sensor::Rig& rig) {
  const auto file = std::make_shared<eyewear::MarkerNetworkFile>(std::move(model));
  const auto group = [=](std::string who, std::vector<LightPerson> all) -> StudiedModel::Group {
    return watched_by(*file, marked, eyewear::photo_sensor_names(rig), std::move(who), std::move(all));
  };
  return {.rig = rig,
          .table = &file->confidence,
          .write = [=](const std::string& path) { return eyewear::write_marker_network(path, *file); },
          .people = [=](bool shifted, int people, double seconds, std::uint64_t seed,
                        const std::string& title) -> StudiedModel::Group {
            const auto watch = shifted ? watch_shifted_wearers : watch_wearers;
            MIEN_TRY_ASSIGN(auto all, watch(people, seconds, seed, rig, app::terminal_progress(title), 0));
            return group(people_are(shifted, people), std::move(all));
          },
          .recorded = [=](std::string who, const face::Motion& motion,
                          const Random& random) -> StudiedModel::Group {
            std::vector<LightPerson> one(1);
            MIEN_TRY_ASSIGN(one[0], watch_wearer(motion, builtin_face::make_builtin(), rig, random));
            return group(std::move(who), std::move(one));
          },
          .faulty =
              [=](int people, double seconds, std::uint64_t seed) {
                return faulty_wearers(*file, marked, rig, faulty_people_are(people), people, seconds, true,
                                      seed);
              }};
}

/// Reads a model of facial IMUs or of smart eyewear, and its rig; `rig` empty: the default one of its kind.
/// Errors: those of the files.
Result<StudiedModel> read_studied_model(const std::string& model, const std::string& rig) {
  auto file = model::read_model(model);
  // Each format refuses the other's by its name; what is wrong with one of its own files is its to say.
  if (!file && file.error().code == ErrorCode::unsupported) {
    auto network = eyewear::read_marker_network(model);
    if (!network && network.error().code == ErrorCode::unsupported) return std::unexpected(file.error());
    if (!network) return std::unexpected(network.error());
    MIEN_TRY_ASSIGN(const std::filesystem::path rig_file, app::path_or(rig, "rigs/eyewear.toml"));
    MIEN_TRY_ASSIGN(const sensor::Rig read, sensor::read_rig(rig_file));
    MIEN_TRY_ASSIGN(const std::filesystem::path markers, find_resource("rigs/markers.toml"));
    MIEN_TRY_ASSIGN(const builtin_face::MarkerSet set, builtin_face::read_markers(markers));
    MIEN_TRY_ASSIGN(const eyewear::MarkedFace marked, eyewear::MarkedFace::of(*network, set));
    return eyewear_model(*std::move(network), marked, read);
  }
  if (!file) return std::unexpected(file.error());
  MIEN_TRY_ASSIGN(const std::filesystem::path rig_file, app::path_or(rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(const sensor::Rig read, sensor::read_rig(rig_file));
  return imu_model(*std::move(file), read);
}

/// People on whom tables are measured, from this seed on: no training draws from it, and no study reports it.
constexpr std::uint64_t kMeasuredOn = 2001;

struct StudyConfidenceOptions {
  std::string model;
  std::string rig;
  std::vector<std::string> motions;
  std::string write;
  int performers = 24;
  int faulty = 12;
  bool keep_table = false;
  double seconds = 60;
  std::uint64_t seed = 1;
  Output to;
};

/// Each region's offset and slope; null where the table has no maps.
app::Json maps_json(const model::ConfidenceTable& table) {
  if (!table.regions) return nullptr;
  app::Json out = app::Json::object();
  for (std::size_t r = 0; r < face::kShapeRegionCount; ++r)
    out[std::string(face::kShapeRegionNames[r])] = {(*table.regions)[r].offset, (*table.regions)[r].slope};
  return out;
}

/// None where nobody is to be under faults.
Result<std::vector<synthetic::FaultyGroup>> faulty_groups(const StudyConfidenceOptions& options,
                                                          const StudiedModel& model, std::uint64_t seed) {
  std::vector<synthetic::FaultyGroup> out;
  if (options.faulty == 0) return out;
  MIEN_TRY_ASSIGN(out.emplace_back(), model.faulty(options.faulty, options.seconds, seed));
  return out;
}

/// Measures the model's table anew, but where it is to be kept, and its regions' maps, and writes the model
/// with them. Half of the people are unlike those of
/// training: of a tracker's error on people like those alone, strangers are promised too much.
Result<void> write_table(const StudyConfidenceOptions& options, const StudiedModel& model) {
  MIEN_TRY_ASSIGN(synthetic::WatchedGroup people, model.people(false, options.performers, options.seconds,
                                                               kMeasuredOn, "people to measure on"));
  MIEN_TRY_ASSIGN(synthetic::WatchedGroup others, model.people(true, options.performers, options.seconds,
                                                               kMeasuredOn, "people of other kinds"));
  std::ranges::move(others.people, std::back_inserter(people.people));
  model::ConfidenceTable table;
  if (options.keep_table) {
    if (!*model.table)
      return fail(ErrorCode::not_found, "the model has no confidence table to keep", options.model);
    table = **model.table;
  } else {
    MIEN_TRY_ASSIGN(
        table, synthetic::measure_confidence(people, kMeasuredOn, app::terminal_progress("confidence"), 0));
  }
  MIEN_TRY_ASSIGN(const std::vector<synthetic::FaultyGroup> faulty,
                  faulty_groups(options, model, kMeasuredOn));
  MIEN_TRY_ASSIGN(table.regions, synthetic::fit_regions(table, people, faulty, kMeasuredOn,
                                                        app::terminal_progress("regions' confidence"), 0));
  *model.table = std::move(table);
  return model.write(options.write);
}

Result<std::vector<synthetic::WatchedGroup>> watch(const StudyConfidenceOptions& options,
                                                   const StudiedModel& model) {
  std::vector<synthetic::WatchedGroup> groups;
  MIEN_TRY_ASSIGN(groups.emplace_back(), model.people(false, options.performers, options.seconds,
                                                      options.seed + kMeasuredOn + 1, "people"));
  MIEN_TRY_ASSIGN(groups.emplace_back(), model.people(true, options.performers, options.seconds,
                                                      options.seed + kMeasuredOn + 1, "others"));
  // The table and the maps are made on both kinds, half and half: so they are judged on both together, too.
  synthetic::WatchedGroup both{fmt::format("{} of both kinds", 2 * options.performers), groups[0].people};
  both.people.insert(both.people.end(), groups[1].people.begin(), groups[1].people.end());
  groups.push_back(std::move(both));
  for (std::size_t m = 0; m < options.motions.size(); ++m) {
    MIEN_TRY_ASSIGN(const app::Performance performance, app::load_performance(options.motions[m]));
    MIEN_TRY_ASSIGN(groups.emplace_back(),
                    model.recorded(std::filesystem::path(options.motions[m]).stem().string(),
                                   performance.motion, Random(options.seed).fork("recorded", m)));
  }
  return groups;
}

Result<void> run_study_confidence(StudyConfidenceOptions options) {
  MIEN_TRY(check_page(options.to));
  if (!options.write.empty()) MIEN_TRY(app::check_output(options.write, {".safetensors"}));
  MIEN_TRY_ASSIGN(options.model, app::path_or(options.model, "models/live.safetensors"));
  MIEN_TRY_ASSIGN(const StudiedModel model, read_studied_model(options.model, options.rig));
  if (!options.write.empty()) MIEN_TRY(write_table(options, model));
  if (!*model.table)
    return fail(ErrorCode::not_found, "the model has no confidence table", options.model,
                "measure it with --write");
  const model::ConfidenceTable& table = **model.table;
  MIEN_TRY_ASSIGN(const std::vector<synthetic::WatchedGroup> groups, watch(options, model));
  MIEN_TRY_ASSIGN(
      const std::vector<synthetic::ConfidenceRow> rows,
      synthetic::study_confidence(table, groups, options.seed, app::terminal_progress("confidence"), 0));
  MIEN_TRY_ASSIGN(const std::vector<synthetic::FaultyGroup> faulty,
                  faulty_groups(options, model, options.seed + kMeasuredOn + 1));
  MIEN_TRY_ASSIGN(const std::vector<synthetic::ConfidenceRow> faults,
                  synthetic::study_faults(table, faulty, app::terminal_progress("faults"), 0));
  const std::string subtitle = fmt::format(
      "model {}, seed {}", std::filesystem::path(options.model).filename().string(), options.seed);
  const app::Json out = {{"model", options.model},
                         {"rig", model.rig.name},
                         {"seed", options.seed},
                         {"measured_from", table.measured_from},
                         {"explained", by_shape([&](std::size_t k) {
                            return table.explained_by(k, table.coverage_bins() - 1);
                          })},
                         {"regions", maps_json(table)},
                         {"rows", json_of(rows, confidence_columns())},
                         {"faults", json_of(faults, confidence_columns())}};
  return put_out(options.to, confidence_report(rows, faults, table, subtitle), out,
                 options.write.empty() ? "" : fmt::format("model with its table: {}\n", options.write));
}

}  // namespace

void add_study_confidence(app::Commands& commands, app::Command study) {
  auto options = std::make_shared<StudyConfidenceOptions>();
  const app::Command command = commands.add_under(
      study, "confidence", "How true a model's provenance and confidence are, on people it never saw",
      "mien study confidence --out confidence.html", [options] { return run_study_confidence(*options); });
  command.add_option(
      "--model", options->model,
      "Model of facial IMUs, live or not, or of smart eyewear (default: models/live.safetensors)");
  command.add_option("--rig", options->rig,
                     "Rig file (default: rigs/default.toml, of a model of smart eyewear rigs/eyewear.toml)");
  command
      .add_option("--performers", options->performers,
                  "Virtual people of each kind: like those of training, and unlike them")
      .in_range(1, 10000)
      .show_default();
  command
      .add_option("--faulty", options->faulty,
                  "People under every fault, every second one unlike those of training; 0: none")
      .in_range(0, 10000)
      .show_default();
  command.add_option("--seconds", options->seconds, "Length of each one's performance")
      .number_between(1.0, 3600.0)
      .show_default();
  command.add_option("--motion", options->motions,
                     "These as well, on the built-in face: Live Link Face CSVs, or takes with truth");
  app::add_seed_option(command, options->seed, "Of the people, their devices and the sensors that are lost");
  command.add_option("--write", options->write,
                     "Measure the model's table anew first, on people of their own, and write the model so");
  command
      .add_flag("--keep-table", options->keep_table,
                "With --write: fit the confidence of regions alone, to the table that the model has")
      .needs(command.option("--write"));
  command.add_option("--out", options->to.out,
                     "Write a self-contained HTML page with the reliability diagram and the tables");
  app::add_json_flag(command, options->to.json);
}

}  // namespace mien::lab
