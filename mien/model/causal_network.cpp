#include "mien/model/causal_network.h"

#include <algorithm>
#include <cassert>

namespace mien::model {

Result<CausalNetwork> CausalNetwork::create(const Architecture& a, std::span<const Tensor> network) {
  MIEN_TRY(check(a));
  if (a.kind != NetworkKind::causal)
    return fail(ErrorCode::mismatch, "this is a window network, not a causal one", "model file",
                "use a model that was trained to be live, such as models/live.safetensors");
  MIEN_TRY(check_tensors(a, network));

  // The tensors come in network_tensors' order, so they are taken one after the other.
  auto next = network.begin();
  const auto linear = [&](std::size_t out, std::size_t in) {
    const std::vector<float>& weight = (next++)->values;
    return pack_linear(weight, (next++)->values, out, in, 0, in);
  };
  CausalNetwork result;
  result.architecture_ = a;
  result.input_ = linear(a.d_model, a.condition);
  for (std::size_t i = 0; i < a.layers; ++i) {
    Layer& layer = result.layers_.emplace_back();
    layer.input = linear(kGates * a.d_model, a.d_model);
    layer.state = linear(kGates * a.d_model, a.d_model);
  }
  result.output_ = linear(a.outputs, a.d_model);
  return result;
}

CausalNetwork::State::State(const CausalNetwork& network) {
  const Architecture& a = network.architecture_;
  for (std::size_t i = 0; i < a.layers; ++i) layers_.emplace_back(a.d_model);
  x_ = AlignedFloats(a.d_model);
  from_input_ = AlignedFloats(kGates * a.d_model);
  from_state_ = AlignedFloats(kGates * a.d_model);
  answer_ = AlignedFloats(padded(a.outputs));
}

void CausalNetwork::State::reset() {
  for (AlignedFloats& layer : layers_) std::fill_n(layer.data(), layer.size(), 0.0F);
}

void CausalNetwork::step(std::span<const float> condition, State& s, std::span<float> out) const {
  const Architecture& a = architecture_;
  assert(condition.size() == a.condition && out.size() == a.outputs && s.layers_.size() == a.layers);
  const std::size_t width = a.d_model;
  float* x = s.x_.data();
  apply_linear(input_, 1, condition.data(), a.condition, nullptr, 0, Activation::relu, x, width);
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    float* state = s.layers_[i].data();
    apply_linear(layers_[i].input, 1, x, width, nullptr, 0, Activation::none, s.from_input_.data(),
                 kGates * width);
    apply_linear(layers_[i].state, 1, state, width, nullptr, 0, Activation::none, s.from_state_.data(),
                 kGates * width);
    apply_gates(width, s.from_input_.data(), s.from_state_.data(), state);
    for (std::size_t j = 0; j < width; ++j) x[j] += state[j];
  }
  apply_linear(output_, 1, x, width, nullptr, 0, Activation::none, s.answer_.data(), padded(a.outputs));
  std::copy_n(s.answer_.data(), a.outputs, out.data());
}

}  // namespace mien::model
