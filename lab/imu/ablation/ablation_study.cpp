#include "lab/imu/ablation/ablation_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <numeric>
#include <string_view>
#include <utility>

#include "lab/imu/sensor_bound.h"
#include "lab/imu/short_training.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/core/files.h"
#include "mien/core/nearest_word.h"
#include "mien/core/units.h"
#include "mien/dataset/training_takes.h"
#include "mien/sensor/rig_part.h"
#include "mien/solve/part_of_work.h"
#include "mien/synthetic/imu/dataset_part.h"
#include "mien/synthetic/imu/watched_person.h"

namespace mien::lab {
namespace {

/// A region of muscles, as the paper divides the face, and the sites that lie there.
struct MuscleRegion {
  const char* name;
  const char* title;
  std::array<const char*, 2> sites;
};
constexpr std::array kMuscleRegions = {
    MuscleRegion{"no_frontalis", "without the forehead (frontalis)", {"frontalis", "frontalis"}},
    MuscleRegion{"no_orbicularis", "without the eyes (orbicularis oculi)", {"orbicularis", "orbicularis"}},
    MuscleRegion{
        "no_zygomaticus", "without the cheeks (zygomaticus)", {"zygomaticus_upper", "zygomaticus_lower"}},
    MuscleRegion{
        "no_buccinator", "without mouth and chin (buccinator, mentalis)", {"buccinator", "mentalis"}}};

using IsKept = std::function<bool(const sensor::Mount&)>;

std::vector<std::string> kept(const sensor::Rig& rig, const IsKept& is_kept) {
  std::vector<std::string> names;
  for (const std::uint16_t s : rig.face_sensors())
    if (is_kept(rig.sensors[s])) names.push_back(rig.sensors[s].name);
  return names;
}

using FiveNames = std::array<std::string_view, 5>;

class RowTable {
 public:
  explicit RowTable(const sensor::Rig& rig) : rig_(rig), all_(rig.face_sensor_names()) {}

  /// A row of five sensors; none where the rig lacks one of them.
  void add_five(std::string name, std::string title, const FiveNames& five) {
    const auto has = [&](std::string_view sensor) { return std::ranges::find(all_, sensor) != all_.end(); };
    if (!std::ranges::all_of(five, has)) return;
    add_sensors(std::move(name), std::move(title), [&](const sensor::Mount& mount) {
      return std::ranges::find(five, mount.name) != five.end();
    });
  }

  /// A row of fewer sensors; none where that leaves all of them, or none.
  void add_sensors(std::string name, std::string title, const IsKept& is_kept) {
    std::vector<std::string> names = kept(rig_, is_kept);
    if (names.empty() || names.size() == all_.size()) return;
    title = fmt::format("{} ({})", title, names.size());
    rows_.push_back({.name = std::move(name),
                     .group = "sensors",
                     .title = std::move(title),
                     .sensors = std::move(names)});
  }
  void add(AblationRow row) {
    row.sensors = all_;
    rows_.push_back(std::move(row));
  }
  [[nodiscard]] std::vector<AblationRow> rows() && { return std::move(rows_); }
  [[nodiscard]] std::size_t sensors() const { return all_.size(); }

