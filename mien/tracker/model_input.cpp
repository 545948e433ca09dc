#include "mien/tracker/model_input.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace mien::tracker {
namespace {

bool finite(const model::SensorFeature& sensor) {
  return sensor.accel_m_s2.allFinite() &&
         std::ranges::all_of(sensor.rotation, [](float v) { return std::isfinite(v); });
}

}  // namespace

ModelInput::ModelInput(const model::ModelFile& file, const std::vector<std::string>& rig_sensors)
    : layout_(file.features), normalisation_(file.normalisation) {
  for (const std::string& name : layout_.sensors) {
    const auto found = std::ranges::find(rig_sensors, name);
    places_.push_back(found == rig_sensors.end() ? -1 : found - rig_sensors.begin());
  }
  frame_.sensors.resize(places_.size());
}

bool ModelInput::empty() const {
  return std::ranges::all_of(places_, [](std::ptrdiff_t place) { return place < 0; });
}

void ModelInput::encode(const model::FeatureFrame& frame, std::span<float> out) {
  for (std::size_t s = 0; s < places_.size(); ++s) {
    assert(places_[s] < static_cast<std::ptrdiff_t>(frame.sensors.size()));
    const bool there = places_[s] >= 0 && finite(frame.sensors[static_cast<std::size_t>(places_[s])]);
    frame_.sensors[s] = there ? frame.sensors[static_cast<std::size_t>(places_[s])] : model::SensorFeature{};
  }
  model::encode_features(layout_, normalisation_, frame_, out);
}

std::size_t ModelInput::felt_count() const {
  return static_cast<std::size_t>(std::ranges::count_if(frame_.sensors, &model::SensorFeature::has_rotation));
}

std::vector<face::BlendshapeWeights> solve_ridge(const model::ModelFile& file,
                                                 std::span<const model::FeatureFrame> features,
                                                 const std::vector<std::string>& rig_sensors,
                                                 std::string_view profile) {
  const model::RidgeBaseline* baseline = file.ridge_for(profile);
  if (baseline == nullptr) return {};
  ModelInput input(file, rig_sensors);
  std::vector<float> condition(file.features.width());
  std::vector<face::BlendshapeWeights> out(features.size());
  for (std::size_t f = 0; f < features.size(); ++f) {
    input.encode(features[f], condition);
    baseline->predict(condition, out[f].values);
  }
  return out;
}

}  // namespace mien::tracker
