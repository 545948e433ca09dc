#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lab/columns.h"
#include "lab/imu/placement/paper_sites.h"
#include "lab/imu/placement/placement_bound.h"
#include "lab/imu/sensor_bound.h"
#include "lab/imu/short_training.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/core/rotation.h"
#include "mien/face/face.h"
#include "mien/measure/interval.h"
#include "mien/measure/report.h"
#include "mien/render/image.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/imu/skin_motion.h"

namespace mien::lab {

/// What a sensor at each place tells alone (`told`, share of the objective), as colour on the built-in head
/// from the front and at three quarters, dark where it tells most, and the chosen ones as white dots,
/// numbered in their order. `places_m`, `chosen_m`: on the built-in head, frame H. `spacing_m`: of the
/// places, how far each reaches; where no place is near (lids, lips, hair) it keeps pale. Errors: those of
/// render::Lettering::load(). Cost: some seconds.
[[nodiscard]] Result<render::Image> placement_picture(const std::vector<Vec3>& places_m,
                                                      std::span<const double> told,
                                                      const std::vector<Vec3>& chosen_m, double spacing_m,
                                                      int height_px);

/// How sets of sensors are held against each other by what networks make of them.
struct PlacementTrainingRequest {
  std::uint64_t seed = 1;
  std::size_t seeds = 3;    ///< Networks of each set, 1 or more.
  std::size_t steps = 600;  ///< Of each network.
  synthetic::DataRecipe data = short_data(1);
  std::size_t test_people = 24;  ///< Whom nobody trained on, 2 or more.
  double test_seconds = 24;      ///< Of each, in either profile.
  unsigned threads = 0;          ///< 0: one a core.
};

/// A set of sensors as people would wear it, with its [skin].
struct PlacementRig {
  std::string name;  ///< In file names: lower case letters, digits, '-' and '_'.
  std::string title;
  sensor::Rig rig;
};

/// What networks of a set are off on people whom nobody trained on.
struct TrainedPlacement {
  std::string name, title;
  std::size_t sensors = 0;
  SeedErrors device, lab;  ///< In either profile.
};

/// Trains and tries each set. Every set has data of its own, which the same virtual people perform: what a
/// sensor's heading is told by are the other sensors of *its* rig, so that sensors of one set cannot be taken
/// out of the performances of a larger one. Errors: make_dataset's, `train`'s; cancelled.
[[nodiscard]] Result<std::vector<TrainedPlacement>> train_placements(const PlacementTrainingRequest& request,
                                                                     std::span<const PlacementRig> rigs,
                                                                     const TrainShort& train,
                                                                     const Progress& progress);

/// Two sets of as many sensors: which is better, by the vertex error in *device*.
struct PlacementContest {
  std::string ours, paper;        ///< Titles.
  measure::Interval device, lab;  ///< Change of the vertex error from the paper's to ours, as a share.
  measure::Interval device_mse, lab_mse;
  /// A sentence that names the better one with its interval, or says that neither is.
  [[nodiscard]] std::string verdict() const;
};

[[nodiscard]] PlacementContest contest(const TrainedPlacement& ours, const TrainedPlacement& paper);

struct PlacementRequest {
  std::uint64_t seed = 1;
  std::size_t sensors = 11;  ///< Of the set that is written and drawn, 1 to 16; eleven and five are trained.
  double spacing_m = 0.008;  ///< Of the dense grid.
  PlacementObjective objective = PlacementObjective::vertex;
  PlacementSettings settings;  ///< `most` is at least `sensors`.
  PaperSitesRequest paper_sites;
  PlacementTrainingRequest training;
  virt::SkinMotionRequest skin;  ///< Of the rigs that are trained on.
  int picture_px = 640;          ///< Height of the picture.
  bool quick = false;            ///< Trainings are too small to compare anything: reports name no better set.
};

/// The rigs that a study is about.
struct PlacementRigs {
  sensor::Rig paper_candidates;    ///< rigs/candidates.toml.
  sensor::Rig paper;               ///< rigs/default.toml: the eleven that the paper uses.
  std::optional<sensor::Rig> own;  ///< One's own candidates: chosen from instead of the paper's and the grid.
};

/// One set by the linear bound.
struct PlacementRow {
  std::string title;
  std::vector<std::string> sensors;
  double rms_vertex_mm = 0;  ///< Root of the expected squared displacement of the skin's vertices.
  SensorBound bound;
  /// posterior_over_prior(), RMS over the group's shapes.
  std::array<double, kShapeGroups.size()> group_ratios{};
};

struct PlacementStudy {
  std::vector<SensorCandidate> candidates;  ///< What is chosen from comes first, then the rest of the grid.
  std::size_t choices = 0;                  ///< How many are chosen from.
  std::size_t grid_begin = 0;               ///< Where the grid begins: to the end.
  PlacementBound bound;                     ///< Of the choices, by the objective.
  std::vector<double> alone;                ///< error_reductions() of the prior, of all candidates.
  std::vector<PosteriorOverPrior> alone_posterior;  ///< After this candidate alone, of all candidates.
  std::vector<PlacementRow> sets;                   ///< Of each size.
  PlacementRow paper, paper_five;
  std::vector<std::size_t> chosen;  ///< The set of the asked size.
  PaperSitesStudy paper_sites;
  double left_right = 0;  ///< Mean difference of a pair's `alone`, as a share of the largest of all.
  std::vector<TrainedPlacement> trained;  ///< Empty without trainings.
  std::vector<PlacementContest> contests;
  std::string not_trained;  ///< A sentence where sets were to be trained that the candidates do not give.
  /// Names of one's own candidates that were not chosen from: sets are symmetric, and nothing mirrors these.
  std::vector<std::string> without_mirror;
  render::Image picture;  ///< placement_picture() of the grid and the chosen set.

