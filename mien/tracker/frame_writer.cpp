#include "mien/tracker/frame_writer.h"

#include <algorithm>
#include <cmath>

#include "mien/model/schedule.h"
#include "mien/tracker/provenance.h"

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

FrameWriter::FrameWriter(const model::ModelFile& file) : shares_(sensor_shares(file)) {}

void FrameWriter::write(const model::FeatureFrame& features, const ModelInput& input,
                        std::span<const float> answer, face::OutputFrame& out) const {
  out = face::OutputFrame{};
  out.time = features.time;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) out.weights[k] = model::from_network(answer[k]);
  for (std::size_t s = 0; s < input.sensor_count(); ++s)
    if (input.present(s))
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        out.confidence[k] += shares_[s * face::kShapeCount + k];
  const std::size_t present = input.present_count();
  // The sum of all shares may differ from 1 by rounding.
  if (present == input.sensor_count()) out.confidence.fill(1);
  for (float& confidence : out.confidence) confidence = std::min(confidence, 1.0F);
  set_provenance(present > 0, Gaze::unseen, out);
  if (features.has_head) {
    out.head = features.head;
    out.head_confidence = 1;
    out.head_provenance = face::Provenance::measured;
  }
}

}  // namespace mien::tracker
