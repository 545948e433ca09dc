#include <benchmark/benchmark.h>

#include <cmath>
#include <string>
#include <vector>

#include "lab/peak.h"
#include "mien/core/random.h"
#include "mien/core/sha256.h"
#include "mien/model/architecture.h"
#include "mien/model/causal_network.h"
#include "mien/model/denoiser.h"
#include "mien/model/linear.h"

// The networks' run time, each figure beside what the core can do at most, measured in this run: `of_peak` is
// the share of the fp32 peak (bf16 and int8 may pass 1), `of_read` the share of the rate at which 8 MB are
// read.
namespace {

using namespace mien;
using model::Precision;

double peak_gflops() {
  static const double peak = lab::peak_gflops();
  return peak;
}

double read_gb_s() {
  static const double rate = lab::read_gb_s(std::size_t{8} << 20);
  return rate;
}

std::vector<float> numbers(std::size_t count, std::uint64_t seed, double spread = 1) {
  Random random(seed);
  std::vector<float> values(count);
  for (float& v : values) v = static_cast<float>(spread * random.normal());
  return values;
}

/// Weights as a fresh training run has them.
std::vector<model::Tensor> random_network(const model::Architecture& architecture) {
  std::vector<model::Tensor> tensors;
  for (const model::TensorSpec& spec : model::network_tensors(architecture)) {
    std::size_t count = 1;
    for (const std::size_t n : spec.shape) count *= n;
    const double spread = spec.shape.size() == 2 ? 1 / std::sqrt(static_cast<double>(spec.shape[1])) : 0.05;
    tensors.push_back(
        {.name = spec.name, .shape = spec.shape, .values = numbers(count, tensors.size(), spread)});
    if (spec.shape.size() == 1 && spec.name.ends_with("norm.weight"))
      for (float& gain : tensors.back().values) gain += 1;
  }
  return tensors;
}

std::string label(Precision precision, std::span<const float> answer) {
  Sha256 hash;
  hash.add(std::as_bytes(answer));
  return model::kernel_name(precision) + " sha256 " + hash.hex().substr(0, 16);
}

void count(benchmark::State& state, double flop, double weight_bytes) {
  const auto rate = benchmark::Counter::kIsIterationInvariantRate;
  state.counters["gflops"] = benchmark::Counter(1e-9 * flop, rate);
  state.counters["of_peak"] = benchmark::Counter(1e-9 * flop / peak_gflops(), rate);
  state.counters["of_read"] = benchmark::Counter(1e-9 * weight_bytes / read_gb_s(), rate);
}

// One linear layer: rows, outputs, inputs, precision.
void linear_layer(benchmark::State& state) {
  const auto rows = static_cast<std::size_t>(state.range(0)), out = static_cast<std::size_t>(state.range(1));
  const auto in = static_cast<std::size_t>(state.range(2)), stride = model::row_stride(out);
  const auto precision = static_cast<Precision>(state.range(3));
  const auto weight = numbers(out * in, 1), bias = numbers(out, 2),
             x = numbers(rows * model::row_stride(in), 3);
  const auto layer = model::pack_linear(weight, bias, out, in, 0, in, precision);
  model::ConvertedRows memory(rows, in);
  model::AlignedFloats y(rows * stride);
  for (auto step : state) {
    (void)step;
    model::apply_linear(layer, rows, {x.data(), model::row_stride(in)}, {y.data(), stride}, {}, memory);
    benchmark::DoNotOptimize(y.data());
  }
  count(state, 2.0 * static_cast<double>(rows * out * in), static_cast<double>(layer.weights.size()));
  state.SetLabel(label(precision, {y.data(), y.size()}));
}
BENCHMARK(linear_layer)
    ->ArgsProduct({{121}, {1024}, {256}, {0, 1, 2}})
    ->ArgsProduct({{1, 4, 12}, {4096}, {512}, {0, 1, 2}});

// A step of the light window network on 120 frames: precision.
void window_step(benchmark::State& state) {
  const auto precision = static_cast<Precision>(state.range(0));
  const model::Architecture a = *model::named_architecture("light", 99);
  const auto denoiser = model::Denoiser::create(a, random_network(a), precision).value();
  model::Denoiser::Workspace workspace(denoiser);
  const auto condition = numbers(a.window * a.condition, 1), noisy = numbers(a.window * a.outputs, 2);
  std::vector<float> clean(noisy.size());
  denoiser.set_condition(condition, workspace);
  for (auto step : state) {
    (void)step;
    denoiser.predict(noisy, 500, clean, workspace);
    benchmark::DoNotOptimize(clean.data());
  }
  count(state, model::flop_count(a), 0);
  state.SetLabel(label(precision, clean));
}
BENCHMARK(window_step)->ArgsProduct({{0, 1, 2}})->Unit(benchmark::kMillisecond);

// A step of the causal network: precision, performers together.
void causal_step(benchmark::State& state) {
  const auto precision = static_cast<Precision>(state.range(0));
  const auto performers = static_cast<std::size_t>(state.range(1));
  const model::Architecture a = *model::named_architecture("causal", 99);
  const auto network = model::CausalNetwork::create(a, random_network(a), precision).value();
  model::CausalNetwork::Workspace workspace(network, performers);
  std::vector<model::CausalNetwork::State> states;
  for (std::size_t p = 0; p < performers; ++p) states.emplace_back(network);
  std::vector<model::CausalNetwork::State*> all;
  for (auto& of : states) all.push_back(&of);
  const auto conditions = numbers(performers * a.condition, 1);
  std::vector<float> out(performers * a.outputs);
  for (auto step : state) {
    (void)step;
    for (auto& of : states) of.reset();
    network.step(conditions, all, workspace, out);
    benchmark::DoNotOptimize(out.data());
  }
  count(state, model::flop_count(a) * static_cast<double>(performers),
        static_cast<double>(network.weight_bytes()));
  state.SetLabel(label(precision, out));
}
BENCHMARK(causal_step)->ArgsProduct({{0, 1, 2}, {1, 4, 48}})->Unit(benchmark::kMicrosecond);

}  // namespace