  [[nodiscard]] std::vector<SensorCandidate> chosen_candidates() const;
};

/// The whole study: bound on `face`, its picture, what the paper's sites feel and trainings on virtual people
/// of the built-in family. `train` null: no trainings. Else sets as large as the paper's (eleven) and its
/// kPaperFive are trained where the candidates give them, and `not_trained` says where they do not. Errors:
/// candidates_of()'s, those of the sites, bad_usage (fewer candidates than sensors), `train`'s; cancelled.
/// The same for any number of threads.
[[nodiscard]] Result<PlacementStudy> study_placement(const PlacementRequest& request, const face::Face& face,
                                                     const PlacementRigs& rigs, const TrainShort* train,
                                                     const Progress& progress);

/// The shapes that a sensor tells most of, largest reduction of the variance first: at most `most`, at least
/// a tenth each. "jawOpen 62 %, ...".
[[nodiscard]] std::string top_shapes(const PosteriorOverPrior& posterior, std::size_t most = 5);

/// The figures of a set by the linear bound.
[[nodiscard]] const Columns<PlacementRow>& placement_columns();
/// Those of a set's networks.
[[nodiscard]] const Columns<TrainedPlacement>& trained_columns();
/// What candidates tell, by their index. The study must outlive them.
[[nodiscard]] Columns<std::size_t> candidate_columns(const PlacementStudy& study);

/// What networks of each set are off, and how large their trainings were; without rows where none was
/// trained.
[[nodiscard]] measure::Table placement_trained_table(const PlacementStudy& study,
                                                     const PlacementTrainingRequest& request);

/// What the trainings say, a sentence each: which set is better, or that trainings so small compare
/// nothing; and which sets could not be trained. Empty where none was to be.
[[nodiscard]] std::vector<std::string> placement_verdicts(const PlacementStudy& study,
                                                          const PlacementRequest& request);

/// The whole study on one page. Errors: those of the pictures' encoder.
[[nodiscard]] Result<measure::Report> placement_report(const PlacementStudy& study,
                                                       const PlacementRequest& request,
                                                       const std::string& subtitle);

}  // namespace mien::lab
