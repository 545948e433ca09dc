#pragma once

#include <array>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/output_frame.h"
#include "mien/model/causal_network.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"
#include "mien/tracker/frame_model.h"
#include "mien/tracker/frame_writer.h"
#include "mien/tracker/jitter_filter.h"
#include "mien/tracker/model_input.h"

namespace mien::tracker {

/// Precision of the live network's products: half of fp32's time, and no error moves by more than 0.2 %
/// (docs/experiments/engine.md).
inline constexpr model::Precision kLivePrecision = model::Precision::bf16;

/// Causal frame model: one frame of features in, one output frame out, by the model file's causal network.
/// One performance, one thread. Method: docs/method/live_model.md. A moved-from one must not be used.
class CausalTracker final : public FrameModel {
 public:
  /// `face_sensor_names`: names of the features' entries (sensor::Rig::face_sensor_names()). Sensors of the
  /// model that the rig lacks are missing. Errors: mismatch (a model that is not causal or whose outputs are
  /// not the 53 shapes, no sensor in common), and the network's.
  [[nodiscard]] static Result<CausalTracker> create(model::ModelFile file,
                                                    const std::vector<std::string>& face_sensor_names,
                                                    model::Precision precision = kLivePrecision);

  /// The next frame, 1/60 s after the last; fields as FrameWriter fills them, weights as corrected for the
  /// wearer, through JitterFilter. No allocation; about 25 us with the default model. The same frames after a
  /// reset give the same bits on one CPU family and build.
  void step(const model::FeatureFrame& features, face::OutputFrame& out) override;

  /// Resets the state: as after create().
  void reset() override;

  [[nodiscard]] const Explained* explained() const override { return &explained_; }
  /// None either where answers are corrected: a correction belongs to the skin that it was learnt with.
  [[nodiscard]] const model::ModelFile* personal() const override {
    return file_.skin && !corrected_ ? &file_ : nullptr;
  }
  void use_wearer(const std::vector<float>& slopes) override;
  [[nodiscard]] Result<void> check_correction(const model::Correction& correction) const override;
  void use_correction(const model::Correction* correction) override;

  [[nodiscard]] const model::ModelFile& file() const { return file_; }
  [[nodiscard]] const model::CausalNetwork& network() const { return network_; }

 private:
  CausalTracker(model::ModelFile file, model::CausalNetwork network,
                const std::vector<std::string>& face_sensor_names);

  model::ModelFile file_;
  model::CausalNetwork network_;
  model::CausalNetwork::State state_;
  ModelInput input_;
  std::vector<float> condition_;
  std::array<float, face::kShapeCount> answer_{};
  FrameWriter writer_;
  JitterFilter jitter_filter_;
  bool corrected_ = false;
  Explained explained_{};
};

}  // namespace mien::tracker
