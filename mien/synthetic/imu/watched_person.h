#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/core/random.h"
#include "mien/dataset/dataset.h"
#include "mien/face/profile.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"
#include "mien/synthetic/watched.h"
#include "mien/take/take.h"
#include "mien/virtual/performance.h"

namespace mien::synthetic {

/// What the sensors of one person gave, and what the face did: of equal size, 60 frames a second.
struct ImuPerson {
  std::vector<model::FeatureFrame> features;
  std::vector<face::BlendshapeWeights> truth;
};

/// How a window network's windows follow each other; others have none.
enum class WindowJoin : std::uint8_t {
  overlap,       ///< Each shares half of itself with the one before, as the solver has it.
  side_by_side,  ///< Each is answered for itself.
};

/// The model's answer to these frames, from the first on, by whichever network it has. `sensors`: names of
/// the features' entries. Errors: the tracker's.
[[nodiscard]] Result<std::vector<face::BlendshapeWeights>> answers_of(
    const model::ModelFile& model, const std::vector<std::string>& sensors,
    std::span<const model::FeatureFrame> features, WindowJoin join = WindowJoin::overlap);

/// People of a data set, one a sequence; those of the lab profile are left out where there are others.
[[nodiscard]] std::vector<ImuPerson> watched(const dataset::Dataset& data);

/// Virtual people in the rig's *device* profile, who wear and move as those of training do
/// (make_dataset), drawn from a seed of their own. Errors: make_dataset's.
[[nodiscard]] Result<std::vector<ImuPerson>> watch_virtual(int people, double seconds, std::uint64_t seed,
                                                           const sensor::Rig& rig, const Progress& progress,
                                                           unsigned threads);

/// People unlike those of training (draw_shifted_person), likewise. Errors: perform_with's; cancelled.
[[nodiscard]] Result<std::vector<ImuPerson>> watch_shifted(int people, double seconds, std::uint64_t seed,
                                                           const sensor::Rig& rig, const Progress& progress,
                                                           unsigned threads);

/// A recorded performance on a face, in the rig's *device* profile. Errors: perform_with's.
[[nodiscard]] Result<ImuPerson> watch_recorded(const face::Motion& motion, const face::Face& face,
                                               const sensor::Rig& rig, const Random& random);

/// Of a session, what the features and the truth are where it is evaluated. Shape: a feature and a truth a
/// tick.
[[nodiscard]] ImuPerson evaluated_frames(std::vector<model::FeatureFrame> features,
                                         const std::vector<take::TruthFrame>& truth);

/// The same without `lost` sensors (at most all), which are drawn.
[[nodiscard]] std::vector<model::FeatureFrame> without_sensors(std::span<const model::FeatureFrame> features,
                                                               std::size_t lost, Random random);

/// These people before this model, whichever network it has. `sensors`: names of the features' entries.
[[nodiscard]] WatchedGroup watched_by(const model::ModelFile& model, const std::vector<std::string>& sensors,
                                      std::string who, std::vector<ImuPerson> people);
[[nodiscard]] WatchedGroup watched_by(std::shared_ptr<const model::ModelFile> model,
                                      const std::vector<std::string>& sensors, std::string who,
                                      std::vector<ImuPerson> people);

}  // namespace mien::synthetic
