#include "mien/eyewear/marker_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "mien/core/files.h"
#include "mien/face/profile.h"
#include "mien/model/confidence_file.h"
#include "mien/model/network_parts.h"
#include "mien/sensor/sensor_places.h"

namespace mien::eyewear {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kFormat = "mien-eyewear";
constexpr std::string_view kVersion = "1";

bool unique(const std::vector<std::string>& names) {
  return std::set<std::string>(names.begin(), names.end()).size() == names.size();
}

Result<void> check_network_file(const MarkerNetworkFile& file, const std::string& where) {
  const auto differ = [&](std::string what) { return fail(ErrorCode::mismatch, std::move(what), where); };
  if (const auto ok = model::check(file.architecture); !ok)
    return fail(ok.error().code, ok.error().what, where);
  if (file.architecture.kind != model::NetworkKind::causal)
    return differ("the network waits for a window of frames, which eyewear has no use for");
  if (file.sensors.empty() || file.architecture.condition != 2 * file.sensors.size())
    return differ(fmt::format("{} sensors do not give {} numbers a frame", file.sensors.size(),
                              file.architecture.condition));
  if (file.markers.empty() || file.architecture.outputs != 3 * file.markers.size())
    return differ(
        fmt::format("{} markers are not told by {} outputs", file.markers.size(), file.architecture.outputs));
  if (!unique(file.sensors) || !unique(file.markers)) return differ("two sensors or markers have one name");
  if (!(file.scale_m > 0 && file.scale_m <= 1))
    return fail(ErrorCode::out_of_range, "the scale of its outputs is not above 0 and at most a metre",
                where);
  if (const auto ok = model::check_tensors(file.architecture, file.network); !ok)
    return differ(ok.error().what);
  if (file.face) {
    const MarkedShapes& face = *file.face;
    if (face.neutral_m.size() != static_cast<Eigen::Index>(file.architecture.outputs) ||
        face.shapes_m.rows() != face.neutral_m.size() ||
        face.shapes_m.cols() != static_cast<Eigen::Index>(face::kShapeCount))
      return differ("its markers are not placed on its face");
    constexpr double kHeadM = 1;
    const auto on_a_head = [](const auto& m) { return m.allFinite() && m.cwiseAbs().maxCoeff() <= kHeadM; };
    if (!on_a_head(face.neutral_m) || !on_a_head(face.shapes_m))
      return fail(ErrorCode::out_of_range, "a marker's place or displacement is not within a metre", where);
  }
  if (file.confidence) MIEN_TRY(model::check(*file.confidence, face::kShapeCount, where));
  return {};
}

/// Numbers are written so that they are read back to the bit.
std::string format_face(const MarkedShapes& face) {
  Json shapes = Json::object();
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const Eigen::VectorXd moved = face.shapes_m.col(static_cast<Eigen::Index>(k));
    if (!moved.isZero(0)) shapes[std::string(face::kShapeNames[k])] = std::vector(moved.begin(), moved.end());
  }
  return Json{{"neutral_m", std::vector(face.neutral_m.begin(), face.neutral_m.end())}, {"shapes_m", shapes}}
      .dump();
}

/// Throws Json::exception.
MarkedShapes parse_face(const std::string& text) {
  const Json face = Json::parse(text);
  const auto neutral = face.at("neutral_m").get<std::vector<double>>();
  MarkedShapes out;
  out.neutral_m =
      Eigen::Map<const Eigen::VectorXd>(neutral.data(), static_cast<Eigen::Index>(neutral.size()));
  out.shapes_m.setZero(out.neutral_m.size(), static_cast<Eigen::Index>(face::kShapeCount));
  const auto& shapes = face.at("shapes_m").get_ref<const Json::object_t&>();
  std::size_t known = 0;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const auto found = shapes.find(std::string(face::kShapeNames[k]));
    if (found == shapes.end()) continue;
    const auto moved = found->second.get<std::vector<double>>();
    if (moved.size() != neutral.size()) return MarkedShapes{};  // Refused by the check.
    ++known;
    out.shapes_m.col(static_cast<Eigen::Index>(k)) =
        Eigen::Map<const Eigen::VectorXd>(moved.data(), static_cast<Eigen::Index>(moved.size()));
  }
  if (known != shapes.size()) return MarkedShapes{};  // A shape that is none.
  return out;
}

