#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/model/model_file.h"
#include "mien/train/batches.h"

namespace mien::train {

/// What is found out about a trained network before it is written, all on validation performers.
struct Assessment {
  /// A sampler setting and how it did.
  struct Candidate {
    model::SamplerSettings settings;
    double mse = 0;           ///< Of weights in [0, 1].
    double jitter_ratio = 0;  ///< Mean third difference of the weights, over the truth's.
    double seam_ratio = 0;    ///< Mean third difference where windows join, over that elsewhere.
  };
  struct Profile {
    std::string name;  ///< "lab", "device" (with takes), "takes": of those alone, by the ridge of "device".
    double ridge_mse = 0, mean_pose_mse = 0;
  };
  /// A causal network, frame by frame.
  struct Causal {
    double mse = 0, jitter_ratio = 0;  ///< As a candidate's.
  };
  std::vector<Candidate> samplers;  ///< Of a window network.
  std::optional<Causal> causal;
  std::vector<Profile> profiles;
};

/// A seam is not to be seen: joins may be this much rougher than the rest.
inline constexpr double kSeamLimit = 1.2;

/// Mean weights over all frames, clipped to [0, 1].
[[nodiscard]] std::vector<float> mean_pose_of(const dataset::Dataset& dataset,
                                              const FrameWeights& weights = {});

/// Covariance of the weights over all frames, clipped to [0, 1]: shapes x shapes, row-major.
[[nodiscard]] std::vector<float> weight_covariance_of(const dataset::Dataset& dataset,
                                                      const FrameWeights& weights = {});

/// Mean third difference of weights [frames x width] over the frames that begin new ones of a window
/// (`at_joins`), or over all others. 0 where there are none.
[[nodiscard]] double third_difference(std::span<const float> weights, std::size_t width, std::size_t window,
                                      bool at_joins);

/// Fits the ridge of each profile in the data, every frame counting once, and measures a causal network or
/// chooses the sampler: of the recipe's steps and both ways to hold the overlap, the one of least error among
/// those without a seam. Fills model.ridge and model.sampler. Errors: cancelled.
[[nodiscard]] Result<Assessment> assess(const Recipe& recipe, const BatchMaker& training,
                                        const BatchMaker& validation, model::ModelFile& model,
                                        const Progress& progress);

}  // namespace mien::train
