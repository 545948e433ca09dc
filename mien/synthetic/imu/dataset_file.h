#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/synthetic/imu/make_dataset.h"

namespace mien::synthetic {

/// What is trained and validated on as one file, so that performances are made once and trained on often: a
/// safetensors file with fp32 arrays. Of the sequence i of `train` and `validation`: `train.i.values` (frames
/// x 7n), `train.i.present` (frames x 2n, 0 or 1), `train.i.weights` (frames x 53) and, where the skin is
/// known, `train.i.slopes` (3n x 53); `standard_slopes` where they are known. The metadata's `dataset` is
/// JSON: `sensors`, and of each set a list of {"performer", "lab", "from_take"}. The same data give the same
/// bytes.
[[nodiscard]] std::vector<std::byte> format_training_data(const dataset::TrainingData& data);
/// The same into a file, whole or not at all. Errors: write_file's.
[[nodiscard]] Result<void> write_training_data(const std::filesystem::path& path,
                                               const dataset::TrainingData& data);

/// Reads it back. Errors: parse_safetensors's; malformed (not such a file, arrays that are missing or of
/// another shape, anything that is neither there nor away). `where` names the file.
[[nodiscard]] Result<dataset::TrainingData> parse_training_data(std::span<const std::byte> bytes,
                                                                std::string_view where);
/// The same from a file; any size. Errors: and read_file's.
[[nodiscard]] Result<dataset::TrainingData> read_training_data(const std::filesystem::path& path);

}  // namespace mien::synthetic
