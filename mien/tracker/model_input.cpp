#include "mien/tracker/model_input.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "mien/sensor/sensor_places.h"

namespace mien::tracker {
namespace {

bool finite(const model::SensorFeature& sensor) {
  return sensor.accel_m_s2.allFinite() &&
         std::ranges::all_of(sensor.rotation, [](float v) { return std::isfinite(v); });
}

}  // namespace

ModelInput::ModelInput(const model::ModelFile& file, const std::vector<std::string>& rig_sensors)
    : layout_(file.features),
      normalisation_(file.normalisation),
      places_(sensor::sensor_places(layout_.sensors, rig_sensors)) {
  values_.resize(7 * places_.size());
  present_.resize(2 * places_.size());
  if (file.skin) use(*file.skin, file.mean_pose);
}

void ModelInput::use(const model::Skin& skin, std::span<const float> mean_pose) {
  skin_.reset();
  if (!skin.wearer.empty()) skin_.emplace(skin, mean_pose);
}

bool ModelInput::empty() const {
  return sensor::none_placed(places_);
}

void ModelInput::encode(const model::FeatureFrame& frame, std::span<float> out) {
  const std::size_t n = places_.size();
  for (std::size_t s = 0; s < n; ++s) {
    assert(places_[s] < static_cast<std::ptrdiff_t>(frame.sensors.size()));
    const model::SensorFeature* reading =
        places_[s] < 0 ? nullptr : &frame.sensors[static_cast<std::size_t>(places_[s])];
    if (reading != nullptr && !finite(*reading)) reading = nullptr;
    present_[s] = reading != nullptr && reading->has_rotation ? 1 : 0;
    present_[n + s] = reading != nullptr && reading->has_accel ? 1 : 0;
    if (reading == nullptr) continue;
    std::copy_n(reading->accel_m_s2.data(), 3, values_.begin() + static_cast<std::ptrdiff_t>(7 * s));
    std::ranges::copy(reading->rotation, values_.begin() + static_cast<std::ptrdiff_t>(7 * s + 3));
  }
  if (skin_) skin_->apply(values_, present_);
  model::encode_values(layout_, normalisation_, values_, present_, out);
}

std::size_t ModelInput::present_count() const {
  return static_cast<std::size_t>(
      std::count(present_.begin(), present_.begin() + static_cast<std::ptrdiff_t>(places_.size()), 1));
}

std::optional<RidgeSolver> RidgeSolver::create(const model::ModelFile& file,
                                               const std::vector<std::string>& rig_sensors,
                                               std::string_view profile) {
  const model::RidgeBaseline* baseline = file.ridge_for(profile);
  if (baseline == nullptr) return std::nullopt;
  return RidgeSolver(file, rig_sensors, *baseline);
}

face::BlendshapeWeights RidgeSolver::solve(const model::FeatureFrame& features) {
  face::BlendshapeWeights out;
  input_.encode(features, condition_);
  baseline_.predict(condition_, out.values);
  return out;
}

std::vector<face::BlendshapeWeights> solve_ridge(const model::ModelFile& file,
                                                 std::span<const model::FeatureFrame> features,
                                                 const std::vector<std::string>& rig_sensors,
                                                 std::string_view profile) {
  std::vector<face::BlendshapeWeights> out;
  auto solver = RidgeSolver::create(file, rig_sensors, profile);
  if (!solver) return out;
  out.reserve(features.size());
  for (const model::FeatureFrame& frame : features) out.push_back(solver->solve(frame));
  return out;
}

}  // namespace mien::tracker
