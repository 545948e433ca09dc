#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/output_frame.h"
#include "mien/model/causal_network.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"
#include "mien/tracker/causal_tracker.h"
#include "mien/tracker/frame_writer.h"
#include "mien/tracker/jitter_filter.h"
#include "mien/tracker/model_input.h"

namespace mien::lab {

/// Many performers of one model and one rig on one core: frames that are due pass the network as a batch, so
/// that its weights are read once. Each result equals, to the bit, that of a tracker::CausalTracker of its
/// own. One thread.
class Crowd {
 public:
  /// Errors: as tracker::CausalTracker::create().
  [[nodiscard]] static Result<Crowd> create(const model::ModelFile& file,
                                            const std::vector<std::string>& face_sensor_names,
                                            std::size_t performers,
                                            model::Precision precision = tracker::kLivePrecision);

  /// The next frame of the performers `due` (indices below performers(), each once); features[i] and out[i]
  /// belong to due[i], sizes equal. No allocation.
  void step(std::span<const std::size_t> due, std::span<const model::FeatureFrame> features,
            std::span<face::OutputFrame> out);

  /// Resets one performer's state.
  void reset(std::size_t performer) {
    states_[performer].reset();
    jitter_filters_[performer].reset();
  }

  [[nodiscard]] std::size_t performers() const { return states_.size(); }

  /// Batch size: their states and activations fit into the second-level cache.
  static constexpr std::size_t kTogether = 48;

 private:
  Crowd(const model::ModelFile& file, model::CausalNetwork network,
        const std::vector<std::string>& face_sensor_names, std::size_t performers);
  void step_together(std::span<const std::size_t> due, std::span<const model::FeatureFrame> features,
                     std::span<face::OutputFrame> out);

  model::CausalNetwork network_;
  tracker::FrameWriter writer_;
  std::vector<model::CausalNetwork::State> states_;
  std::vector<tracker::JitterFilter> jitter_filters_;
  // Of the batch in progress:
  model::CausalNetwork::Workspace workspace_;
  std::vector<tracker::ModelInput> inputs_;
  std::vector<model::CausalNetwork::State*> together_;
  std::vector<float> conditions_, answers_;
};

}  // namespace mien::lab