Result<MarkerNetworkFile> marker_network_of(model::TensorFile from, const std::string& where) {
  auto& metadata = from.metadata;
  MarkerNetworkFile file;
  MIEN_TRY_ASSIGN(file.architecture,
                  model::architecture_of(from, kFormat, kVersion, "a model of smart eyewear", where));
  try {
    const Json markers = Json::parse(metadata["markers"]);
    file.markers = markers.at("names").get<std::vector<std::string>>();
    file.scale_m = markers.at("scale_m").get<double>();
    file.sensors = Json::parse(metadata["sensors"]).get<std::vector<std::string>>();
    if (metadata.contains("face")) file.face = parse_face(metadata["face"]);
  } catch (const Json::exception& error) {
    return model::wrong_description(error, where);
  }
  file.rig = metadata["rig"];
  file.recipe = metadata["recipe"];
  file.results = metadata["results"];
  MIEN_TRY_ASSIGN(file.confidence, model::take_confidence(from, where));
  MIEN_TRY_ASSIGN(file.network, model::take_network(file.architecture, from, where));
  MIEN_TRY(model::check_all_taken(from, where));
  MIEN_TRY(check_network_file(file, where));
  return file;
}

}  // namespace

Result<MarkerNetworkFile> parse_marker_network(std::span<const std::byte> bytes, std::string_view where) {
  MIEN_TRY_ASSIGN(model::TensorFile from, model::parse_safetensors(bytes, where));
  return marker_network_of(std::move(from), std::string(where));
}

Result<MarkerNetworkFile> read_marker_network(const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(model::TensorFile from, model::read_safetensors(path));
  return marker_network_of(std::move(from), path.string());
}

Result<std::vector<std::byte>> format_marker_network(const MarkerNetworkFile& file) {
  MIEN_TRY(check_network_file(file, "model"));
  model::TensorFile to;
  to.metadata = {
      {"format", std::string(kFormat)},
      {"version", std::string(kVersion)},
      {"architecture", model::format_architecture(file.architecture)},
      {"sensors", Json(file.sensors).dump()},
      {"markers", Json{{"names", file.markers}, {"scale_m", file.scale_m}}.dump()},
      {"rig", file.rig},
      {"recipe", file.recipe},
      {"results", file.results},
  };
  if (file.face) to.metadata["face"] = format_face(*file.face);
  model::add_network(file.network, to);
  if (file.confidence) model::add_confidence(*file.confidence, face::kShapeCount, to);
  return model::write_safetensors(to);
}

Result<void> write_marker_network(const std::filesystem::path& path, const MarkerNetworkFile& file) {
  MIEN_TRY_ASSIGN(const std::vector<std::byte> bytes, format_marker_network(file));
  return write_file(path, bytes);
}

void encode_light(const LightFrame& light, std::span<float> out) {
  for (std::size_t s = 0; s < light.values.size(); ++s) {
    const bool there = light.present[s] != 0 && std::isfinite(light.values[s]);
    out[2 * s] = there ? light.values[s] : 0.0F;
    out[2 * s + 1] = there ? 1.0F : 0.0F;
  }
}

Result<std::unique_ptr<NetworkRegressor>> NetworkRegressor::create(MarkerNetworkFile file,
                                                                   const std::vector<std::string>& sensors) {
  MIEN_TRY_ASSIGN(model::CausalNetwork network,
                  model::CausalNetwork::create(file.architecture, file.network));
  std::vector<std::ptrdiff_t> places = sensor::sensor_places(file.sensors, sensors);
  if (sensor::none_placed(places))
    return fail(ErrorCode::mismatch, "the model knows none of the rig's sensors", "model",
                "use a model that was trained for this rig");
  return std::unique_ptr<NetworkRegressor>(
      new NetworkRegressor(std::move(file), std::move(network), std::move(places)));
}

NetworkRegressor::NetworkRegressor(MarkerNetworkFile file, model::CausalNetwork network,
                                   std::vector<std::ptrdiff_t> places)
    : file_(std::move(file)),
      network_(std::move(network)),
      state_(network_),
      places_(std::move(places)),
      condition_(2 * places_.size()),
      answer_(3 * file_.markers.size()) {
  light_.values.resize(places_.size());
  light_.present.resize(places_.size());
}

void NetworkRegressor::step(const LightFrame& light, Eigen::VectorXd& displacement_m) {
  for (std::size_t s = 0; s < places_.size(); ++s) {
    const std::ptrdiff_t place = places_[s];
    const bool there = place >= 0 && light.present[static_cast<std::size_t>(place)] != 0;
    light_.present[s] = there ? 1 : 0;
    light_.values[s] = there ? light.values[static_cast<std::size_t>(place)] : 0.0F;
  }
  coverage_ = static_cast<float>(std::ranges::count(light_.present, std::uint8_t{1})) /
              static_cast<float>(light_.present.size());
  encode_light(light_, condition_);
  network_.step(condition_, state_, answer_);
  displacement_m = file_.scale_m * Eigen::Map<const Eigen::VectorXf>(
                                       answer_.data(), static_cast<Eigen::Index>(answer_.size()))
                                       .cast<double>();
}

}  // namespace mien::eyewear