 private:
  const sensor::Rig& rig_;
  std::vector<std::string> all_;
  std::vector<AblationRow> rows_;
};

/// Share of the whole work, for progress.
constexpr double kTrainedShare = 0.9;
/// Apart from the seeds of those who are trained on.
constexpr std::uint64_t kTestSeed = 5'000, kStrangerSeed = 6'000;
/// The bound beside each row: what real weights have about, and consumer fusion's noise.
constexpr double kBoundPrior = 0.10, kBoundNoiseRad = 2 * kRadPerDeg;

/// Of those who are trained on so many are looked at; of a row of one in kFewestShare, too.
constexpr std::size_t kSeenPeople = 8, kFewestShare = 10;

/// Whom the networks of one set of sensors are tried on.
struct Tested {
  std::vector<std::string> sensors;  ///< Names of the features' entries.
  std::array<std::vector<synthetic::ImuPerson>, kTestSetCount> sets;
};

/// `seen`: how many of those who are trained on are looked at.
Result<Tested> make_tests(const AblationRequest& request, const sensor::Rig& rig, std::size_t seen_people,
                          const Progress& progress) {
  Tested out;
  const auto set = [&](TestSet which) -> std::vector<synthetic::ImuPerson>& {
    return out.sets[static_cast<std::size_t>(which)];
  };
  synthetic::DataRecipe like = request.data;
  like.seed = recipe_seed(request.seed + kTestSeed);
  like.performers = static_cast<int>(request.test_people);
  like.validation_performers = 0;
  like.seconds = like.device_seconds = request.test_seconds;
  like.device_share = 1;
  like.device_long_share = 0;
  MIEN_TRY_ASSIGN(const dataset::TrainingData others,
                  synthetic::make_dataset(like, "builtin", rig, solve::part_of_work(progress, 0, 0.5)));
  set(TestSet::device) = synthetic::watched(others.train);
  set(TestSet::lab) = watched_in_lab(others.train, like.seed);
  MIEN_TRY_ASSIGN(set(TestSet::strangers),
                  synthetic::watch_shifted(static_cast<int>(request.test_people), request.test_seconds,
                                           request.seed + kStrangerSeed, rig,
                                           solve::part_of_work(progress, 0.5, 0.9), 0));
  // The first of those who are trained on, enough of them for each row: whoever performs is the same, however
  // many do.
  synthetic::DataRecipe seen = request.data;
  seen.performers = std::min(seen.performers, static_cast<int>(seen_people));
  seen.validation_performers = 0;
  seen.device_seconds = 0;
  MIEN_TRY_ASSIGN(const dataset::TrainingData learnt,
                  synthetic::make_dataset(seen, "builtin", rig, solve::part_of_work(progress, 0.9, 1)));
  set(TestSet::seen) = watched_in_lab(learnt.train, like.seed);
  for (std::size_t i = 0; i < request.recorded.size(); ++i) {
    const RecordedMotion& one = request.recorded[i];
    MIEN_TRY_ASSIGN(
        set(TestSet::recorded).emplace_back(),
        synthetic::watch_recorded(one.motion, one.face, rig, Random(request.seed).fork("recorded", i)));
  }
  return out;
}

/// What rows learn from: made when it is first asked for, and kept.
class AblationData {
 public:
  AblationData(const AblationRequest& request, const sensor::Rig& rig, std::string rig_text)
      : request_(request), rig_(rig), rig_text_(std::move(rig_text)) {}

  /// Names all that a row's data depend on.
  [[nodiscard]] std::string key(const AblationRow& row, std::size_t seed) const {
    std::string out =
        fmt::format("{}\n{}\n{}\n", data_table(request_.data), rig_text_, fmt::join(row.sensors, " "));
    if (row.sensors != rig_.face_sensor_names()) out += "worn alone\n";
    if (row.one_in > 1) out += fmt::format("one in {}, {}\n", row.one_in, seed);
    if (row.learns_from != LearnsFrom::performers)
      out += fmt::format("{} {}\n", row.learns_from == LearnsFrom::takes ? "takes" : "both", takes_key());
    return out;
  }

  Result<dataset::TrainingData> of(const AblationRow& row, std::size_t seed, const Progress& progress) {
    dataset::TrainingData out;
    if (row.learns_from == LearnsFrom::takes) {
      MIEN_TRY_ASSIGN(const dataset::TrainingData* taken, takes(progress));
      out = *taken;
    } else {
      MIEN_TRY_ASSIGN(const dataset::TrainingData* all, performers(row.sensors, progress));
      out = {synthetic::one_in_people(all->train, row.one_in, seed), all->validation};
    }
    if (row.learns_from == LearnsFrom::both) {
      MIEN_TRY_ASSIGN(const dataset::TrainingData* taken, takes(progress));
      MIEN_TRY_ASSIGN(out, synthetic::put_together(std::move(out), *taken));
    }
    return out;
  }

 private:
  /// Whoever records more, or anew, has other data.
  [[nodiscard]] std::string takes_key() const {
    std::string out = request_.takes.string();
    if (const auto splits = read_text(request_.splits)) out += "\n" + *splits;
    std::error_code code;
    std::vector<std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(request_.takes, code))
      if (entry.is_regular_file(code))
        files.push_back(fmt::format("{} {} {}", entry.path().string(), entry.file_size(code),
                                    entry.last_write_time(code).time_since_epoch().count()));
    std::ranges::sort(files);
    for (const std::string& file : files) out += "\n" + file;
    return out;
  }

  /// Kept of all sensors, which most rows have, and of the last others.
  Result<const dataset::TrainingData*> performers(const std::vector<std::string>& sensors,
                                                  const Progress& progress) {
    const bool all = sensors == rig_.face_sensor_names();
    std::optional<dataset::TrainingData>& kept = all ? performers_ : fewer_;
    if (!kept || kept->train.sensors != sensors) {
      MIEN_TRY_ASSIGN(const sensor::Rig rig, rig_with_sensors(rig_, sensors));
      MIEN_TRY_ASSIGN(kept, synthetic::make_dataset(request_.data, "builtin", rig, progress));
    }
    return &*kept;
  }

