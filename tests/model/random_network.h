#pragma once

#include <cmath>
#include <vector>

#include "mien/core/random.h"
#include "mien/model/model_file.h"

namespace mien::model {

/// A network with weights as a fresh training run has them, and normalisation layers near the identity.
inline std::vector<Tensor> random_network(const Architecture& architecture, std::uint64_t seed) {
  Random random(seed);
  std::vector<Tensor> tensors;
  for (const TensorSpec& spec : network_tensors(architecture)) {
    Tensor& tensor = tensors.emplace_back(Tensor{.name = spec.name, .shape = spec.shape, .values = {}});
    std::size_t count = 1;
    for (const std::size_t n : spec.shape) count *= n;
    const bool gain = spec.shape.size() == 1 && spec.name.ends_with("norm.weight");
    const double spread = spec.shape.size() == 2 ? std::sqrt(1.0 / static_cast<double>(spec.shape[1])) : 0.05;
    for (std::size_t i = 0; i < count; ++i)
      tensor.values.push_back(static_cast<float>((gain ? 1.0 : 0.0) + spread * random.normal()));
  }
  return tensors;
}

/// A whole model of two sensors and three shapes around a random network, small enough for tests and for a
/// corpus.
inline ModelFile small_model(std::uint64_t seed = 1) {
  ModelFile model;
  model.features = {.sensors = {"mentalis", "buccinator_l"}, .presence_flags = true};
  model.architecture = {.name = "small",
                        .layers = 1,
                        .d_model = 32,
                        .heads = 1,
                        .d_head = 32,
                        .ffn = 32,
                        .window = 8,
                        .condition = model.features.width(),
                        .outputs = 3};
  model.normalisation.mean.assign(14, 0.25F);
  model.normalisation.scale.assign(14, 0.5F);
  model.shapes = {"jawOpen", "mouthSmile_L", "mouthSmile_R"};
  model.mean_pose = {0.1F, 0.2F, 0.3F};
  RidgeBaseline& ridge = model.ridge.emplace_back();
  ridge.profile = "lab";
  ridge.penalty = 0.001;
  ridge.validation_mse = 0.0125;
  ridge.condition = 18;
  ridge.outputs = 3;
  ridge.matrix.assign(3 * 19, 0.01F);
  model.sampler = {
      .kind = SamplerKind::ddim, .steps = 5, .seed = 7, .hold = OverlapHold::clean, .first_noise = 0.5};
  model.recipe = "seed = 1\n";
  model.results = R"({"validation":{"loss":0.5}})";
  model.network = random_network(model.architecture, seed);
  return model;
}

/// The same around a causal network.
inline ModelFile small_causal_model(std::uint64_t seed = 1) {
  ModelFile model = small_model();
  model.architecture = *named_architecture("causal", model.features.width());
  model.architecture.layers = 1;
  model.architecture.d_model = 32;
  model.architecture.outputs = 3;
  model.schedule = {};
  model.sampler = {};
  model.network = random_network(model.architecture, seed);
  return model;
}

}  // namespace mien::model
