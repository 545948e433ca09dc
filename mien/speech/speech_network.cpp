#include "mien/speech/speech_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "mien/core/excerpt.h"
#include "mien/core/files.h"
#include "mien/model/confidence_file.h"
#include "mien/model/network_parts.h"
#include "mien/model/schedule.h"

namespace mien::speech {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kFormat = "mien-speech";
constexpr std::string_view kVersion = "1";
constexpr std::size_t kMostLookAhead = 1;
/// A band's mean lies within these, natural logarithm, and so does its scale.
constexpr float kFarthest = 100;

Result<void> check_file(const SpeechNetworkFile& file, const std::string& where) {
  const auto differ = [&](std::string what) { return fail(ErrorCode::mismatch, std::move(what), where); };
  if (const auto ok = model::check(file.architecture); !ok)
    return fail(ok.error().code, ok.error().what, where);
  if (file.architecture.kind != model::NetworkKind::causal)
    return differ("the network waits for a window of frames, which speech has no use for");
  if (file.architecture.condition != kConditionOfBlock)
    return differ(fmt::format("it reads {} numbers of a block, not {}", file.architecture.condition,
                              kConditionOfBlock));
  if (file.shapes.empty() || file.architecture.outputs != file.shapes.size() + 2)
    return differ(fmt::format("{} shapes, closure and voice are not told by {} outputs", file.shapes.size(),
                              file.architecture.outputs));
  if (std::set<std::string>(file.shapes.begin(), file.shapes.end()).size() != file.shapes.size())
    return differ("two of its shapes have one name");
  for (const std::string& name : file.shapes)
    if (face::shape_index(name) == face::kShapeCount)
      return differ(fmt::format("no shape is called '{}'", excerpt(name)));
  if (file.look_ahead > kMostLookAhead)
    return fail(ErrorCode::out_of_range, fmt::format("it looks {} blocks ahead", file.look_ahead), where);
  for (std::size_t b = 0; b < kMelBands; ++b)
    if (!(std::abs(file.mean[b]) <= kFarthest && file.scale[b] > 0 && file.scale[b] <= kFarthest))
      return fail(ErrorCode::out_of_range, fmt::format("the normalisation of band {} is beyond its range", b),
                  where);
  if (const auto ok = model::check_tensors(file.architecture, file.network); !ok)
    return differ(ok.error().what);
  if (file.confidence) return model::check(*file.confidence, face::kShapeCount, where);
  return {};
}

Result<SpeechNetworkFile> speech_network_of(model::TensorFile from, const std::string& where) {
  auto& metadata = from.metadata;
  SpeechNetworkFile file;
  MIEN_TRY_ASSIGN(file.architecture,
                  model::architecture_of(from, kFormat, kVersion, "a model of speech", where));
  try {
    file.shapes = Json::parse(metadata["shapes"]).get<std::vector<std::string>>();
    const Json bands = Json::parse(metadata["bands"]);
    const auto mean = bands.at("mean").get<std::vector<float>>(),
               scale = bands.at("scale").get<std::vector<float>>();
    if (mean.size() != kMelBands || scale.size() != kMelBands)
      return fail(ErrorCode::mismatch, fmt::format("its normalisation is not of {} bands", kMelBands), where);
    std::ranges::copy(mean, file.mean.begin());
    std::ranges::copy(scale, file.scale.begin());
    const Json look_ahead = Json::parse(metadata["look_ahead"]);
    if (!look_ahead.is_number_unsigned())
      return fail(ErrorCode::malformed, "what it looks ahead is no count of blocks", where);
    file.look_ahead = look_ahead.get<std::size_t>();
  } catch (const Json::exception& error) {
    return model::wrong_description(error, where);
  }
  file.recipe = metadata["recipe"];
  file.results = metadata["results"];
  MIEN_TRY_ASSIGN(file.network, model::take_network(file.architecture, from, where));
  MIEN_TRY_ASSIGN(file.confidence, model::take_confidence(from, where));
  MIEN_TRY(model::check_all_taken(from, where));
  MIEN_TRY(check_file(file, where));
  return file;
}

}  // namespace

Result<SpeechNetworkFile> parse_speech_network(std::span<const std::byte> bytes, std::string_view where) {
  MIEN_TRY_ASSIGN(model::TensorFile from, model::parse_safetensors(bytes, where));
  return speech_network_of(std::move(from), std::string(where));
}

Result<SpeechNetworkFile> read_speech_network(const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(model::TensorFile from, model::read_safetensors(path));
  return speech_network_of(std::move(from), path.string());
}

Result<std::vector<std::byte>> format_speech_network(const SpeechNetworkFile& file) {
  MIEN_TRY(check_file(file, "model"));
  model::TensorFile to;
  to.metadata = {
      {"format", std::string(kFormat)},
      {"version", std::string(kVersion)},
      {"architecture", model::format_architecture(file.architecture)},
      {"shapes", Json(file.shapes).dump()},
      {"bands", Json{{"mean", file.mean}, {"scale", file.scale}}.dump()},
      {"look_ahead", std::to_string(file.look_ahead)},
      {"recipe", file.recipe},
      {"results", file.results},
  };
  model::add_network(file.network, to);
  if (file.confidence) model::add_confidence(*file.confidence, face::kShapeCount, to);
  return model::write_safetensors(to);
}

Result<void> write_speech_network(const std::filesystem::path& path, const SpeechNetworkFile& file) {
  MIEN_TRY_ASSIGN(const std::vector<std::byte> bytes, format_speech_network(file));
  return write_file(path, bytes);
}

void encode_mel(const SpeechNetworkFile& file, std::span<const MelFrame, kFramesPerBlock> frames,
                std::span<float> out) {
  std::size_t at = 0;
  for (const MelFrame& frame : frames)
    for (std::size_t b = 0; b < kMelBands; ++b) out[at++] = (frame[b] - file.mean[b]) / file.scale[b];
}

Result<SpeechNetwork> SpeechNetwork::create(SpeechNetworkFile file) {
  MIEN_TRY_ASSIGN(model::CausalNetwork network,
                  model::CausalNetwork::create(file.architecture, file.network));
  return SpeechNetwork(std::move(file), std::move(network));
}

SpeechNetwork::SpeechNetwork(SpeechNetworkFile file, model::CausalNetwork network)
    : file_(std::move(file)),
      network_(std::move(network)),
      state_(network_),
      answer_(file_.architecture.outputs) {
  for (const std::string& name : file_.shapes) places_.push_back(face::shape_index(name));
}

void SpeechNetwork::step(std::span<const MelFrame, kFramesPerBlock> frames, HeardMouth& out) {
  encode_mel(file_, frames, condition_);
  network_.step(condition_, state_, answer_);
  out.weights = {};
  for (std::size_t i = 0; i < places_.size(); ++i) out.weights[places_[i]] = model::from_network(answer_[i]);
  out.closure = model::from_network(answer_[file_.closure_output()]);
  out.voice = model::from_network(answer_[file_.voice_output()]);
}

}  // namespace mien::speech
