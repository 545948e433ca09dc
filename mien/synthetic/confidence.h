#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/profile.h"
#include "mien/model/confidence.h"
#include "mien/solve/region_tally.h"
#include "mien/solve/reliability.h"
#include "mien/synthetic/watched.h"

namespace mien::synthetic {

/// Measures what a model is worth: its answers to people it was not trained on, each with all sensors and
/// six times with some lost, from one to all of them. The same people and seed give the same table, on any
/// number of threads (0: one a core). Errors: not_found (nobody), the tracker's; cancelled. Cost: of a causal
/// model about a second of one core a person and minute.
[[nodiscard]] Result<model::ConfidenceTable> measure_confidence(const WatchedGroup& group, std::uint64_t seed,
                                                                const Progress& progress, unsigned threads);

/// Fits the regions' maps to what this table says of people whom the model was not trained on: of `group`
/// with all sensors and six times with some lost, as above, and of every one of `faulty` under each of its
/// faults; a frame counts like any other. Errors and repeatability as measure_confidence(); `faulty` may be
/// empty.
[[nodiscard]] Result<model::RegionMaps> fit_regions(const model::ConfidenceTable& table,
                                                    const WatchedGroup& group,
                                                    const std::vector<FaultyGroup>& faulty,
                                                    std::uint64_t seed, const Progress& progress,
                                                    unsigned threads);

/// How well shapes that are called measured follow the truth: of one person and shape each, where the truth
/// moves (Correlation::speaks).
struct Followed {
  std::size_t pairs = 0;
  std::size_t good = 0;  ///< Of correlation kMeasuredCorrelation or more.
  [[nodiscard]] double share() const {
    return pairs > 0 ? static_cast<double>(good) / static_cast<double>(pairs) : 1;
  }
};

/// One set of people under one loss of sensors, or under one fault.
struct ConfidenceRow {
  std::string who;
  std::string fault;     ///< Empty: none.
  std::size_t lost = 0;  ///< Sensors, drawn for each person.
  std::size_t people = 0;
  std::size_t frames = 0;
  double measured = 0;            ///< Share of frames and shapes that are called measured.
  std::size_t gaze_measured = 0;  ///< Of gaze: frames and shapes. None, where nothing is untrue.
  Followed followed;
  solve::Reliability all;
  /// The expected error of each one's frames alone, ascending: what one person gives is further from the
  /// table than many together.
  std::vector<double> single;
  solve::Reliability moving;  ///< Where the estimate is above model::kConfidenceTolerance: no shape at rest.
  /// The baseline: what was said before there was a table. Everything but gaze measured while a sensor is
  /// there, and the coverage as confidence.
  Followed followed_before;
  solve::Reliability all_before;
  solve::RegionTally regions;          ///< Of a table without maps: of confidence 0.
  std::vector<double> regions_single;  ///< As `single`.
};

/// What is promised of people that the table was not measured on.
inline constexpr double kErrorAllowed = 0.05;

/// What this table says of every group with all sensors, without one, three and six. Errors and cost as
/// measure_confidence().
[[nodiscard]] Result<std::vector<ConfidenceRow>> study_confidence(const model::ConfidenceTable& table,
                                                                  const std::vector<WatchedGroup>& groups,
                                                                  std::uint64_t seed,
                                                                  const Progress& progress, unsigned threads);

/// The same under every fault of each group, with all sensors: a row a fault. None for no group.
[[nodiscard]] Result<std::vector<ConfidenceRow>> study_faults(const model::ConfidenceTable& table,
                                                              const std::vector<FaultyGroup>& groups,
                                                              const Progress& progress, unsigned threads);

/// Whether the row keeps what is promised of shapes: calibration, correlation, gaze.
[[nodiscard]] bool kept(const ConfidenceRow& row);
/// And of regions: calibration.
[[nodiscard]] bool regions_kept(const ConfidenceRow& row);

}  // namespace mien::synthetic
