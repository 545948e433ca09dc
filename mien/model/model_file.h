#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/model/architecture.h"
#include "mien/model/confidence.h"
#include "mien/model/correction.h"
#include "mien/model/features.h"
#include "mien/model/ridge.h"
#include "mien/model/safetensors.h"
#include "mien/model/schedule.h"
#include "mien/model/skin_map.h"

namespace mien::model {

/// Everything that turns features into weights, and where it came from: one safetensors file
/// (docs/reference/model_file.md lists its tensors and metadata).
struct ModelFile {
  Architecture architecture;
  FeatureLayout features;
  FeatureNormalisation normalisation;
  std::vector<std::string> shapes;   ///< Names of the outputs, in their order.
  std::vector<float> mean_pose;      ///< Mean weights of the training set, 0 to 1, one a shape.
  std::vector<RidgeBaseline> ridge;  ///< At most one a profile.
  /// How skin turns under the sensors; with a wearer's slopes the model is that wearer's
  /// (tracker::personalise). None: the model cannot be personalised.
  std::optional<Skin> skin;
  /// What is added to a causal network's answers for one wearer (tracker::learn_correction); none: nothing.
  std::optional<Correction> correction;
  /// What its answers are worth. None (older files): nobody measured it, so nothing is called measured and
  /// no confidence is claimed.
  std::optional<ConfidenceTable> confidence;
  ScheduleSettings schedule;    ///< This and the sampler: of a window network alone.
  SamplerSettings sampler;      ///< The defaults, chosen on validation.
  std::string rig;              ///< The rig file's text that the sensors come from; may be empty.
  std::string recipe;           ///< The recipe's text (TOML) that it was trained by.
  std::string results;          ///< What was measured while training, as JSON; may be empty.
  std::vector<Tensor> network;  ///< As network_tensors() lists them, in that order.

  /// The ridge of a profile, or nullptr.
  [[nodiscard]] const RidgeBaseline* ridge_for(std::string_view profile) const;
};

/// Reads and checks a model: architecture within its bounds, every tensor there with its size, no other,
/// sizes of layout, normalisation, shapes and ridges in agreement, scales positive. Errors: as
/// parse_safetensors; malformed, out_of_range, mismatch; unsupported (a newer version).
[[nodiscard]] Result<ModelFile> parse_model(std::span<const std::byte> bytes, std::string_view where);
[[nodiscard]] Result<ModelFile> read_model(const std::filesystem::path& path);

/// The bytes that parse_model reads back. Errors: as parse_model, for a model that does not hold together.
[[nodiscard]] Result<std::vector<std::byte>> format_model(const ModelFile& model);
/// The same into a file, whole or not at all. Errors: as format_model; io.
[[nodiscard]] Result<void> write_model(const std::filesystem::path& path, const ModelFile& model);

}  // namespace mien::model
