#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/eyewear/marker_regressor.h"
#include "mien/model/causal_network.h"
#include "mien/model/safetensors.h"

namespace mien::eyewear {

/// Markers on the face whose weights a model answers with. Metres, frame H; double precision, so that a model
/// answers with the same bits whatever becomes of the face that it was trained on.
struct MarkedShapes {
  Eigen::VectorXd neutral_m;  ///< x, y, z of the first marker, then of the next.
  Eigen::MatrixXd shapes_m;   ///< Displacement per unit weight. Shape: neutral_m.size() x kShapeCount.
  bool operator==(const MarkedShapes&) const = default;
};

/// A trained regressor of markers with its provenance: one safetensors file (docs/method/eyewear.md). A
/// causal network: condition of two values a sensor, the feature (0 where missing) and its presence (1 or 0);
/// outputs of three a marker, displacement / scale_m.
struct MarkerNetworkFile {
  model::Architecture architecture;
  std::vector<std::string> sensors;  ///< Names, in the condition's order.
  std::vector<std::string> markers;  ///< Names, in the outputs' order.
  double scale_m = 0.01;             ///< Displacement, m, of an output of 1; above 0.
  std::string rig;                   ///< Text of the rig file it was trained for; may be empty.
  std::string recipe;                ///< Text of the training recipe (TOML).
  std::string results;               ///< Measurements of the training, JSON; may be empty.
  std::vector<model::Tensor> network;
  /// Its markers on the face that it was trained for. None in older files.
  std::optional<MarkedShapes> face;
  /// What the weights are worth that follow from its markers. None: nobody measured it, so nothing is called
  /// measured and no confidence is claimed.
  std::optional<model::ConfidenceTable> confidence;
};

/// Errors: as parse_safetensors; malformed, out_of_range, mismatch (sizes, names twice); unsupported (another
/// file's format, a newer version).
[[nodiscard]] Result<MarkerNetworkFile> parse_marker_network(std::span<const std::byte> bytes,
                                                             std::string_view where);
[[nodiscard]] Result<MarkerNetworkFile> read_marker_network(const std::filesystem::path& path);
/// Inverse of parse_marker_network, with the same errors.
[[nodiscard]] Result<std::vector<std::byte>> format_marker_network(const MarkerNetworkFile& file);
/// Writes the file atomically. Errors: as format_marker_network, io.
[[nodiscard]] Result<void> write_marker_network(const std::filesystem::path& path,
                                                const MarkerNetworkFile& file);

/// The condition of one frame: out.size() == 2 light.values.size(). No allocation.
void encode_light(const LightFrame& light, std::span<float> out);

/// MarkerRegressor by a MarkerNetworkFile, for a rig's sensors.
class NetworkRegressor final : public MarkerRegressor {
 public:
  /// `sensors`: names of the frames' entries; sensors of the network that the rig lacks are missing. Errors:
  /// mismatch (no sensor in common), the network's.
  [[nodiscard]] static Result<std::unique_ptr<NetworkRegressor>> create(
      MarkerNetworkFile file, const std::vector<std::string>& sensors);

  /// Cost: the network's flop_count().
  void step(const LightFrame& light, Eigen::VectorXd& displacement_m) override;
  void reset() override { state_.reset(); }
  [[nodiscard]] std::size_t marker_count() const override { return file_.markers.size(); }
  [[nodiscard]] const model::ConfidenceTable* confidence() const override {
    return file_.confidence ? &*file_.confidence : nullptr;
  }
  [[nodiscard]] float coverage() const override { return coverage_; }
  [[nodiscard]] const MarkerNetworkFile& file() const { return file_; }

 private:
  NetworkRegressor(MarkerNetworkFile file, model::CausalNetwork network, std::vector<std::ptrdiff_t> places);

  MarkerNetworkFile file_;
  model::CausalNetwork network_;
  model::CausalNetwork::State state_;
  std::vector<std::ptrdiff_t> places_;  // For each of the network's sensors its index in the frames, or -1.
  LightFrame light_;                    // In the network's order.
  std::vector<float> condition_;
  std::vector<float> answer_;
  float coverage_ = 0;
};

}  // namespace mien::eyewear
