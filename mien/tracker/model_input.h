#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/face/profile.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"
#include "mien/model/skin_map.h"

namespace mien::tracker {

/// Encodes a rig's features as a model's condition: sensors are matched by name; one that the rig lacks, or
/// whose values are not finite, is missing. With a personalised model, rotations are mapped from the wearer's
/// skin to the standard skin first (model::SkinMap).
class ModelInput {
 public:
  /// `rig_sensors`: names of the frames' entries.
  ModelInput(const model::ModelFile& file, const std::vector<std::string>& rig_sensors);

  /// Uses this skin's wearer from now on; no mapping where it has none. `mean_pose`: 53 mean weights.
  void use(const model::Skin& skin, std::span<const float> mean_pose);

  /// Whether rig and model have no sensor in common.
  [[nodiscard]] bool empty() const;
  /// The condition of one frame. frame.sensors.size(): the rig's; out.size() == layout.width(). No
  /// allocation.
  void encode(const model::FeatureFrame& frame, std::span<float> out);
  /// Whether the model's sensor `index` had a rotation in the last encoded frame.
  [[nodiscard]] bool present(std::size_t index) const { return present_[index] != 0; }
  /// The number of such sensors.
  [[nodiscard]] std::size_t present_count() const;
  [[nodiscard]] std::size_t sensor_count() const { return places_.size(); }

 private:
  model::FeatureLayout layout_;
  model::FeatureNormalisation normalisation_;
  std::vector<std::ptrdiff_t> places_;  // For each of the model's sensors its index in the rig, or -1.
  std::optional<model::SkinMap> skin_;
  std::vector<float> values_;  // The last frame's, as encode_values takes them.
  std::vector<std::uint8_t> present_;
};

/// The ridge baseline of a model file: linear on one frame's features.
class RidgeSolver {
 public:
  /// `profile`: "lab" or "device". None where the file has no baseline for it.
  [[nodiscard]] static std::optional<RidgeSolver> create(const model::ModelFile& file,
                                                         const std::vector<std::string>& rig_sensors,
                                                         std::string_view profile);
  [[nodiscard]] face::BlendshapeWeights solve(const model::FeatureFrame& features);

 private:
  RidgeSolver(const model::ModelFile& file, const std::vector<std::string>& rig_sensors,
              const model::RidgeBaseline& baseline)
      : input_(file, rig_sensors), baseline_(baseline), condition_(file.features.width()) {}

  ModelInput input_;
  model::RidgeBaseline baseline_;
  std::vector<float> condition_;
};

/// The same on a track of features, one result a frame; empty where the file has no baseline.
[[nodiscard]] std::vector<face::BlendshapeWeights> solve_ridge(const model::ModelFile& file,
                                                               std::span<const model::FeatureFrame> features,
                                                               const std::vector<std::string>& rig_sensors,
                                                               std::string_view profile);

}  // namespace mien::tracker
