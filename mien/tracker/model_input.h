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

/// Brings a rig's features into the form that a model reads: its sensors are found by name, and one that the
/// rig lacks, or whose numbers are not finite, is missing. A model of one wearer's is told what the sensors
/// would say on the skin that it was trained for.
class ModelInput {
 public:
  /// `rig_sensors` names the entries of the frames that will come.
  ModelInput(const model::ModelFile& file, const std::vector<std::string>& rig_sensors);

  /// Reads by this skin's wearer from now on; by nobody's, where it has none.
  void use(const model::Skin& skin, std::span<const float> mean_pose);

  /// Whether rig and model have no sensor in common.
  [[nodiscard]] bool empty() const;
  /// The condition of one frame. Shape: as many sensors as the rig, out.size() == layout.width(). No
  /// allocation.
  void encode(const model::FeatureFrame& frame, std::span<float> out);
  /// Whether the model's sensor `index` had a rotation in the last encoded frame.
  [[nodiscard]] bool present(std::size_t index) const { return present_[index] != 0; }
  /// Of how many of the model's sensors that is so.
  [[nodiscard]] std::size_t present_count() const;
  [[nodiscard]] std::size_t sensor_count() const { return places_.size(); }

 private:
  model::FeatureLayout layout_;
  model::FeatureNormalisation normalisation_;
  std::vector<std::ptrdiff_t> places_;  ///< For each of the model's sensors its place in the rig, or -1.
  std::optional<model::SkinMap> skin_;
  std::vector<float> values_;  ///< The last frame's, in the model's order, as encode_values takes them.
  std::vector<std::uint8_t> present_;
};

/// The ridge baseline of a profile on a track of features; empty when the file has none for it.
[[nodiscard]] std::vector<face::BlendshapeWeights> solve_ridge(const model::ModelFile& file,
                                                               std::span<const model::FeatureFrame> features,
                                                               const std::vector<std::string>& rig_sensors,
                                                               std::string_view profile);

}  // namespace mien::tracker
