#include "mien/headset/views_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "mien/core/files.h"
#include "mien/headset/answer.h"
#include "mien/model/network_parts.h"

namespace mien::headset {
namespace {

constexpr std::string_view kFormat = "mien-headset";
constexpr std::string_view kVersion = "5";
constexpr const char* kMean = "mean_answer";
constexpr std::string_view kMemoryPrefix = "memory.";
constexpr const char* kJudgementMaps = "judgements";  // Offset and slope of each.
constexpr const char* kMirroredEye = "mirrored_eye";  // MirroredEye's weights, or none; its bias.

Result<void> check_memory(const ViewsMemory& memory, std::size_t features, const std::string& where) {
  if (const auto ok = model::check(memory.architecture); !ok)
    return fail(ok.error().code, ok.error().what, where);
  const model::Architecture& a = memory.architecture;
  if (a.kind != model::NetworkKind::causal || a.condition != moment_condition(features) ||
      a.outputs != kMemoryOutputs)
    return fail(ErrorCode::mismatch, "its memory is of another network of pictures", where);
  if (!std::ranges::all_of(memory.judgements, [](const model::LogisticMap& map) {
        return std::abs(map.offset) <= model::LogisticMap::kLargest &&
               std::abs(map.slope) <= model::LogisticMap::kLargest;
      }))
    return fail(ErrorCode::out_of_range, "its confidence is beyond its range", where);
  const MirroredEye& mirrored = memory.mirrored_eye;
  if (!mirrored.weight.empty() && mirrored.weight.size() != features)
    return fail(ErrorCode::mismatch, "its mirrored eye is of another network of pictures", where);
  if (!std::isfinite(mirrored.bias) ||
      !std::ranges::all_of(mirrored.weight, [](float value) { return std::isfinite(value); }))
    return fail(ErrorCode::out_of_range, "its mirrored eye is beyond its range", where);
  if (const auto ok = model::check_tensors(a, memory.network); !ok)
    return fail(ErrorCode::mismatch, ok.error().what, where);
  return {};
}

Result<std::vector<float>> take_numbers(std::string_view name, model::TensorFile& from,
                                        const std::string& where) {
  if (auto values = model::take_tensor(name, from)) return *std::move(values);
  return fail(ErrorCode::mismatch, fmt::format("tensor {} is missing", name), where);
}

Result<ViewsMemory> take_memory(model::TensorFile& from, const std::string& where) {
  ViewsMemory memory;
  MIEN_TRY_ASSIGN(memory.architecture,
                  model::parse_architecture(from.metadata["memory_architecture"], where));
  memory.recipe = from.metadata["memory_recipe"];
  memory.results = from.metadata["memory_results"];
  MIEN_TRY_ASSIGN(memory.network, model::take_network(memory.architecture, from, where, kMemoryPrefix));
  MIEN_TRY_ASSIGN(const std::vector<float> maps, take_numbers(kJudgementMaps, from, where));
  if (maps.size() != 2 * kJudgements)
    return fail(ErrorCode::mismatch,
                fmt::format("tensor {} has {} numbers, not {}", kJudgementMaps, maps.size(), 2 * kJudgements),
                where);
  for (std::size_t j = 0; j < kJudgements; ++j)
    memory.judgements[j] = {.offset = maps[2 * j], .slope = maps[2 * j + 1]};
  MIEN_TRY_ASSIGN(memory.mirrored_eye.weight, take_numbers(kMirroredEye, from, where));
  if (memory.mirrored_eye.weight.empty())
    return fail(ErrorCode::mismatch, fmt::format("tensor {} is empty", kMirroredEye), where);
  memory.mirrored_eye.bias = memory.mirrored_eye.weight.back();
  memory.mirrored_eye.weight.pop_back();
  return memory;
}

Result<void> check_file(const ViewsFile& file, const std::string& where) {
  if (const auto ok = model::check(file.architecture); !ok)
    return fail(ok.error().code, ok.error().what, where);
  if (file.architecture.kind != model::NetworkKind::views)
    return fail(ErrorCode::mismatch, "the network is none of pictures", where);
  if (file.architecture.outputs != kAnswerOutputs || file.mean_answer.size() != kAnswerOutputs)
    return fail(ErrorCode::mismatch,
                fmt::format("it answers {} numbers, not {}", file.architecture.outputs, kAnswerOutputs),
                where);
  if (!std::ranges::all_of(file.mean_answer, [](float value) { return std::abs(value) <= 2; }))
    return fail(ErrorCode::out_of_range, "its mean answer is beyond its range", where);
  if (const auto ok = model::check_tensors(file.architecture, file.network); !ok)
    return fail(ErrorCode::mismatch, ok.error().what, where);
  if (file.memory) return check_memory(*file.memory, file.architecture.features, where);
  return {};
}

Result<ViewsFile> views_file_of(model::TensorFile from, const std::string& where) {
  auto& metadata = from.metadata;
  ViewsFile file;
  MIEN_TRY_ASSIGN(file.architecture,
                  model::architecture_of(from, kFormat, kVersion, "a model of a headset's pictures", where));
  file.rig = metadata["rig"];
  file.recipe = metadata["recipe"];
  file.results = metadata["results"];
  MIEN_TRY_ASSIGN(file.network, model::take_network(file.architecture, from, where));
  MIEN_TRY_ASSIGN(file.mean_answer, take_numbers(kMean, from, where));
  if (metadata.contains("memory_architecture")) {
    MIEN_TRY_ASSIGN(file.memory, take_memory(from, where));
  }
  MIEN_TRY(model::check_all_taken(from, where));
  MIEN_TRY(check_file(file, where));
  return file;
}

}  // namespace

Result<ViewsFile> parse_views_file(std::span<const std::byte> bytes, std::string_view where) {
  MIEN_TRY_ASSIGN(model::TensorFile from, model::parse_safetensors(bytes, where));
  return views_file_of(std::move(from), std::string(where));
}

Result<ViewsFile> read_views_file(const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(model::TensorFile from, model::read_safetensors(path));
  return views_file_of(std::move(from), path.string());
}

Result<std::vector<std::byte>> format_views_file(const ViewsFile& file) {
  MIEN_TRY(check_file(file, "model"));
  model::TensorFile to;
  to.metadata = {
      {"format", std::string(kFormat)},
      {"version", std::string(kVersion)},
      {"architecture", model::format_architecture(file.architecture)},
      {"rig", file.rig},
      {"recipe", file.recipe},
      {"results", file.results},
  };
  model::add_network(file.network, to);
  to.tensors.push_back({.name = kMean, .shape = {file.mean_answer.size()}, .values = file.mean_answer});
  if (file.memory) {
    to.metadata["memory_architecture"] = model::format_architecture(file.memory->architecture);
    to.metadata["memory_recipe"] = file.memory->recipe;
    to.metadata["memory_results"] = file.memory->results;
    model::add_network(file.memory->network, to, kMemoryPrefix);
    std::vector<float> maps;
    for (const model::LogisticMap& map : file.memory->judgements) {
      maps.push_back(map.offset);
      maps.push_back(map.slope);
    }
    to.tensors.push_back({.name = kJudgementMaps, .shape = {kJudgements, 2}, .values = std::move(maps)});
    std::vector<float> mirrored = file.memory->mirrored_eye.weight;
    mirrored.push_back(file.memory->mirrored_eye.bias);
    to.tensors.push_back({.name = kMirroredEye, .shape = {mirrored.size()}, .values = mirrored});
  }
  return model::write_safetensors(to);
}

Result<void> write_views_file(const std::filesystem::path& path, const ViewsFile& file) {
  MIEN_TRY_ASSIGN(const std::vector<std::byte> bytes, format_views_file(file));
  return write_file(path, bytes);
}

}  // namespace mien::headset
