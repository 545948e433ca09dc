#include "lab/commands/studies.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/command.h"
#include "app/json_output.h"
#include "app/performance.h"
#include "app/seed_option.h"
#include "lab/confidence_report.h"
#include "lab/eyewear/watched_wearer.h"
#include "lab/imu/faulty_person.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/core/error.h"
#include "mien/core/files.h"
#include "mien/core/median.h"
#include "mien/core/random.h"
#include "mien/eyewear/light_grid.h"
#include "mien/face/motion.h"
#include "mien/face/region_names.h"
#include "mien/model/confidence.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"
#include "mien/synthetic/confidence.h"
#include "mien/synthetic/imu/watched_person.h"
#include "mien/synthetic/watched.h"

namespace mien::lab {
namespace {

/// A model whose confidence is studied, and whom it watches; one class a modality.
class StudiedModel {
 public:
  virtual ~StudiedModel() = default;
  /// None: nobody has measured it.
  [[nodiscard]] virtual const std::optional<model::ConfidenceTable>& table() const = 0;
  virtual void use(model::ConfidenceTable table) = 0;
  /// The model with its table. Errors: the writer's.
  [[nodiscard]] virtual Result<void> write(const std::string& path) const = 0;
  [[nodiscard]] virtual std::string rig_name() const = 0;

  /// Virtual people with the rig's faults, `seconds` of performance each. Errors: the devices'; cancelled.
  [[nodiscard]] virtual Result<synthetic::WatchedGroup> virtual_people(int people, double seconds,
                                                                       std::uint64_t seed,
                                                                       const std::string& title) const = 0;
  /// People unlike those of training (synthetic::draw_shifted_person), likewise.
  [[nodiscard]] virtual Result<synthetic::WatchedGroup> shifted_people(int people, double seconds,
                                                                       std::uint64_t seed,
                                                                       const std::string& title) const = 0;
  /// A recorded performance on the built-in face. Errors: the devices'.
  [[nodiscard]] virtual Result<synthetic::WatchedGroup> recorded(std::string who, const face::Motion& motion,
                                                                 const Random& random) const = 0;
  /// Virtual people under every fault that the simulator knows; of every two one unlike those of training,
  /// where `shifted`. Errors: the devices'.
  [[nodiscard]] virtual Result<synthetic::FaultyGroup> faulty_people(int people, double seconds, bool shifted,
                                                                     std::uint64_t seed) const = 0;
};

std::string virtual_people_are(int people) {
  return fmt::format("{} virtual people", people);
}

/// `shifted`: every second one is unlike those of training.
std::string faulty_people_are(int people, bool shifted) {
  return shifted ? fmt::format("{} of both kinds", people) : virtual_people_are(people);
}
std::string shifted_people_are(int people) {
  return fmt::format("{} of other kinds", people);
}

class StudiedImuModel final : public StudiedModel {
 public:
  StudiedImuModel(model::ModelFile model, sensor::Rig rig) : model_(std::move(model)), rig_(std::move(rig)) {}
  [[nodiscard]] const std::optional<model::ConfidenceTable>& table() const override {
    return model_.confidence;
  }
  void use(model::ConfidenceTable table) override { model_.confidence = std::move(table); }
  [[nodiscard]] Result<void> write(const std::string& path) const override {
    return model::write_model(path, model_);
  }
  [[nodiscard]] std::string rig_name() const override { return rig_.name; }
  [[nodiscard]] Result<synthetic::WatchedGroup> virtual_people(int people, double seconds, std::uint64_t seed,
                                                               const std::string& title) const override {
    MIEN_TRY_ASSIGN(std::vector<synthetic::ImuPerson> all,
                    synthetic::watch_virtual(people, seconds, seed, rig_, app::terminal_progress(title), 0));
    return group(virtual_people_are(people), std::move(all));
  }
  [[nodiscard]] Result<synthetic::WatchedGroup> shifted_people(int people, double seconds, std::uint64_t seed,
                                                               const std::string& title) const override {
    MIEN_TRY_ASSIGN(std::vector<synthetic::ImuPerson> all,
                    synthetic::watch_shifted(people, seconds, seed, rig_, app::terminal_progress(title), 0));
    return group(shifted_people_are(people), std::move(all));
  }
  [[nodiscard]] Result<synthetic::WatchedGroup> recorded(std::string who, const face::Motion& motion,
                                                         const Random& random) const override {
    MIEN_TRY_ASSIGN(synthetic::ImuPerson person,
                    synthetic::watch_recorded(motion, builtin_face::make_builtin(), rig_, random));
    std::vector<synthetic::ImuPerson> one;
    one.push_back(std::move(person));
    return group(std::move(who), std::move(one));
  }
  [[nodiscard]] Result<synthetic::FaultyGroup> faulty_people(int people, double seconds, bool shifted,
                                                             std::uint64_t seed) const override {
    return lab::faulty_people(model_, rig_, faulty_people_are(people, shifted), people, seconds, shifted,
                              seed);
  }

