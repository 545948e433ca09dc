#include "mien/train/parity.h"

#include <algorithm>
#include <cmath>

#include "mien/core/random.h"
#include "mien/model/causal_network.h"
#include "mien/model/denoiser.h"
#include "mien/train/network.h"

namespace mien::train {
namespace {

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
      predict_causal(a, parameters,
                     torch::tensor(condition).view(
                         {1, static_cast<std::int64_t>(a.window), static_cast<std::int64_t>(a.condition)}),
                     {})
          .contiguous();
  const auto* data = expected.data_ptr<float>();
  for (std::size_t f = 0; f < a.window; ++f) {
    network.step(std::span(condition).subspan(f * a.condition, a.condition), state, answer);
    for (std::size_t i = 0; i < a.outputs; ++i)
      parity.largest_difference =
          std::max(parity.largest_difference, std::abs(double{answer[i]} - double{data[f * a.outputs + i]}));
    ++parity.calls;
  }
  return parity;
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
      const auto* data = expected.data_ptr<float>();
      for (std::size_t i = 0; i < clean.size(); ++i)
        parity.largest_difference =
            std::max(parity.largest_difference, std::abs(double{clean[i]} - double{data[i]}));
      ++parity.calls;
    }
  return parity;
}

}  // namespace mien::train
