#include "mien/model/architecture.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <numeric>

#include "mien/core/excerpt.h"
#include "mien/model/backbone.h"

namespace mien::model {
namespace {

/// A layer's weights, and a bias for each of their rows.
void add_layer(std::vector<TensorSpec>& specs, const std::string& name,
               const std::vector<std::size_t>& shape) {
  specs.push_back({name + ".weight", shape});
  specs.push_back({name + ".bias", {shape.front()}});
}

std::size_t numbers_of(const std::vector<std::size_t>& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies());
}

/// Gates stand below each other as reset, update, new (PyTorch's order).
void add_causal(const Architecture& a, std::vector<TensorSpec>& specs) {
  add_layer(specs, "input", {a.d_model, a.condition});
  for (std::size_t i = 0; i < a.layers; ++i) {
    const std::string layer = fmt::format("layers.{}.", i);
    add_layer(specs, layer + "input", {kGates * a.d_model, a.d_model});
    add_layer(specs, layer + "state", {kGates * a.d_model, a.d_model});
  }
}

/// Eyes' backbone, mouths' backbone, what stands for a view that is missing, and the layer behind them.
void add_views(const Architecture& a, std::vector<TensorSpec>& specs) {
  for (const char* of : {"eye.", "mouth."})
    for (const TensorSpec& spec : tensor_specs(backbone_shape(a)))
      specs.push_back({of + spec.name, spec.shape});
  specs.push_back({"missing", {kViews, a.features}});
  add_layer(specs, "hidden", {a.d_model, 2 * kViews * a.features});
}

void add_window(const Architecture& a, std::vector<TensorSpec>& specs) {
  add_layer(specs, "input", {a.d_model, a.input()});
  add_layer(specs, "noise.hidden", {kNoiseHidden, kNoiseSinusoid});
  add_layer(specs, "noise.out", {a.d_model, kNoiseHidden});
  for (std::size_t i = 0; i < a.layers; ++i) {
    const std::string layer = fmt::format("layers.{}.", i);
    add_layer(specs, layer + "query", {a.d_attention(), a.d_model});
    add_layer(specs, layer + "key", {a.d_attention(), a.d_model});
    add_layer(specs, layer + "value", {a.d_attention(), a.d_model});
    add_layer(specs, layer + "attended", {a.d_model, a.d_attention()});
    add_layer(specs, layer + "attention_norm", {a.d_model});
    add_layer(specs, layer + "ffn.hidden", {a.ffn, a.d_model});
    add_layer(specs, layer + "ffn.out", {a.d_model, a.ffn});
    add_layer(specs, layer + "ffn_norm", {a.d_model});
  }
}

}  // namespace

BackboneShape backbone_shape(const Architecture& a) {
  return {.size = a.side, .widths = a.widths, .features = a.features};
}

Result<Architecture> named_architecture(std::string_view name, std::size_t condition) {
  Architecture result;
  result.name = name;
  result.condition = condition;
  if (name == "light") return result;
  if (name == "faithful") {
    result.d_model = 512;
    result.d_head = 256;
    result.ffn = 512;
    return result;
  }
  if (name == "causal") {
    result.kind = NetworkKind::causal;
    result.layers = 2;
    result.heads = result.d_head = result.ffn = 0;
    result.window = 240;
    return result;
  }
  if (name == "views") {
    const BackboneShape usual;
    result.kind = NetworkKind::views;
    result.layers = usual.widths.size();
    result.heads = result.d_head = result.ffn = 0;
    result.window = 6;
    result.side = usual.size;
    result.features = usual.features;
    result.widths = usual.widths;
    result.condition = views_condition(result.side);
    return result;
  }
  return fail(ErrorCode::not_found, fmt::format("there is no architecture called \"{}\"", excerpt(name)), {},
              "use faithful, light, causal or views");
}