  Result<const dataset::TrainingData*> takes(const Progress& progress) {
    if (takes_) return &*takes_;
    MIEN_TRY_ASSIGN(dataset::TakesData people, dataset::read_training_takes(request_.takes, request_.splits,
                                                                            rig_, request_.seed, progress));
    for (dataset::Dataset* set : {&people.data.train, &people.data.validation})
      for (dataset::Sequence& sequence : set->sequences) sequence.from_take = true;
    takes_ = std::move(people.data);
    for (const std::string& sentence : people.left_out) request_.tell(sentence);
    return &*takes_;
  }

  const AblationRequest& request_;
  const sensor::Rig& rig_;
  std::string rig_text_;
  std::optional<dataset::TrainingData> performers_, fewer_, takes_;
};

/// Of those who are trained on, the first whom a row's training of this seed learnt from.
std::vector<synthetic::ImuPerson> learnt_by(const AblationRow& row, std::size_t seed,
                                            const std::vector<synthetic::ImuPerson>& seen) {
  // Of each seed as many.
  const std::size_t count = std::min(kSeenPeople, seen.size() / row.one_in);
  std::vector<synthetic::ImuPerson> out;
  for (std::size_t i = 0; i < count; ++i) out.push_back(seen[i * row.one_in + seed % row.one_in]);
  return out;
}

class AblationWork {
 public:
  AblationWork(const AblationRequest& request, const sensor::Rig& rig, std::string rig_text,
               const Progress& progress)
      : request_(request),
        rig_(rig),
        data_(request, rig, std::move(rig_text)),
        progress_(progress),
        face_(builtin_face::make_builtin()),
        meter_(face_) {}

  Result<AblationStudy> run(std::vector<AblationRow> rows, const TrainShort& train) {
    MIEN_TRY_ASSIGN(const std::vector<model::ModelFile> trained, train_rows(rows, train));
    AblationStudy out;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      std::vector<const model::ModelFile*> models;
      for (std::size_t s = 0; s < request_.seeds; ++s) models.push_back(&trained[first_of_[r] + s]);
      const double all = static_cast<double>(rows.size() + request_.shipped.size());
      const auto done = [&](double row) { return kTrainedShare + (1 - kTrainedShare) * row / all; };
      const auto row = static_cast<double>(r);
      MIEN_TRY_ASSIGN(
          out.rows.emplace_back(),
          tried(std::move(rows[r]), models, solve::part_of_work(progress_, done(row), done(row + 1))));
    }
    for (const ShippedModel& shipped : request_.shipped) {
      AblationRow row{.name = shipped.name,
                      .group = kShippedGroup,
                      .title = shipped.name,
                      .sensors = shipped.file.features.sensors};
      MIEN_TRY_ASSIGN(out.shipped.emplace_back(),
                      tried(std::move(row), {&shipped.file}, solve::part_of_work(progress_, 0.99, 1)));
    }
    out.training_people = static_cast<std::size_t>(request_.data.performers);
    const double device_s = request_.data.device_seconds * (1 + 1.5 * request_.data.device_long_share);
    out.training_minutes =
        request_.data.performers * (request_.data.seconds + request_.data.device_share * device_s) / 60;
    progress_(1, "done");
    return out;
  }

 private:
  /// Two rows whose networks are trained alike share them.
  static bool trained_alike(const AblationRow& a, const AblationRow& b) {
    return a.sensors == b.sensors && a.one_in == b.one_in && a.learns_from == b.learns_from &&
           a.network == b.network && a.window == b.window && a.difference_weight == b.difference_weight;
  }

