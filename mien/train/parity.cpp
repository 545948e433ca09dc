#include "mien/train/parity.h"

#include <ATen/Parallel.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <vector>

#include "mien/core/random.h"
#include "mien/model/causal_network.h"
#include "mien/model/denoiser.h"
#include "mien/train/network.h"

namespace mien::train {
namespace {

/// Keeps the largest difference; one that is no number stays.
void keep_largest_difference(std::span<const float> ours, const float* theirs, double& largest) {
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const double difference = std::abs(double{ours[i]} - double{theirs[i]});
    if (!(difference <= largest) && !std::isnan(largest)) largest = difference;
  }
}

Result<Parity> measure_causal(const model::ModelFile& model) {
  const model::Architecture& a = model.architecture;
  MIEN_TRY_ASSIGN(const model::CausalNetwork network, model::CausalNetwork::create(a, model.network));
  const Parameters parameters = from_tensors(model.network, torch::kCPU);
  model::CausalNetwork::State state(network);
  const at::NoGradGuard no_gradients;
  Random random(1);
  Parity parity;
  std::vector<float> condition(a.window * a.condition), answer(a.outputs);
  for (float& v : condition) v = static_cast<float>(random.normal());
  const torch::Tensor expected =
      predict_at_once(a, parameters,
                      torch::tensor(condition).view(
                          {1, static_cast<std::int64_t>(a.window), static_cast<std::int64_t>(a.condition)}),
                      {})
          .contiguous();
  const auto* data = expected.data_ptr<float>();
  for (std::size_t f = 0; f < a.window; ++f) {
    network.step(std::span(condition).subspan(f * a.condition, a.condition), state, answer);
    keep_largest_difference(answer, data + f * a.outputs, parity.largest_difference);
    ++parity.calls;
  }
  return parity;
}

using Clock = std::chrono::steady_clock;

/// The network as one would write it for libtorch: linear layers and its own cell of gated recurrent units.
class Stepper {
 public:
  Stepper(const model::Architecture& architecture, const Parameters& parameters)
      : parameters_(parameters), layers_(architecture.layers) {
    for (std::size_t layer = 0; layer < layers_; ++layer)
      states_.push_back(torch::zeros({1, static_cast<std::int64_t>(architecture.d_model)}));
  }

  torch::Tensor step(const torch::Tensor& condition) {
    std::size_t next = 0;
    const auto use = [&]() -> const torch::Tensor& { return parameters_[next++]; };
    const torch::Tensor &weight = use(), &bias = use();
    torch::Tensor x = torch::linear(condition, weight, bias).relu_();
    for (std::size_t layer = 0; layer < layers_; ++layer) {
      const torch::Tensor &from_input = use(), &input_bias = use(), &from_state = use(), &state_bias = use();
      states_[layer] = torch::gru_cell(x, states_[layer], from_input, from_state, input_bias, state_bias);
      x = x + states_[layer];
    }
    const torch::Tensor &out_weight = use(), &out_bias = use();
    return torch::linear(x, out_weight, out_bias);
  }

 private:
  const Parameters& parameters_;
  std::size_t layers_;
  std::vector<torch::Tensor> states_;
};

Result<double> compare_steps(const model::ModelFile& model, const Parameters& parameters) {
  constexpr std::size_t kFrames = 60;
  const model::Architecture& a = model.architecture;
  MIEN_TRY_ASSIGN(const model::CausalNetwork network, model::CausalNetwork::create(a, model.network));
  model::CausalNetwork::State state(network);
  Stepper stepper(a, parameters);
  Random random(1);
  std::vector<float> condition(a.condition), ours(a.outputs);
  double largest = 0;
  for (std::size_t f = 0; f < kFrames; ++f) {
    for (float& v : condition) v = static_cast<float>(random.normal());
    network.step(condition, state, ours);
    const torch::Tensor theirs = stepper.step(torch::tensor(condition).view({1, -1})).contiguous();
    keep_largest_difference(ours, theirs.data_ptr<float>(), largest);
  }
  return largest;
}

}  // namespace

Result<Parity> measure_parity(const model::ModelFile& model) {
  if (model.architecture.kind == model::NetworkKind::causal) return measure_causal(model);
  const model::Architecture& a = model.architecture;
  MIEN_TRY_ASSIGN(const model::Denoiser denoiser, model::Denoiser::create(a, model.network));
  const Parameters parameters = from_tensors(model.network, torch::kCPU);
  model::Denoiser::Workspace workspace(denoiser);
  const at::NoGradGuard no_gradients;
  Random random(1);
  Parity parity;
  const std::size_t levels = model.schedule.levels;
  for (const std::size_t frames : {a.window, a.window / 2, std::size_t{1}})
    for (const std::size_t level : {std::size_t{0}, levels / 4, levels / 2, levels - 1}) {
      std::vector<float> condition(frames * a.condition), noisy(frames * a.outputs), clean(noisy.size());
      for (float& v : condition) v = static_cast<float>(random.normal());
      for (float& v : noisy) v = static_cast<float>(random.normal());
      denoiser.set_condition(condition, workspace);
      denoiser.predict(noisy, level, clean, workspace);
      const auto rows = static_cast<std::int64_t>(frames);
      const torch::Tensor expected = predict(a, parameters, torch::tensor(noisy).view({1, rows, -1}),
                                             torch::tensor(condition).view({1, rows, -1}),
                                             torch::tensor({static_cast<std::int64_t>(level)}), {})
                                         .contiguous();
      keep_largest_difference(clean, expected.data_ptr<float>(), parity.largest_difference);
      ++parity.calls;
    }
  return parity;
}

Result<LibtorchStep> measure_libtorch_step(const model::ModelFile& model) {
  const model::Architecture& a = model.architecture;
  if (a.kind != model::NetworkKind::causal)
    return fail(ErrorCode::unsupported, "only a causal network has a step");
  at::set_num_threads(1);
  const c10::InferenceMode inference;
  const Parameters parameters = from_tensors(model.network, torch::kCPU);
  LibtorchStep out;
  MIEN_TRY_ASSIGN(out.largest_difference, compare_steps(model, parameters));
  if (!(out.largest_difference < kParityLimit))
    return fail(ErrorCode::mismatch,
                fmt::format("libtorch answers otherwise, by {:.2e}", out.largest_difference));

  constexpr std::size_t kSteps = 16, kRounds = 9, kTries = 100;
  Stepper stepper(a, parameters);
  const torch::Tensor condition = torch::full({1, static_cast<std::int64_t>(a.condition)}, 0.1F);
  std::vector<double> took(kTries);
  out.step_s = std::numeric_limits<double>::infinity();
  for (std::size_t round = 0; round < kRounds; ++round) {
    for (double& one : took) {
      const auto from = Clock::now();
      for (std::size_t j = 0; j < kSteps; ++j) stepper.step(condition);
      one = std::chrono::duration<double>(Clock::now() - from).count() / kSteps;
    }
    std::ranges::nth_element(took, took.begin() + kTries / 2);
    out.step_s = std::min(out.step_s, took[kTries / 2]);
  }
  return out;
}

}  // namespace mien::train