Result<void> check(const Architecture& a) {
  struct Range {
    const char* name;
    std::size_t value, low, high, step;
  };
  // The upper ends keep a hostile file from asking for more memory than any network of ours needs.
  const bool views = a.kind == NetworkKind::views;
  const auto denoisers = [&](Range range) {
    return a.kind == NetworkKind::window ? range : Range{range.name, range.value, 0, 0, 1};
  };
  for (const Range& r :
       {Range{"layers", a.layers, 1, 32, 1}, Range{"d_model", a.d_model, 32, 4096, 32},
        denoisers({"heads", a.heads, 1, 64, 1}), denoisers({"d_head", a.d_head, 32, 1024, 32}),
        denoisers({"ffn", a.ffn, 32, 16384, 32}), Range{"window", a.window, 2, 1024, 1},
        views ? Range{"condition", a.condition, views_condition(a.side), views_condition(a.side), 1}
              : Range{"condition", a.condition, 1, 4096, 1},
        Range{"side", a.side, 0, views ? 256UL : 0UL, 1},
        Range{"features", a.features, 0, views ? 4096UL : 0UL, 1},
        Range{"widths", a.widths.size(), views ? a.layers : 0, views ? a.layers : 0, 1},
        Range{"outputs", a.outputs, 1, 1024, 1}})
    if (r.value < r.low || r.value > r.high || r.value % r.step != 0)
      return fail(ErrorCode::out_of_range,
                  fmt::format("{} is {}, not a multiple of {} between {} and {}", r.name, r.value, r.step,
                              r.low, r.high),
                  "architecture");
  if (views) return check(backbone_shape(a));
  return {};
}

std::vector<TensorSpec> network_tensors(const Architecture& a) {
  std::vector<TensorSpec> specs;
  if (a.kind == NetworkKind::views)
    add_views(a, specs);
  else if (a.kind == NetworkKind::causal)
    add_causal(a, specs);
  else
    add_window(a, specs);
  add_layer(specs, "output", {a.outputs, a.d_model});
  return specs;
}

Result<void> check_tensors(const Architecture& a, std::span<const Tensor> network) {
  return check_tensors(network_tensors(a), network);
}

Result<void> check_tensors(std::span<const TensorSpec> specs, std::span<const Tensor> network) {
  const auto listed = [](const std::vector<std::size_t>& shape) {
    return fmt::format("[{}]", fmt::join(shape, ", "));
  };
  if (network.size() != specs.size())
    return fail(ErrorCode::mismatch,
                fmt::format("the network has {} tensors, not {}", network.size(), specs.size()));
  for (std::size_t i = 0; i < specs.size(); ++i) {
    const Tensor& t = network[i];
    if (t.name != specs[i].name || t.shape != specs[i].shape || t.values.size() != numbers_of(t.shape))
      return fail(ErrorCode::mismatch, fmt::format("tensor {} {} stands where {} {} belongs", excerpt(t.name),
                                                   listed(t.shape), specs[i].name, listed(specs[i].shape)));
  }
  return {};
}

std::size_t parameter_count(const Architecture& architecture) {
  std::size_t count = 0;
  for (const TensorSpec& spec : network_tensors(architecture)) count += numbers_of(spec.shape);
  return count;
}

double flop_count(const Architecture& a) {
  const auto d = [](std::size_t n) { return static_cast<double>(n); };
  if (a.kind == NetworkKind::causal)
    return 2 * d(a.d_model) * (d(a.condition + a.outputs) + d(a.layers) * 2 * d(kGates) * d(a.d_model));
  if (a.kind == NetworkKind::views)
    return d(kViews) * flop_count(backbone_shape(a)) +
           2 * d(a.d_model) * d(2 * kViews * a.features + a.outputs);
  const double tokens = d(a.tokens());
  const double layer = 2 * tokens * (4 * d(a.d_model) * d(a.d_attention()) + 2 * d(a.d_model) * d(a.ffn)) +
                       4 * tokens * tokens * d(a.d_attention());
  return d(a.layers) * layer + 2 * d(a.window) * d(a.d_model) * d(a.input() + a.outputs) +
         2 * d(kNoiseHidden) * d(kNoiseSinusoid + a.d_model);
}

void position_encoding(std::size_t position, std::vector<float>& out) {
  const auto width = static_cast<double>(out.size());
  for (std::size_t j = 0; j < out.size(); ++j) {
    const double angle =
        static_cast<double>(position + 1) / std::pow(10000.0, static_cast<double>(j / 2 * 2) / width);
    out[j] = static_cast<float>(j % 2 == 0 ? std::sin(angle) : std::cos(angle));
  }
}

std::array<float, kNoiseSinusoid> noise_sinusoid(std::size_t level) {
  constexpr std::size_t kHalf = kNoiseSinusoid / 2;
  std::array<float, kNoiseSinusoid> out;
  for (std::size_t i = 0; i < kHalf; ++i) {
    const double frequency =
        std::exp(-std::log(10000.0) * static_cast<double>(i) / static_cast<double>(kHalf - 1));
    const double angle = static_cast<double>(level) * frequency;
    out[i] = static_cast<float>(std::sin(angle));
    out[kHalf + i] = static_cast<float>(std::cos(angle));
  }
  return out;
}

}  // namespace mien::model
