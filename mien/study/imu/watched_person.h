#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/core/random.h"
#include "mien/face/output_frame.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"
#include "mien/study/dataset.h"
#include "mien/study/performance.h"

namespace mien::study {

/// What the sensors of one person gave, and what the face did: of equal size, 60 frames a second.
struct WatchedPerson {
  std::vector<model::FeatureFrame> features;
  std::vector<face::BlendshapeWeights> truth;
};

/// People of a data set, one a sequence; those of the lab profile are left out where there are others.
[[nodiscard]] std::vector<WatchedPerson> watched(const Dataset& data);

/// Virtual people in the rig's *device* profile, who wear and move as those of training do
/// (make_dataset), drawn from a seed of their own. Errors: make_dataset's.
[[nodiscard]] Result<std::vector<WatchedPerson>> watch_virtual(int people, double seconds, std::uint64_t seed,
                                                               const sensor::Rig& rig,
                                                               const Progress& progress, unsigned threads);

/// A recorded performance on a face, in the rig's *device* profile. Errors: perform_with's.
[[nodiscard]] Result<WatchedPerson> watch_recorded(const face::Motion& motion, const face::Face& face,
                                                   const sensor::Rig& rig, const Random& random);

/// The same without `lost` sensors (at most all), which are drawn.
[[nodiscard]] std::vector<model::FeatureFrame> without_sensors(std::span<const model::FeatureFrame> features,
                                                               std::size_t lost, Random random);

/// The model's answer, whichever network it has, from its first frame on. `sensors`: names of the features'
/// entries. Errors: the tracker's.
[[nodiscard]] Result<std::vector<face::OutputFrame>> answer(const model::ModelFile& model,
                                                            const std::vector<std::string>& sensors,
                                                            std::span<const model::FeatureFrame> features);

}  // namespace mien::study
