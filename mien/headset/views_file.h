#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/model/architecture.h"
#include "mien/model/safetensors.h"

namespace mien::headset {

/// A trained network of pictures with its provenance: one safetensors file (docs/method/headset.md). Its
/// views are NetworkView's, its outputs those of headset/answer.h.
struct ViewsFile {
  model::Architecture architecture;
  std::vector<float> mean_answer;  ///< Of training's truth, in the outputs' order and range.
  std::string rig;                 ///< The rig file's text that it learnt with.
  std::string recipe;              ///< Text of the training recipe (TOML).
  std::string results;             ///< Measurements of the training, JSON; may be empty.
  std::vector<model::Tensor> network;
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
