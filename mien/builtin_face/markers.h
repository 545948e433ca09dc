#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/rotation.h"
#include "mien/face/face.h"

namespace mien::builtin_face {

/// Where on the face a marker is: the published study gives its errors for these two.
enum class MarkerRegion : std::uint8_t { eyes_nose, mouth };
/// "eyes_nose", "mouth".
[[nodiscard]] std::string_view region_name(MarkerRegion region);

/// One reflecting point that motion capture sees on the skin.
struct Marker {
  std::string name;  ///< Unique in the set: "lip_lower_R".
  MarkerRegion region = MarkerRegion::eyes_nose;
  Vec3 position_m = Vec3::Zero();  ///< On the built-in head, frame H; need not be exactly on the skin.
};

/// The markers of a performer in their order: marker i of the papers is element i - 1.
struct MarkerSet {
  std::string name;
  std::vector<Marker> markers;

  [[nodiscard]] std::vector<std::size_t> of(MarkerRegion region) const;
};

/// Reads `*.toml`, see rigs/markers.toml. Errors: malformed TOML, unknown keys, no markers, more than 256,
/// two of one name, an unknown region; out_of_range: positions that are not finite or metres away. `where`
/// names the source in messages.
[[nodiscard]] Result<MarkerSet> parse_markers(std::string_view toml, const std::string& where);
[[nodiscard]] Result<MarkerSet> read_markers(const std::filesystem::path& path);

/// The markers stuck onto one face. Frame H, metres; the eyes' turning moves no marker.
class PlacedMarkers {
 public:
  /// On the built-in face of any identity at the same spots of skin; on any other at the skin nearest to them
  /// after the 68 landmarks are aligned (rigid with scale). Errors: not_found (another face without
  /// landmarks). Cost: some milliseconds a marker.
  [[nodiscard]] static Result<PlacedMarkers> place(const face::Face& face, const MarkerSet& set);

  [[nodiscard]] std::size_t count() const { return neutral_m_.size(); }
  [[nodiscard]] const std::vector<Vec3>& neutral_m() const { return neutral_m_; }
  /// Displacement per unit weight. Shape: 3 count() x kShapeCount.
  [[nodiscard]] const Eigen::MatrixXd& shapes_m() const { return shapes_m_; }
  /// Where they are with these weights: x, y, z of marker 0, then of marker 1, ... Size 3 count().
  [[nodiscard]] Eigen::VectorXd at(const face::BlendshapeWeights& weights) const;

 private:
  std::vector<Vec3> neutral_m_;
  Eigen::MatrixXd shapes_m_;
};

}  // namespace mien::builtin_face