  Result<std::vector<model::ModelFile>> train_rows(const std::vector<AblationRow>& rows,
                                                   const TrainShort& train) {
    std::vector<ShortTraining> trainings;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      std::size_t alike = 0;
      while (!trained_alike(rows[alike], rows[r])) ++alike;
      first_of_.push_back(alike < r ? first_of_[alike] : trainings.size());
      if (alike < r) continue;
      for (std::size_t s = 0; s < request_.seeds; ++s) {
        MIEN_TRY_ASSIGN(trainings.emplace_back(), training_of(rows[r], s));
      }
    }
    return train(trainings, solve::part_of_work(progress_, 0, kTrainedShare));
  }

  Result<ShortTraining> training_of(const AblationRow& row, std::size_t seed) {
    MIEN_TRY_ASSIGN(sensor::Rig rig, rig_with_sensors(rig_, row.sensors));
    rig.skin.reset();  // What the networks read is made already.
    const std::string rig_text = sensor::write_rig(rig);
    return ShortTraining{
        .name = fmt::format("{}-{}", row.name, seed + 1),
        .recipe = short_recipe({.seed = training_seed(request_.seed, seed),
                                .steps = request_.steps,
                                .network = row.network,
                                .window = row.window,
                                .difference_weight = row.difference_weight},
                               request_.data),
        .rig = rig_text,
        .data_key = data_.key(row, seed),
        .data = [this, row, seed](const Progress& progress) { return data_.of(row, seed, progress); }};
  }

  /// People as these sensors saw them: kept of all sensors, which most rows have, and of the last others.
  Result<const Tested*> tests_of(const std::vector<std::string>& sensors, const Progress& progress) {
    const bool all = sensors == rig_.face_sensor_names();
    std::optional<Tested>& kept = all ? tested_ : fewer_;
    if (!kept || kept->sensors != sensors) {
      MIEN_TRY_ASSIGN(const sensor::Rig rig, rig_with_sensors(rig_, sensors));
      const std::size_t seen = all ? kFewestShare * kSeenPeople : kSeenPeople;
      MIEN_TRY_ASSIGN(kept, make_tests(request_, rig, seen, progress));
      kept->sensors = sensors;
    }
    return &*kept;
  }

  Result<AblationResult> tried(AblationRow row, const std::vector<const model::ModelFile*>& models,
                               const Progress& progress) {
    AblationResult out;
    const bool shipped = row.group == kShippedGroup;
    MIEN_TRY_ASSIGN(const Tested* tested,
                    tests_of(shipped ? rig_.face_sensor_names() : row.sensors, progress));
    if (!progress(1, row.title)) return fail(ErrorCode::cancelled, "stopped", "study ablation");
    for (std::size_t set = 0; set < kTestSetCount; ++set)
      for (std::size_t seed = 0; seed < models.size(); ++seed)
        MIEN_TRY(try_on(*tested, set, row, seed, *models[seed], out));
    out.parameters = model::parameter_count(models.front()->architecture);
    MIEN_TRY(bound(row, out));
    out.row = std::move(row);
    return out;
  }

  Result<void> try_on(const Tested& tested, std::size_t set, const AblationRow& row, std::size_t seed,
                      const model::ModelFile& model, AblationResult& out) const {
    const bool seen = static_cast<TestSet>(set) == TestSet::seen;
    if (seen && (row.group == kShippedGroup || row.learns_from == LearnsFrom::takes)) return {};
    const std::vector<synthetic::ImuPerson> learnt =
        seen ? learnt_by(row, seed, tested.sets[set]) : std::vector<synthetic::ImuPerson>();
    const std::vector<synthetic::ImuPerson>& people = seen ? learnt : tested.sets[set];
    if (people.empty()) return {};
    MIEN_TRY_ASSIGN(const std::vector<PersonErrors> errors,
                    errors_of_people(model, tested.sensors, people, meter_, row.join));
    out.errors[set].add_seed(errors);
    return {};
  }

  Result<void> bound(const AblationRow& row, AblationResult& out) const {
    MIEN_TRY_ASSIGN(const std::vector<virt::SkinSite> all, virt::skin_sites(face_, rig_));
    std::vector<virt::SkinSite> sites;
    for (const std::string& name : row.sensors)
      if (const auto s = rig_.find(name)) sites.push_back(all[*s]);
    if (sites.empty()) return {};
    const SensorBound told = sensor_bound(meter_, sites, kBoundPrior, kBoundNoiseRad, Random(request_.seed));
    out.bound_mse = told.mse;
    out.bound_pve_mm = told.pve_mm.mean;
    return {};
  }

  const AblationRequest& request_;
  const sensor::Rig& rig_;
  AblationData data_;
  const Progress& progress_;
  face::Face face_;
  measure::Meter meter_;
  std::optional<Tested> tested_, fewer_;
  std::vector<std::size_t> first_of_;  ///< Of each row, its first seed's training.
};

}  // namespace