 private:
  [[nodiscard]] synthetic::WatchedGroup group(std::string who,
                                              std::vector<synthetic::ImuPerson> people) const {
    return synthetic::watched_by(model_, rig_.face_sensor_names(), std::move(who), std::move(people));
  }

  model::ModelFile model_;
  sensor::Rig rig_;
};

class StudiedEyewearModel final : public StudiedModel {
 public:
  StudiedEyewearModel(eyewear::MarkerNetworkFile model, eyewear::MarkedFace marked, sensor::Rig rig)
      : model_(std::move(model)), marked_(std::move(marked)), rig_(std::move(rig)) {}
  [[nodiscard]] const std::optional<model::ConfidenceTable>& table() const override {
    return model_.confidence;
  }
  void use(model::ConfidenceTable table) override { model_.confidence = std::move(table); }
  [[nodiscard]] Result<void> write(const std::string& path) const override {
    return eyewear::write_marker_network(path, model_);
  }
  [[nodiscard]] std::string rig_name() const override { return rig_.name; }
  [[nodiscard]] Result<synthetic::WatchedGroup> virtual_people(int people, double seconds, std::uint64_t seed,
                                                               const std::string& title) const override {
    MIEN_TRY_ASSIGN(std::vector<LightPerson> all,
                    watch_wearers(people, seconds, seed, rig_, app::terminal_progress(title), 0));
    return group(virtual_people_are(people), std::move(all));
  }
  [[nodiscard]] Result<synthetic::WatchedGroup> shifted_people(int people, double seconds, std::uint64_t seed,
                                                               const std::string& title) const override {
    MIEN_TRY_ASSIGN(std::vector<LightPerson> all,
                    watch_shifted_wearers(people, seconds, seed, rig_, app::terminal_progress(title), 0));
    return group(shifted_people_are(people), std::move(all));
  }
  [[nodiscard]] Result<synthetic::WatchedGroup> recorded(std::string who, const face::Motion& motion,
                                                         const Random& random) const override {
    MIEN_TRY_ASSIGN(LightPerson person, watch_wearer(motion, builtin_face::make_builtin(), rig_, random));
    std::vector<LightPerson> one;
    one.push_back(std::move(person));
    return group(std::move(who), std::move(one));
  }
  [[nodiscard]] Result<synthetic::FaultyGroup> faulty_people(int people, double seconds, bool shifted,
                                                             std::uint64_t seed) const override {
    return faulty_wearers(model_, marked_, rig_, faulty_people_are(people, shifted), people, seconds, shifted,
                          seed);
  }

 private:
  [[nodiscard]] Result<synthetic::WatchedGroup> group(std::string who,
                                                      std::vector<LightPerson> people) const {
    return lab::watched_by(model_, marked_, eyewear::photo_sensor_names(rig_), std::move(who),
                           std::move(people));
  }

