#include "mien/model/causal_network.h"

#include <algorithm>
#include <cassert>

namespace mien::model {

Result<CausalNetwork> CausalNetwork::create(const Architecture& a, std::span<const Tensor> network,
                                            Precision precision) {
  MIEN_TRY(check(a));
  if (a.kind != NetworkKind::causal)
    return fail(ErrorCode::mismatch, "this is a window network, not a causal one", "model file",
                "use a model that was trained to be live, such as models/live.safetensors");
  MIEN_TRY(check_tensors(a, network));

  // The tensors come in network_tensors' order, so they are taken one after the other.
  auto next = network.begin();
  const auto linear = [&](std::size_t out, std::size_t in) {
    const std::vector<float>& weight = (next++)->values;
    return pack_linear(weight, (next++)->values, out, in, 0, in, precision);
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

CausalNetwork::Workspace::Workspace(const CausalNetwork& network, std::size_t performers)
    : performers_(performers),
      width_(network.architecture_.d_model),
      x_(performers * row_stride(network.architecture_.d_model)),
      state_(x_.size()),
      from_input_(performers * row_stride(kGates * network.architecture_.d_model)),
      from_state_(from_input_.size()),
      answer_(performers * row_stride(network.architecture_.outputs)),
      converted_(performers, std::max(network.architecture_.condition, network.architecture_.d_model)) {}

std::span<const float> CausalNetwork::Workspace::hidden(std::size_t performer) const {
  assert(performer < performers_);
  return {x_.data() + performer * row_stride(width_), width_};
}

void CausalNetwork::correct(const Correction* correction) {
  correction_.reset();
  if (correction == nullptr) return;
  const std::size_t in = architecture_.d_model, out = architecture_.outputs;
  assert(correction->weights.size() == out * in && correction->bias.size() == out);
  correction_ = pack_linear(correction->weights, correction->bias, out, in, 0, in, Precision::fp32);
}

CausalNetwork::State::State(const CausalNetwork& network) : alone_(network) {
  for (std::size_t i = 0; i < network.architecture_.layers; ++i)
    layers_.emplace_back(network.architecture_.d_model);
}

void CausalNetwork::State::reset() {
  for (AlignedFloats& layer : layers_) std::fill_n(layer.data(), layer.size(), 0.0F);
}

std::size_t CausalNetwork::weight_bytes() const {
  std::size_t bytes = input_.weights.size() + output_.weights.size();
  for (const Layer& layer : layers_) bytes += layer.input.weights.size() + layer.state.weights.size();
  return bytes;
}

void CausalNetwork::step_layer(std::size_t index, std::span<State* const> states, Workspace& w) const {
  const Layer& layer = layers_[index];
  const std::size_t width = architecture_.d_model, stride = row_stride(width), rows = states.size();
  const std::size_t parts = row_stride(kGates * width);
  for (std::size_t r = 0; r < rows; ++r)
    std::copy_n(states[r]->layers_[index].data(), width, w.state_.data() + r * stride);
  apply_linear(layer.input, rows, {w.x_.data(), stride}, {w.from_input_.data(), parts}, {}, w.converted_);
  apply_linear(layer.state, rows, {w.state_.data(), stride}, {w.from_state_.data(), parts}, {}, w.converted_);
  for (std::size_t r = 0; r < rows; ++r) {
    float* state = states[r]->layers_[index].data();
    float* x = w.x_.data() + r * stride;
    apply_gates(width, w.from_input_.data() + r * parts, w.from_state_.data() + r * parts, state);
    for (std::size_t j = 0; j < width; ++j) x[j] += state[j];
  }
}

void CausalNetwork::step(std::span<const float> conditions, std::span<State* const> states, Workspace& w,
                         std::span<float> out) const {
  const Architecture& a = architecture_;
  const std::size_t rows = states.size(), stride = row_stride(a.d_model), answers = row_stride(a.outputs);
  assert(rows <= w.performers_ && conditions.size() == rows * a.condition && out.size() == rows * a.outputs);
  apply_linear(input_, rows, {conditions.data(), a.condition}, {w.x_.data(), stride}, {.relu = true},
               w.converted_);
  for (std::size_t i = 0; i < layers_.size(); ++i) step_layer(i, states, w);
  apply_linear(output_, rows, {w.x_.data(), stride}, {w.answer_.data(), answers}, {}, w.converted_);
  if (correction_)
    apply_linear(*correction_, rows, {w.x_.data(), stride}, {w.answer_.data(), answers},
                 {.add = {w.answer_.data(), answers}}, w.converted_);
  for (std::size_t r = 0; r < rows; ++r)
    std::copy_n(w.answer_.data() + r * answers, a.outputs, out.data() + r * a.outputs);
}

void CausalNetwork::step(std::span<const float> condition, State& state, std::span<float> out) const {
  State* const one = &state;
  step(condition, std::span(&one, 1), state.alone_, out);
}

}  // namespace mien::model
