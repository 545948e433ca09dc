#include "mien/builtin_face/markers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/excerpt.h"
#include "mien/core/files.h"
#include "mien/core/toml.h"
#include "mien/face/surface_point.h"

namespace mien::builtin_face {
namespace {

constexpr std::size_t kMaxBytes = 1U << 20U;
constexpr std::size_t kMaxMarkers = 256;
constexpr std::size_t kMaxNameBytes = 128;
/// Farther from the head's origin than this is a mistake of units.
constexpr double kMaxPositionM = 10.0;

Result<std::string> text(const toml::table& table, std::string_view key, const std::string& where) {
  const toml::node* node = table.get(key);
  const auto value = node == nullptr ? std::nullopt : node->value_exact<std::string>();
  const auto printable = [](unsigned char c) { return c >= 0x20 && c < 0x7F; };
  if (!value || value->empty() || value->size() > kMaxNameBytes || !std::ranges::all_of(*value, printable))
    return fail(ErrorCode::malformed, fmt::format("'{}' is not a short, printable text", key),
                place(where, table));
  return *value;
}

Result<Marker> read_marker(const toml::table& table, const std::string& where) {
  MIEN_TRY(only_keys(table, {"name", "region", "position_m"}, where));
  Marker marker;
  MIEN_TRY_ASSIGN(marker.name, text(table, "name", where));
  MIEN_TRY_ASSIGN(const std::string region, text(table, "region", where));
  if (region == region_name(MarkerRegion::mouth))
    marker.region = MarkerRegion::mouth;
  else if (region != region_name(MarkerRegion::eyes_nose))
    return fail(ErrorCode::malformed, fmt::format("region '{}' is unknown", excerpt(region)),
                place(where, table), "use \"eyes_nose\" or \"mouth\"");
  const toml::array* position = table["position_m"].as_array();
  if (position == nullptr || position->size() != 3)
    return fail(ErrorCode::malformed, "'position_m' is not a list of three numbers", place(where, table));
  for (std::size_t i = 0; i < 3; ++i) {
    const toml::node& node = (*position)[i];
    const auto number = node.is_number() ? node.value<double>() : std::nullopt;
    if (!number)
      return fail(ErrorCode::malformed, "'position_m' is not a list of three numbers", place(where, node));
    if (!std::isfinite(*number) || std::abs(*number) > kMaxPositionM)
      return fail(ErrorCode::out_of_range, "'position_m' is not a place on a head", place(where, node),
                  "give it in metres");
    marker.position_m[static_cast<Eigen::Index>(i)] = *number;
  }
  return marker;
}

}  // namespace

std::string_view region_name(MarkerRegion region) {
  return region == MarkerRegion::mouth ? "mouth" : "eyes_nose";
}

std::vector<std::size_t> MarkerSet::of(MarkerRegion region) const {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < markers.size(); ++i)
    if (markers[i].region == region) indices.push_back(i);
  return indices;
}

Result<MarkerSet> parse_markers(std::string_view toml_text, const std::string& where) {
  if (toml_text.size() > kMaxBytes) return fail(ErrorCode::out_of_range, "markers of more than 1 MiB", where);
  MIEN_TRY_ASSIGN(const toml::table root, parse_toml(toml_text, where));
  MIEN_TRY(only_keys(root, {"name", "marker"}, where));
  MarkerSet set;
  MIEN_TRY_ASSIGN(set.name, text(root, "name", where));
  const toml::node* list = root.get("marker");
  if (list == nullptr || !list->is_array_of_tables() || list->as_array()->empty())
    return fail(ErrorCode::malformed, "there are no markers", where, "add at least one [[marker]]");
  if (list->as_array()->size() > kMaxMarkers)
    return fail(ErrorCode::out_of_range, fmt::format("more than {} markers", kMaxMarkers), where);
  std::set<std::string, std::less<>> names;
  for (const toml::node& node : *list->as_array()) {
    MIEN_TRY_ASSIGN(Marker marker, read_marker(*node.as_table(), where));
    if (!names.insert(marker.name).second)
      return fail(ErrorCode::malformed, fmt::format("two markers are called '{}'", excerpt(marker.name)),
                  place(where, node), "give each its own name");
    set.markers.push_back(std::move(marker));
  }
  return set;
}

Result<MarkerSet> read_markers(const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(const std::string content, read_text(path, kMaxBytes));
  return parse_markers(content, path.string());
}

Result<PlacedMarkers> PlacedMarkers::place(const face::Face& face, const MarkerSet& set) {
  const bool is_builtin = face.origin == face::Origin::builtin;
  if (!is_builtin && !face.has_landmarks)
    return fail(ErrorCode::not_found, "the face has no landmarks, so the markers' places are unknown on it",
                face.name, "use the built-in face, an ICT-FaceKit folder, or a head with 68 landmarks");
  const face::Face& home = default_builtin();
  // All identities of the built-in head share their triangles, so a spot found on one is known on all.
  const face::Face& searched = is_builtin ? home : face;
  const Eigen::Affine3d carry = is_builtin ? Eigen::Affine3d::Identity() : face::align_landmarks(home, face);
  const std::vector<std::uint32_t> triangles = face::skin_triangles(searched);
  PlacedMarkers placed;
  placed.shapes_m_.resize(3 * static_cast<Eigen::Index>(set.markers.size()),
                          static_cast<Eigen::Index>(face::kShapeCount));
  for (std::size_t i = 0; i < set.markers.size(); ++i) {
    const face::SurfacePoint point =
        face::nearest_on_skin(searched, triangles, carry * set.markers[i].position_m);
    placed.neutral_m_.push_back(face::neutral_position(face, point));
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      placed.shapes_m_.block<3, 1>(3 * static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          face::displacement(face.shapes[k], point);
  }
  return placed;
}

Eigen::VectorXd PlacedMarkers::at(const face::BlendshapeWeights& weights) const {
  const Eigen::Map<const Eigen::VectorXf> w(weights.values.data(),
                                            static_cast<Eigen::Index>(face::kShapeCount));
  Eigen::VectorXd positions_m = shapes_m_ * w.cast<double>();
  for (std::size_t i = 0; i < neutral_m_.size(); ++i)
    positions_m.segment<3>(3 * static_cast<Eigen::Index>(i)) += neutral_m_[i];
  return positions_m;
}

}  // namespace mien::builtin_face