  eyewear::MarkerNetworkFile model_;
  eyewear::MarkedFace marked_;
  sensor::Rig rig_;
};

Result<std::unique_ptr<StudiedModel>> eyewear_model(eyewear::MarkerNetworkFile file, const std::string& rig) {
  MIEN_TRY_ASSIGN(const std::filesystem::path rig_file, app::path_or(rig, "rigs/eyewear.toml"));
  MIEN_TRY_ASSIGN(sensor::Rig read, sensor::read_rig(rig_file));
  MIEN_TRY_ASSIGN(const std::filesystem::path markers, find_resource("rigs/markers.toml"));
  MIEN_TRY_ASSIGN(const builtin_face::MarkerSet set, builtin_face::read_markers(markers));
  MIEN_TRY_ASSIGN(eyewear::MarkedFace marked, eyewear::MarkedFace::of(file, set));
  return std::make_unique<StudiedEyewearModel>(std::move(file), std::move(marked), std::move(read));
}

/// The model of a file, whichever modality it is of, before the sensors of a rig; of an empty `rig` those of
/// its modality's default one. Errors: the readers'.
Result<std::unique_ptr<StudiedModel>> read_studied_model(const std::string& model, const std::string& rig) {
  auto file = model::read_model(model);
  // Each format refuses the other's by its name; what is wrong with one of its own files is its to say.
  if (!file && file.error().code == ErrorCode::unsupported) {
    auto markers = eyewear::read_marker_network(model);
    if (markers) return eyewear_model(*std::move(markers), rig);
    return std::unexpected(markers.error().code == ErrorCode::unsupported ? file.error() : markers.error());
  }
  if (!file) return std::unexpected(file.error());
  MIEN_TRY_ASSIGN(const std::filesystem::path rig_file, app::path_or(rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(sensor::Rig read, sensor::read_rig(rig_file));
  return std::make_unique<StudiedImuModel>(*std::move(file), std::move(read));
}

/// People on whom tables are measured, from this seed on: no training draws from it, and no study reports it.
constexpr std::uint64_t kMeasuredOn = 2001;

struct StudyConfidenceOptions {
  std::string model;
  std::string rig;
  std::vector<std::string> motions;
  std::string write;
  std::string out;
  int performers = 24;
  int faulty = 12;
  bool keep_table = false;
  double seconds = 60;
  std::uint64_t seed = 1;
  bool json = false;
};

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

app::Json to_json(const synthetic::ConfidenceRow& row) {
  return {{"who", row.who},
          {"fault", row.fault},
          {"lost", row.lost},
          {"people", row.people},
          {"frames", row.frames},
          {"measured", row.measured},
          {"gaze_measured", row.gaze_measured},
          {"correlations", row.followed.pairs},
          {"correlations_kept", row.followed.share()},
          {"all", to_json(row.all)},
          {"ece_single", range_of(row.single)},
          {"moving", to_json(row.moving)},
          {"before",
           {{"correlations", row.followed_before.pairs},
            {"correlations_kept", row.followed_before.share()},
            {"all", to_json(row.all_before)}}},
          {"kept", synthetic::kept(row)},
          {"regions", to_json(row.regions)},
          {"regions_ece_single", range_of(row.regions_single)},
          {"regions_kept", synthetic::regions_kept(row)}};
}

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
                                                          const StudiedModel& model, bool shifted,
                                                          std::uint64_t seed) {
  std::vector<synthetic::FaultyGroup> out;
  if (options.faulty == 0) return out;
  MIEN_TRY_ASSIGN(out.emplace_back(), model.faulty_people(options.faulty, options.seconds, shifted, seed));
  return out;
}

app::Json shapes_json(const model::ConfidenceTable& table) {
  app::Json out = app::Json::object();
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    out[std::string(face::kShapeNames[k])] = table.explained_by(k, table.coverage_bins() - 1);
  return out;
}

/// Measures the model's table anew, but where it is to be kept, and its regions' maps, and writes the model
/// with them. Half of the people are unlike those of
/// training: of a tracker's error on people like those alone, strangers are promised too much.
Result<void> write_table(const StudyConfidenceOptions& options, StudiedModel& model) {
  MIEN_TRY_ASSIGN(synthetic::WatchedGroup people, model.virtual_people(options.performers, options.seconds,
                                                                       kMeasuredOn, "people to measure on"));
  MIEN_TRY_ASSIGN(synthetic::WatchedGroup others, model.shifted_people(options.performers, options.seconds,
                                                                       kMeasuredOn, "people of other kinds"));
  std::ranges::move(others.people, std::back_inserter(people.people));
  model::ConfidenceTable table;
  if (options.keep_table) {
    if (!model.table())
      return fail(ErrorCode::not_found, "the model has no confidence table to keep", options.model);
    table = *model.table();
  } else {
    MIEN_TRY_ASSIGN(
        table, synthetic::measure_confidence(people, kMeasuredOn, app::terminal_progress("confidence"), 0));
  }
  MIEN_TRY_ASSIGN(const std::vector<synthetic::FaultyGroup> faulty,
                  faulty_groups(options, model, true, kMeasuredOn));
  MIEN_TRY_ASSIGN(table.regions, synthetic::fit_regions(table, people, faulty, kMeasuredOn,
                                                        app::terminal_progress("regions' confidence"), 0));
  model.use(std::move(table));
  return model.write(options.write);
}

Result<std::vector<synthetic::WatchedGroup>> watch(const StudyConfidenceOptions& options,
                                                   const StudiedModel& model) {
  std::vector<synthetic::WatchedGroup> groups;
  MIEN_TRY_ASSIGN(groups.emplace_back(), model.virtual_people(options.performers, options.seconds,
                                                              options.seed + kMeasuredOn + 1, "people"));
  MIEN_TRY_ASSIGN(groups.emplace_back(), model.shifted_people(options.performers, options.seconds,
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
  if (!options.out.empty()) MIEN_TRY(app::check_output(options.out, {".html"}));
  if (!options.write.empty()) MIEN_TRY(app::check_output(options.write, {".safetensors"}));
  MIEN_TRY_ASSIGN(options.model, app::path_or(options.model, "models/live.safetensors"));
  MIEN_TRY_ASSIGN(const std::unique_ptr<StudiedModel> model, read_studied_model(options.model, options.rig));
  if (!options.write.empty()) MIEN_TRY(write_table(options, *model));
  if (!model->table())
    return fail(ErrorCode::not_found, "the model has no confidence table", options.model,
                "measure it with --write");
  const model::ConfidenceTable& table = *model->table();
  MIEN_TRY_ASSIGN(const std::vector<synthetic::WatchedGroup> groups, watch(options, *model));
  MIEN_TRY_ASSIGN(
      const std::vector<synthetic::ConfidenceRow> rows,
      synthetic::study_confidence(table, groups, options.seed, app::terminal_progress("confidence"), 0));
  MIEN_TRY_ASSIGN(const std::vector<synthetic::FaultyGroup> faulty,
                  faulty_groups(options, *model, true, options.seed + kMeasuredOn + 1));
  MIEN_TRY_ASSIGN(const std::vector<synthetic::ConfidenceRow> faults,
                  synthetic::study_faults(table, faulty, app::terminal_progress("faults"), 0));
  app::clear_progress();
  const std::string subtitle = fmt::format(
      "model {}, seed {}", std::filesystem::path(options.model).filename().string(), options.seed);
  const measure::Report report = confidence_report(rows, faults, table, subtitle);
  if (!options.out.empty()) MIEN_TRY(report.write(options.out));
  if (options.json) {
    app::Json all = app::Json::array();
    for (const synthetic::ConfidenceRow& row : rows) all.push_back(to_json(row));
    app::Json under = app::Json::array();
    for (const synthetic::ConfidenceRow& row : faults) under.push_back(to_json(row));
    app::print_json({{"model", options.model},
                     {"rig", model->rig_name()},
                     {"seed", options.seed},
                     {"measured_from", table.measured_from},
                     {"explained", shapes_json(table)},
                     {"regions", maps_json(table)},
                     {"rows", all},
                     {"faults", under}});
    return {};
  }
  fmt::print("How true the confidence is: {}\n\n{}", subtitle, measure::plain_text(confidence_table(rows)));
  if (!faults.empty()) fmt::print("\n{}", measure::plain_text(confidence_table(faults)));
  if (table.regions) fmt::print("\n{}", measure::plain_text(regions_table(rows, faults)));
  if (!options.out.empty()) fmt::print("report: {}\n", options.out);
  if (!options.write.empty()) fmt::print("model with its table: {}\n", options.write);
  return {};
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
  command.add_option("--out", options->out,
                     "Write a self-contained HTML page with the reliability diagram and the tables");
  app::add_json_flag(command, options->json);
}

}  // namespace mien::lab
