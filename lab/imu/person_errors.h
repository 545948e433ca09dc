#pragma once

#include <span>
#include <string>
#include <vector>

#include "lab/interval.h"
#include "mien/core/error.h"
#include "mien/measure/metrics.h"
#include "mien/model/model_file.h"
#include "mien/synthetic/imu/watched_person.h"

namespace mien::lab {

/// What a model's answers to one person are off, over all of the person's frames.
struct PersonErrors {
  double pve_mm = 0;  ///< Mean vertex error.
  double lmk_mm = 0;  ///< Mean error of the 68 landmarks; 0 on a face without them.
  double mse = 0;     ///< Of the 53 weights.
  double jitter = 0;  ///< Third difference of the landmarks over the truth's; 0 where the truth rests.
};

/// Errors of a network that was trained with several seeds: of each seed one figure a person.
struct SeedErrors {
  SeedFigures pve_mm, lmk_mm, mse, jitter;
  [[nodiscard]] bool empty() const { return pve_mm.empty(); }
  /// One more seed's, of the same people in the same order.
  void add_seed(std::span<const PersonErrors> people);
};

/// Each person's errors, in their order. `sensors`: names of the features' entries; those that the model does
/// not know are passed over. `meter`: of the face on which weights become millimetres. Errors: the tracker's;
/// cancelled. The same for any number of threads (0: one a core).
[[nodiscard]] Result<std::vector<PersonErrors>> errors_of_people(
    const model::ModelFile& model, const std::vector<std::string>& sensors,
    std::span<const synthetic::ImuPerson> people, const measure::Meter& meter,
    synthetic::WindowJoin join = synthetic::WindowJoin::overlap, unsigned threads = 0);

/// People of a data set's *lab* profile, with the profile's degree of white noise an axis, from `seed`.
[[nodiscard]] std::vector<synthetic::ImuPerson> watched_in_lab(const dataset::Dataset& data,
                                                               std::uint64_t seed);

}  // namespace mien::lab
