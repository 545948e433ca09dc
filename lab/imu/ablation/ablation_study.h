#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lab/imu/short_training.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/face.h"
#include "mien/face/motion.h"
#include "mien/measure/interval.h"
#include "mien/measure/report.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"

namespace mien::lab {

/// Whom a row's networks learn from.
enum class LearnsFrom : std::uint8_t {
  performers,  ///< Virtual performers, of whom everything is known.
  takes,       ///< People's takes, labelled by a phone.
  both,        ///< Half of each step's windows from each.
};

/// One way to leave something out, or to do it another way.
struct AblationRow {
  std::string name;                  ///< "five_sensors": as --rows and JSON have it.
  std::string group;                 ///< "sensors", "data", "networks", "windows".
  std::string title;                 ///< For people.
  std::vector<std::string> sensors;  ///< That the network reads, by name.
  /// One in so many of the virtual performers, 1 or more; as many seeds learn from others of them, further
  /// ones from the same again.
  std::size_t one_in = 1;
  LearnsFrom learns_from = LearnsFrom::performers;
  ShortNetwork network = ShortNetwork::recurrent;
  std::size_t window = 120;
  double difference_weight = 5;  ///< As ShortRecipe's.
  synthetic::WindowJoin join = synthetic::WindowJoin::overlap;
};

/// The row that all others are compared with.
inline constexpr std::string_view kAblationBase = "base";

/// All rows that a rig has sensors enough for, the base first. Of the default rig: the paper's five sensors
/// (two at the eyebrows, one at the jaw, two at the cheeks), each region of muscles left out, one side; a
/// third and a tenth of the people; `takes`: people's takes alone and with virtual performers; other
/// networks; other windows.
[[nodiscard]] std::vector<AblationRow> ablation_rows(const sensor::Rig& rig, bool takes);

/// The base and those of these names, in the table's order; all where no name is given. Errors: not_found,
/// with the nearest name.
[[nodiscard]] Result<std::vector<AblationRow>> chosen_rows(const sensor::Rig& rig, bool takes,
                                                           std::span<const std::string> names);

/// A model that was trained before, by its own budget, for the same table.
struct ShippedModel {
  std::string name;
  model::ModelFile file;
};

/// A recorded performance, and the face on which it is played.
struct RecordedMotion {
  face::Motion motion;
  face::Face face;
};

struct AblationRequest {
  std::filesystem::path rig;                   ///< Its file: IMUs on the face.
  std::vector<std::string> rows;               ///< By name; empty: all. The base is always among them.
  std::size_t seeds = 3;                       ///< Trainings of each row, 1 or more.
  std::size_t steps = 600;                     ///< Of each training.
  synthetic::DataRecipe data = short_data(1);  ///< Whom they learn from.
  std::size_t test_people = 16;                ///< Of each kind of virtual people, 1 or more.
  double test_seconds = 30;                    ///< Of each of them in each profile, s.
  std::filesystem::path takes;   ///< A folder of people's takes (read_training_takes), or empty.
  std::filesystem::path splits;  ///< Who of them is trained and who validated on, or empty.
  std::vector<ShippedModel> shipped;
  std::vector<RecordedMotion> recorded;  ///< Tried in *device*, too.
  std::uint64_t seed = 1;
  /// Told what of the takes is left out, a sentence each, when they are read.
  std::function<void(const std::string& sentence)> tell = [](const std::string&) {};
};

/// The group of models that were trained before.
inline constexpr const char* kShippedGroup = "shipped";

/// Whom networks are tried on. None of them is learnt from, but for `seen`; of `recorded` whoever gives the
/// recordings sees to it.
enum class TestSet : std::uint8_t {
  device,  ///< Virtual people like those of the training, in *device*.
  lab,     ///< The same in *lab*.
  /// People shifted from the training's distribution (draw_shifted_person), whose skin is as their face's
  /// mesh has it, in *device*.
  strangers,
  recorded,  ///< Recorded performances, in *device*.
  /// Of those whom that training learnt from, in *lab*: how much is learnt by heart. Rows that learn from one
  /// in so many have others of them, and shipped models and those of takes alone none.
  seen,
};
inline constexpr std::size_t kTestSetCount = 5;
/// "device", "lab", ...
[[nodiscard]] std::string_view ablation_test_name(TestSet set);

struct AblationResult {
  AblationRow row;
  std::array<SeedErrors, kTestSetCount> errors;  ///< By TestSet; empty where it was not tried.
  std::size_t parameters = 0;
  /// What the row's sensors tell by the linear bound (sensor_bound: prior 0.10, noise 2 degrees).
  double bound_mse = 0, bound_pve_mm = 0;

  [[nodiscard]] const SeedErrors& on(TestSet set) const { return errors[static_cast<std::size_t>(set)]; }
};

struct AblationStudy {
  std::vector<AblationResult> rows;     ///< The base first.
  std::vector<AblationResult> shipped;  ///< Models that were trained before.
  std::size_t training_people = 0;      ///< Virtual performers of the base.
  double training_minutes = 0;          ///< Of theirs.
};

/// One figure of a row, as intervals are of it. Recorded performances are few and nobody drew them: their
/// mean stands for one person, so that an interval is over seeds alone.
[[nodiscard]] measure::SeedFigures figures_of(const AblationResult& row, TestSet set,
                                              measure::SeedFigures SeedErrors::*measure);

/// Trains every row with every seed, tries it on all test sets, and puts the bound beside it. The same
/// request gives the same study. Errors: the rig's, chosen_rows's, the data's and the trainer's; cancelled.
[[nodiscard]] Result<AblationStudy> study_ablation(const AblationRequest& request, const TrainShort& train,
                                                   const Progress& progress);

/// How much more a row is off than the base on one test set, as a share of the base's figure, with 95 %
/// confidence; nothing for the base itself, for a model of one training, and where it was not tried.
[[nodiscard]] std::optional<measure::Interval> change_of(
    const AblationStudy& study, const AblationResult& row, TestSet set,
    measure::SeedFigures SeedErrors::*measure = &SeedErrors::pve_mm);

/// The whole study as people read it. `takes`: whose the rows of takes learnt from; empty: nobody's.
[[nodiscard]] measure::Report ablation_report(const AblationStudy& study, const std::string& takes,
                                              const std::string& subtitle);

}  // namespace mien::lab
