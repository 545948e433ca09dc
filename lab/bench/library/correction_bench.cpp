#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "mien/core/sha256.h"
#include "mien/model/causal_network.h"
#include "mien/model/model_file.h"
#include "mien/model/network_correction.h"
#include "mien/tracker/causal_tracker.h"

namespace {

using namespace mien;

// One frame of the live network, as it is (0) and corrected for a wearer (1): what a correction costs is the
// difference.
void correction(benchmark::State& state) {
  const auto file = model::read_model("models/live.safetensors");
  if (!file) {
    state.SkipWithError(file.error().message().c_str());
    return;
  }
  const model::Architecture& a = file->architecture;
  auto network = model::CausalNetwork::create(a, file->network, tracker::kLivePrecision).value();
  model::Correction made{.network = model::correction_key(file->network), .weights = {}, .bias = {}};
  for (std::size_t i = 0; i < a.outputs * a.d_model; ++i)
    made.weights.push_back(0.01F * static_cast<float>(std::sin(0.7 * static_cast<double>(i))));
  made.bias.assign(a.outputs, 0.01F);
  if (state.range(0) != 0) network.correct(&made);
  model::CausalNetwork::State remembered(network);
  std::vector<float> condition(a.condition), answer(a.outputs);
  Sha256 hash;
  std::size_t f = 0;
  for (auto _ : state) {
    for (std::size_t i = 0; i < condition.size(); i += 7)
      condition[i] = static_cast<float>(std::sin(0.05 * static_cast<double>(f + i)));
    network.step(condition, remembered, answer);
    benchmark::DoNotOptimize(answer.data());
    f = (f + 1) % 600;
  }
  remembered.reset();
  for (std::size_t frame = 0; frame < 60; ++frame) {
    condition.assign(condition.size(), static_cast<float>(std::sin(0.05 * static_cast<double>(frame))));
    network.step(condition, remembered, answer);
    for (const float number : answer) hash.add_value(number);
  }
  state.SetLabel(hash.hex().substr(0, 16));
}
BENCHMARK(correction)->Arg(0)->Arg(1);

}  // namespace
