#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lab/imu/placement/misplacement.h"
#include "lab/imu/placement/paper_sites.h"
#include "lab/imu/placement/placement_bound.h"
#include "lab/imu/placement/placement_picture.h"
#include "lab/imu/placement/placement_training.h"
#include "lab/imu/sensor_bound.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/face.h"
#include "mien/measure/metrics.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/imu/skin_motion.h"

namespace mien::lab {

struct PlacementRequest {
  std::uint64_t seed = 1;
  std::size_t sensors = 11;  ///< Of the set that is written and drawn, 1 to 16; eleven and five are trained.
  double spacing_m = 0.008;  ///< Of the dense grid.
  PlacementObjective objective = PlacementObjective::vertex;
  PlacementSettings settings;  ///< `most` is at least `sensors`.
  MisplacementRequest misplacement;
  PaperSitesRequest paper_sites;
  PlacementTrainingRequest training;
  virt::SkinMotionRequest skin;  ///< Of the rigs that are trained on.
  int picture_px = 640;
  bool quick = false;  ///< Trainings are too small to compare anything: reports name no better set.
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
  std::vector<std::size_t> chosen;                           ///< The set of the asked size.
  std::vector<SiteMisplacement> misplaced, misplaced_paper;  ///< Of the chosen set and of the paper's.
  PaperSitesStudy paper_sites;
  double left_right = 0;  ///< Mean difference of a pair's `alone`, as a share of the largest of all.
  std::vector<TrainedPlacement> trained;  ///< Empty without trainings.
  std::vector<PlacementContest> contests;
  std::string not_trained;  ///< A sentence where sets were to be trained that the candidates do not give.
  /// Names of one's own candidates that were not chosen from: sets are symmetric, and nothing mirrors these.
  std::vector<std::string> without_mirror;
  PlacementPictures pictures;

  [[nodiscard]] std::vector<SensorCandidate> chosen_candidates() const;
};

/// The whole study: bound and pictures on `face`, what the paper's sites feel and trainings on virtual people
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

}  // namespace mien::lab