std::vector<AblationRow> ablation_rows(const sensor::Rig& rig, bool takes) {
  RowTable table(rig);
  table.add({.name = std::string(kAblationBase),
             .group = "sensors",
             .title = fmt::format("all {} sensors, all data, recurrent", table.sensors())});
  table.add_five("five_sensors", "the paper's five, at the lower cheeks", kPaperFive);
  table.add_five("five_upper", "the paper's five, at the upper cheeks", kPaperFiveUpper);
  for (const MuscleRegion& region : kMuscleRegions)
    table.add_sensors(region.name, region.title, [&](const sensor::Mount& mount) {
      return std::ranges::find(region.sites, mount.site) == region.sites.end();
    });
  table.add_sensors("one_side", "the left half",
                    [](const sensor::Mount& mount) { return mount.side != 'R'; });

  table.add({.name = "third_of_people", .group = "data", .title = "a third of the people", .one_in = 3});
  table.add({.name = "tenth_of_people", .group = "data", .title = "a tenth of the people", .one_in = 10});
  if (takes) {
    table.add({.name = "takes_alone",
               .group = "data",
               .title = "people's takes alone",
               .learns_from = LearnsFrom::takes});
    table.add({.name = "takes_too",
               .group = "data",
               .title = "performers and people's takes",
               .learns_from = LearnsFrom::both});
  }

  table.add({.name = "no_difference",
             .group = "networks",
             .title = "recurrent, changes not in its loss",
             .difference_weight = 0});
  table.add({.name = "transformer",
             .group = "networks",
             .title = "transformer, sees 2 s at once",
             .network = ShortNetwork::transformer});
  table.add({.name = "diffusion",
             .group = "networks",
             .title = "diffusion, sees 2 s, overlapping",
             .network = ShortNetwork::diffusion});
  table.add({.name = "no_overlap",
             .group = "networks",
             .title = "diffusion, sees 2 s, side by side",
             .network = ShortNetwork::diffusion,
             .join = synthetic::WindowJoin::side_by_side});

  for (const std::size_t window : {30, 60, 240})
    table.add({.name = fmt::format("window_{}", window),
               .group = "windows",
               .title = fmt::format("trained on {:.3g} s at a time instead of 2 s",
                                    static_cast<double>(window) / 60),
               .window = window});
  return std::move(table).rows();
}

Result<std::vector<AblationRow>> chosen_rows(const sensor::Rig& rig, bool takes,
                                             std::span<const std::string> names) {
  std::vector<AblationRow> all = ablation_rows(rig, takes);
  if (names.empty()) return all;
  std::vector<std::string> known;
  for (const AblationRow& row : all) known.push_back(row.name);
  for (const std::string& name : names)
    if (!takes && (name == "takes_alone" || name == "takes_too"))
      return fail(ErrorCode::bad_usage, "row " + name + " learns from takes", "--rows",
                  "give --takes FOLDER for it");
    else if (std::ranges::find(known, name) == known.end())
      return fail(ErrorCode::not_found, fmt::format("there is no row {}{}", name, did_you_mean(name, known)),
                  "--rows", fmt::format("the rows are {}", fmt::join(known, ", ")));
  std::erase_if(all, [&](const AblationRow& row) {
    return row.name != kAblationBase && std::ranges::find(names, row.name) == names.end();
  });
  return all;
}

std::string_view ablation_test_name(TestSet set) {
  constexpr std::array<std::string_view, kTestSetCount> kNames = {"device", "lab", "strangers", "recorded",
                                                                  "seen"};
  return kNames[static_cast<std::size_t>(set)];
}

measure::SeedFigures figures_of(const AblationResult& row, TestSet set,
                                measure::SeedFigures SeedErrors::*measure) {
  measure::SeedFigures figures = row.on(set).*measure;
  if (set == TestSet::recorded)
    for (std::vector<double>& seed : figures)
      seed = {std::accumulate(seed.begin(), seed.end(), 0.0) / static_cast<double>(seed.size())};
  return figures;
}

Result<AblationStudy> study_ablation(const AblationRequest& request, const TrainShort& train,
                                     const Progress& progress) {
  MIEN_TRY_ASSIGN(std::string rig_text, read_text(request.rig));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::parse_rig(rig_text, request.rig.string()));
  if (sensor::kinds_of(rig) != std::vector<std::string>{"imu"} || rig.face_sensors().empty())
    return fail(ErrorCode::mismatch, "the rig has no IMUs on the face, or other sensors beside them",
                request.rig.string(), "use one such as rigs/default.toml");
  MIEN_TRY_ASSIGN(std::vector<AblationRow> rows, chosen_rows(rig, !request.takes.empty(), request.rows));
  return AblationWork(request, rig, std::move(rig_text), progress).run(std::move(rows), train);
}

}  // namespace mien::lab
