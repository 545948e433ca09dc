#include "mien/tracker/frame_writer.h"

#include <cmath>

namespace mien::tracker {
namespace {

/// Weight of each sensor for each shape: the norm of the ridge's coefficients for its rotation (the condition
/// is normalised, so they are comparable). Without a ridge all sensors weigh alike.
std::vector<float> sensor_shares(const model::ModelFile& file) {
  const std::size_t sensors = file.features.sensors.size();
  std::vector<float> shares(sensors * face::kShapeCount, 1.0F);
  const model::RidgeBaseline* ridge = file.ridge_for("device");
  if (ridge == nullptr && !file.ridge.empty()) ridge = &file.ridge.front();
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    float sum = 0;
    for (std::size_t s = 0; s < sensors; ++s) {
      float& share = shares[s * face::kShapeCount + k];
      if (ridge != nullptr) {
        const float* row = ridge->matrix.data() + k * (ridge->condition + 1) + 7 * s;
        share = std::hypot(std::hypot(row[3], row[4]), std::hypot(row[5], row[6]));
      }
      sum += share;
    }
    for (std::size_t s = 0; s < sensors; ++s) {
      float& share = shares[s * face::kShapeCount + k];
      share = sum > 0 ? share / sum : 1 / static_cast<float>(sensors);
    }
  }
  return shares;
}

}  // namespace

FrameWriter::FrameWriter(const model::ModelFile& file)
    : shares_(sensor_shares(file)), confidence_(file.confidence) {}

Coverage FrameWriter::coverage(const ModelInput& input) const {
  Coverage out{};
  if (input.present_count() == input.sensor_count()) {
    out.fill(1);  // The sum of all shares may differ from 1 by rounding.
    return out;
  }
  for (std::size_t s = 0; s < input.sensor_count(); ++s)
    if (input.present(s))
      for (std::size_t k = 0; k < face::kShapeCount; ++k) out[k] += shares_[s * face::kShapeCount + k];
  return out;
}

Explained FrameWriter::write(const model::FeatureFrame& features, const ModelInput& input,
                             face::OutputFrame& out) const {
  const face::BlendshapeWeights weights = out.weights;
  out = face::OutputFrame{};
  out.time = features.time;
  out.weights = weights;
  if (features.has_head) {
    out.head = features.head;
    out.head_confidence = 1;
    out.head_provenance = face::Provenance::measured;
  }
  return confidence_.write(coverage(input), out);
}

}  // namespace mien::tracker
