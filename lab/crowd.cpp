#include "lab/crowd.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "mien/model/schedule.h"
#include "mien/tracker/causal_tracker.h"

namespace mien::lab {

Crowd::Crowd(const model::ModelFile& file, model::CausalNetwork network,
             const std::vector<std::string>& face_sensor_names, std::size_t performers)
    : network_(std::move(network)),
      writer_(file),
      jitter_filters_(performers),
      workspace_(network_, kTogether),
      inputs_(kTogether, tracker::ModelInput(file, face_sensor_names)),
      together_(kTogether),
      conditions_(kTogether * file.features.width()),
      answers_(kTogether * face::kShapeCount) {
  states_.reserve(performers);
  for (std::size_t p = 0; p < performers; ++p) states_.emplace_back(network_);
}

Result<Crowd> Crowd::create(const model::ModelFile& file, const std::vector<std::string>& face_sensor_names,
                            std::size_t performers, model::Precision precision) {
  // The checks of one performer hold for all.
  MIEN_TRY(tracker::CausalTracker::create(file, face_sensor_names, precision));
  MIEN_TRY_ASSIGN(model::CausalNetwork network,
                  model::CausalNetwork::create(file.architecture, file.network, precision));
  if (file.correction) network.correct(&*file.correction);
  return Crowd(file, std::move(network), face_sensor_names, performers);
}

void Crowd::step(std::span<const std::size_t> due, std::span<const model::FeatureFrame> features,
                 std::span<face::OutputFrame> out) {
  assert(due.size() == features.size() && due.size() == out.size());
  for (std::size_t at = 0; at < due.size(); at += kTogether) {
    const std::size_t count = std::min(kTogether, due.size() - at);
    step_together(due.subspan(at, count), features.subspan(at, count), out.subspan(at, count));
  }
}

void Crowd::step_together(std::span<const std::size_t> due, std::span<const model::FeatureFrame> features,
                          std::span<face::OutputFrame> out) {
  const std::size_t count = due.size(), width = network_.architecture().condition;
  for (std::size_t i = 0; i < count; ++i) {
    inputs_[i].encode(features[i], std::span(conditions_).subspan(i * width, width));
    together_[i] = &states_[due[i]];
  }
  network_.step(std::span(conditions_).first(count * width), std::span(together_).first(count), workspace_,
                std::span(answers_).first(count * face::kShapeCount));
  for (std::size_t i = 0; i < count; ++i) {
    std::ranges::transform(std::span(answers_).subspan(i * face::kShapeCount, face::kShapeCount),
                           out[i].weights.values.begin(), model::from_network);
    jitter_filters_[due[i]].apply(out[i].weights);
    writer_.write(features[i], inputs_[i], out[i]);
  }
}

}  // namespace mien::lab
