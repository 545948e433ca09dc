#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/headset/mirrored_eye.h"
#include "mien/headset/moment_features.h"
#include "mien/model/architecture.h"
#include "mien/model/confidence.h"
#include "mien/model/safetensors.h"

namespace mien::headset {

/// A network over what is found in pictures, frame by frame (docs/method/headset.md): it reads
/// moment_condition() and answers kMemoryOutputs numbers.
struct ViewsMemory {
  model::Architecture architecture;
  std::vector<model::Tensor> network;
  /// Of each judgement, from its logit to a probability; fitted on wearers that nothing else learnt from.
  std::array<model::LogisticMap, kJudgements> judgements;
  MirroredEye mirrored_eye;  ///< Learnt beside it.
  std::string recipe;        ///< Text of its own training recipe (TOML).
  std::string results;       ///< Measurements of it, JSON; may be empty.
};

/// A trained network of pictures with its provenance: one safetensors file (docs/method/headset.md). Its
/// views are NetworkView's, its outputs those of headset/answer.h.
struct ViewsFile {
  model::Architecture architecture;
  std::vector<float> mean_answer;  ///< Of training's truth, in the outputs' order and range.
  std::string rig;                 ///< The rig file's text that it learnt with.
  std::string recipe;              ///< Text of the training recipe (TOML).
  std::string results;             ///< Measurements of the training, JSON; may be empty.
  std::vector<model::Tensor> network;
  std::optional<ViewsMemory> memory;  ///< None: each moment is answered by itself.
};

/// Errors: as parse_safetensors; malformed, out_of_range, mismatch (sizes); unsupported (another file's
/// format, a newer version).
[[nodiscard]] Result<ViewsFile> parse_views_file(std::span<const std::byte> bytes, std::string_view where);
[[nodiscard]] Result<ViewsFile> read_views_file(const std::filesystem::path& path);
/// Inverse of parse_views_file, with the same errors.
[[nodiscard]] Result<std::vector<std::byte>> format_views_file(const ViewsFile& file);
/// Writes the file whole or not at all. Errors: as format_views_file, io.
[[nodiscard]] Result<void> write_views_file(const std::filesystem::path& path, const ViewsFile& file);

}  // namespace mien::headset
