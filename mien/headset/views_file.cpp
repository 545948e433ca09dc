#include "mien/headset/views_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "mien/core/excerpt.h"
#include "mien/core/files.h"
#include "mien/headset/answer.h"
#include "mien/model/network_parts.h"

namespace mien::headset {
namespace {

constexpr std::string_view kFormat = "mien-headset";
constexpr std::string_view kVersion = "1";
constexpr const char* kMean = "mean_answer";

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
  return {};
}

}  // namespace

Result<ViewsFile> parse_views_file(std::span<const std::byte> bytes, std::string_view where_view) {
  const std::string where(where_view);
  MIEN_TRY_ASSIGN(model::TensorFile from, model::parse_safetensors(bytes, where));
  auto& metadata = from.metadata;
  if (metadata["format"] != kFormat)
    return fail(ErrorCode::unsupported, "this safetensors file is not a model of a headset's pictures",
                where);
  if (metadata["version"] != kVersion)
    return fail(ErrorCode::unsupported,
                fmt::format("the model's version is \"{}\", not {}", excerpt(metadata["version"]), kVersion),
                where, "update the program");
  ViewsFile file;
  MIEN_TRY_ASSIGN(file.architecture, model::parse_architecture(metadata["architecture"], where));
  file.rig = metadata["rig"];
  file.recipe = metadata["recipe"];
  file.results = metadata["results"];
  MIEN_TRY_ASSIGN(file.network, model::take_network(file.architecture, from, where));
  const auto mean = std::ranges::find(from.tensors, kMean, &model::Tensor::name);
  if (mean == from.tensors.end())
    return fail(ErrorCode::mismatch, fmt::format("tensor {} is missing", kMean), where);
  file.mean_answer = std::move(mean->values);
  from.tensors.erase(mean);
  if (!from.tensors.empty())
    return fail(ErrorCode::mismatch, fmt::format("tensor {:?} belongs to nothing", from.tensors[0].name),
                where);
  MIEN_TRY(check_file(file, where));
  return file;
}

Result<ViewsFile> read_views_file(const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(const std::vector<std::byte> bytes, read_file(path));
  return parse_views_file(bytes, path.string());
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
  return model::write_safetensors(to);
}

Result<void> write_views_file(const std::filesystem::path& path, const ViewsFile& file) {
  MIEN_TRY_ASSIGN(const std::vector<std::byte> bytes, format_views_file(file));
  return write_file(path, bytes);
}

}  // namespace mien::headset
