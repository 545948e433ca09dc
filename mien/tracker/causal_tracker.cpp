#include "mien/tracker/causal_tracker.h"

#include <algorithm>
#include <utility>

#include "mien/model/network_correction.h"
#include "mien/model/schedule.h"

namespace mien::tracker {

CausalTracker::CausalTracker(model::ModelFile file, model::CausalNetwork network,
                             const std::vector<std::string>& face_sensor_names)
    : file_(std::move(file)),
      network_(std::move(network)),
      state_(network_),
      input_(file_, face_sensor_names),
      condition_(file_.features.width()),
      writer_(file_) {
  use_correction(nullptr);
}

void CausalTracker::use_correction(const model::Correction* correction) {
  if (correction == nullptr && file_.correction) correction = &*file_.correction;
  corrected_ = correction != nullptr;
  network_.correct(correction);
}

Result<void> CausalTracker::check_correction(const model::Correction& correction) const {
  return model::check_correction(correction, file_.architecture, file_.network, "session");
}

void CausalTracker::use_wearer(const std::vector<float>& slopes) {
  model::Skin skin = *file_.skin;
  if (!slopes.empty()) skin.wearer = slopes;
  input_.use(skin, file_.mean_pose);
}

void CausalTracker::reset() {
  state_.reset();
  jitter_filter_.reset();
}

Result<CausalTracker> CausalTracker::create(model::ModelFile file,
                                            const std::vector<std::string>& face_sensor_names,
                                            model::Precision precision) {
  if (!std::ranges::equal(file.shapes, face::kShapeNames))
    return fail(ErrorCode::mismatch, "the model's outputs are not the 53 ICT shapes in their order",
                "model file", "train it with this version of Mien");
  MIEN_TRY_ASSIGN(model::CausalNetwork network,
                  model::CausalNetwork::create(file.architecture, file.network, precision));
  CausalTracker tracker(std::move(file), std::move(network), face_sensor_names);
  if (tracker.input_.empty())
    return fail(ErrorCode::mismatch, "the rig has none of the model's sensors", "model file",
                "use a model that was trained for this rig");
  return tracker;
}

void CausalTracker::step(const model::FeatureFrame& features, face::OutputFrame& out) {
  input_.encode(features, condition_);
  network_.step(condition_, state_, answer_);
  std::ranges::transform(answer_, out.weights.values.begin(), model::from_network);
  jitter_filter_.apply(out.weights);
  explained_ = writer_.write(features, input_, out);
}

}  // namespace mien::tracker
