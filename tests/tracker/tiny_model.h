#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "mien/face/profile.h"
#include "mien/model/model_file.h"
#include "tests/model/random_network.h"

namespace mien::tracker::test {

/// A table that says of every shape how much of it is covered: nothing, half or all; measured from half on.
inline model::ConfidenceTable coverage_as_confidence() {
  model::ConfidenceTable table;
  table.coverage_edges = {0.25F, 0.75F};
  table.measured_from = 0.5F;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    for (const float share : {0.0F, 0.5F, 1.0F}) {
      table.explained.push_back(share);
      table.within.push_back(share);
    }
  return table;
}

/// A whole model of the 53 shapes around a random network: quick, and it answers differently to different
/// input, which is all that tests of the way through the program need.
inline model::ModelFile tiny_model(std::vector<std::string> sensors, std::uint64_t seed = 1) {
  model::ModelFile model;
  model.features = {.sensors = std::move(sensors), .presence_flags = true};
  model.architecture = {.name = "tiny",
                        .layers = 1,
                        .d_model = 32,
                        .heads = 1,
                        .d_head = 32,
                        .ffn = 32,
                        .window = 16,
                        .condition = model.features.width(),
                        .outputs = face::kShapeCount};
  model.normalisation.mean.assign(model.features.value_count(), 0.0F);
  model.normalisation.scale.assign(model.features.value_count(), 0.5F);
  model.shapes.assign(face::kShapeNames.begin(), face::kShapeNames.end());
  model.mean_pose.assign(face::kShapeCount, 0.1F);
  for (const char* profile : {"lab", "device"}) {
    model::RidgeBaseline& ridge = model.ridge.emplace_back();
    ridge.profile = profile;
    ridge.penalty = 0.001;
    ridge.validation_mse = 0.01;
    ridge.condition = model.features.width();
    ridge.outputs = face::kShapeCount;
    // Every weight is half the fifth value (the first sensor's turn about X) and a constant of the profile.
    ridge.matrix.assign(ridge.outputs * (ridge.condition + 1), 0.0F);
    for (std::size_t k = 0; k < ridge.outputs; ++k) {
      ridge.matrix[k * (ridge.condition + 1) + 4] = 0.5F;
      ridge.matrix[k * (ridge.condition + 1) + ridge.condition] = profile[0] == 'l' ? 0.25F : 0.5F;
    }
  }
  model.confidence = coverage_as_confidence();
  model.sampler = {.kind = model::SamplerKind::ddim, .steps = 2, .seed = 7};
  model.recipe = "seed = 1\n";
  model.results = "{}";
  model.network = model::random_network(model.architecture, seed);
  return model;
}

/// The same around a causal network.
inline model::ModelFile tiny_causal_model(std::vector<std::string> sensors, std::uint64_t seed = 1) {
  model::ModelFile model = tiny_model(std::move(sensors));
  model.architecture = *model::named_architecture("causal", model.features.width());
  model.architecture.layers = 1;
  model.architecture.d_model = 32;
  model.schedule = {};
  model.sampler = {};
  model.network = model::random_network(model.architecture, seed);
  return model;
}

}  // namespace mien::tracker::test
