#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"

namespace mien::model {

/// One array of a safetensors file, row-major. Numbers are fp32 in memory whatever the file holds.
struct Tensor {
  std::string name;
  std::vector<std::size_t> shape;  ///< Empty for a single number.
  std::vector<float> values;
  bool operator==(const Tensor&) const = default;
};

/// What a safetensors file holds: arrays in the order of their bytes, and texts by name.
struct TensorFile {
  std::vector<Tensor> tensors;
  std::map<std::string, std::string> metadata;
};

/// How numbers are stored. bf16 keeps 8 of fp32's 24 bits, and half the bytes.
enum class TensorType { f32, bf16 };

/// The header may be no longer than this (the format's own limit), whatever the file says.
inline constexpr std::size_t kMaxHeaderBytes = 100'000'000;

/// Reads a safetensors file: F32 and BF16, every byte of data in exactly one array, no name twice, numbers
/// finite. `where` names the file in errors. Errors: truncated, malformed, unsupported (another type),
/// out_of_range. Nothing is allocated from a declared size before the bytes are known to be there. Source:
/// github.com/huggingface/safetensors, section "Format".
[[nodiscard]] Result<TensorFile> parse_safetensors(std::span<const std::byte> bytes, std::string_view where);
/// The same from a file. Errors: and read_file's.
[[nodiscard]] Result<TensorFile> read_safetensors(const std::filesystem::path& path);

/// The bytes of a file that parse_safetensors reads back. The same input gives the same bytes. The data begin
/// at a multiple of 64 bytes. bf16 rounds to nearest even.
[[nodiscard]] std::vector<std::byte> write_safetensors(const TensorFile& file,
                                                       TensorType type = TensorType::f32);

}  // namespace mien::model
