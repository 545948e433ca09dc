#include "mien/onnx/window_graph.h"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace mien::onnx {
namespace {

/// The nodes of the whole network. Tokens of all windows stand below each other, [batch * tokens x d_model],
/// wherever they need not be told apart: products are then Gemm, with the bias inside.
class WindowGraph {
 public:
  WindowGraph(Graph& graph, const model::Architecture& architecture, std::span<const model::Tensor> network,
              std::size_t levels)
      : graph_(graph), a_(architecture) {
    for (const model::Tensor& tensor : network) graph.constant(tensor.name, tensor.shape, tensor.values);
    add_sinusoids(levels);
    scale_ = graph.scalar("attention_scale", std::sqrt(static_cast<float>(a_.d_head)));
    axis_ = graph.constant("token_axis", {1});
  }

  void add(const std::string& noisy, const std::string& level, const std::string& condition,
           const std::string& clean) {
    const std::string windows = rows_of(noisy);
    const std::string input = graph_.add("Concat", {noisy, condition}, {{"axis", std::int64_t{2}}});
    const std::string frames =
        reshaped(linear(folded(input, a_.input()), "input"), shape(windows, {number(a_.d_model)}));
    std::string x = graph_.add("Concat", {noise_token(level), frames}, {{"axis", std::int64_t{1}}});
    const std::string tokens = rows_of(x);
    heads_ = shape(tokens, {number(a_.heads), number(a_.d_head)});
    x = folded(graph_.add("Add", {x, positions_of(x)}), a_.d_model);
    for (std::size_t i = 0; i < a_.layers; ++i) {
      const std::string layer = "layers." + std::to_string(i) + ".";
      x = normalise(graph_.add("Add", {x, attention(x, layer)}), layer + "attention_norm");
      const std::string hidden = graph_.add("Relu", {linear(x, layer + "ffn.hidden")});
      x = normalise(graph_.add("Add", {x, linear(hidden, layer + "ffn.out")}), layer + "ffn_norm");
    }
    // The noise token has done its work.
    const std::string answered = graph_.add("Slice", {reshaped(x, shape(tokens, {number(a_.d_model)})),
                                                      size("one", 1), size("end", a_.tokens()), axis_});
    reshaped(linear(folded(answered, a_.d_model), "output"), shape(windows, {number(a_.outputs)}), clean);
  }

 private:
  static std::int64_t number(std::size_t n) { return static_cast<std::int64_t>(n); }
  std::string size(const std::string& name, std::size_t n) { return graph_.constant(name, {number(n)}); }

  /// The lengths of the first two axes: windows, and frames or tokens.
  std::string rows_of(const std::string& x) {
    return graph_.add("Shape", {x}, {{"start", std::int64_t{0}}, {"end", std::int64_t{2}}});
  }
  /// A shape: the first two axes `rows`, with these behind them.
  std::string shape(const std::string& rows, const std::vector<std::int64_t>& widths) {
    const std::string behind = graph_.constant("widths_" + std::to_string(++shapes_), widths);
    return graph_.add("Concat", {rows, behind}, {{"axis", std::int64_t{0}}});
  }
  std::string reshaped(const std::string& x, const std::string& shape, const std::string& as = {}) {
    return graph_.add("Reshape", {x, shape}, {}, as);
  }
  /// [a x b x width] to [a * b x width].
  std::string folded(const std::string& x, std::size_t width) {
    return reshaped(x, graph_.constant("folded_" + std::to_string(++shapes_), {-1, number(width)}));
  }

  /// Sinusoids of noise levels and places as the run time has them; single precision's own would be far off
  /// at level 999.
  void add_sinusoids(std::size_t levels) {
    std::vector<float> table;
    for (std::size_t level = 0; level < levels; ++level)
      for (const float v : model::noise_sinusoid(level)) table.push_back(v);
    levels_ = graph_.constant("level_sinusoids", {levels, model::kNoiseSinusoid}, table);
    table.clear();
    std::vector<float> position(a_.d_model);
    for (std::size_t token = 0; token < a_.tokens(); ++token) {
      model::position_encoding(token, position);
      table.insert(table.end(), position.begin(), position.end());
    }
    positions_ = graph_.constant("positions", {1, a_.tokens(), a_.d_model}, table);
  }

  std::string linear(const std::string& x, const std::string& layer) {
    return graph_.gemm(x, layer + ".weight", layer + ".bias");
  }

  std::string normalise(const std::string& x, const std::string& layer) {
    return graph_.add(
        "LayerNormalization", {x, layer + ".weight", layer + ".bias"},
        {{"axis", std::int64_t{-1}}, {"epsilon", static_cast<float>(model::kLayerNormEpsilon)}});
  }

  /// [batch x 1 x d_model].
  std::string noise_token(const std::string& level) {
    const std::string sinusoid = graph_.add("Gather", {levels_, level}, {{"axis", std::int64_t{0}}});
    const std::string hidden = linear(sinusoid, "noise.hidden");
    // The exact GELU, x (1 + erf(x / sqrt 2)) / 2.
    const std::string root = graph_.scalar("root_of_two", std::numbers::sqrt2_v<float>);
    const std::string half = graph_.scalar("half", 0.5F), unit = graph_.scalar("unit", 1);
    const std::string share =
        graph_.add("Add", {graph_.add("Erf", {graph_.add("Div", {hidden, root})}), unit});
    const std::string bent = graph_.add("Mul", {graph_.add("Mul", {hidden, share}), half});
    return graph_.add("Unsqueeze", {linear(bent, "noise.out"), axis_});
  }

  /// Of as many tokens as x has.
  std::string positions_of(const std::string& x) {
    const std::string tokens =
        graph_.add("Shape", {x}, {{"start", std::int64_t{1}}, {"end", std::int64_t{2}}});
    return graph_.add("Slice", {positions_, size("begin", 0), tokens, axis_});
  }

  std::string attention(const std::string& x, const std::string& layer) {
    const auto heads = [&](const char* part, std::vector<std::int64_t> order) {
      return graph_.add("Transpose", {reshaped(linear(x, layer + part), heads_)},
                        {{"perm", std::move(order)}});
    };
    const std::string query = heads("query", {0, 2, 1, 3}), key = heads("key", {0, 2, 3, 1}),
                      value = heads("value", {0, 2, 1, 3});
    const std::string scores = graph_.add("Div", {graph_.add("MatMul", {query, key}), scale_});
    const std::string share = graph_.add("Softmax", {scores}, {{"axis", std::int64_t{-1}}});
    const std::string attended = graph_.add("Transpose", {graph_.add("MatMul", {share, value})},
                                            {{"perm", std::vector<std::int64_t>{0, 2, 1, 3}}});
    return linear(folded(attended, a_.d_attention()), layer + "attended");
  }

  Graph& graph_;
  const model::Architecture& a_;
  std::string levels_, positions_, scale_, axis_, heads_;
  std::size_t shapes_ = 0;
};

}  // namespace

void add_window_network(Graph& graph, const model::Architecture& a, std::span<const model::Tensor> network,
                        const std::string& condition, std::size_t levels) {
  graph.input({.name = "noisy",
               .shape = {"batch", "frames", a.outputs},
               .says = "The noisy window, x = 2 w - 1 of weights w in metadata `shapes`' order; 1 to " +
                       std::to_string(a.window) + " frames of 1/60 s."});
  graph.input({.name = "level",
               .element = Element::i64,
               .shape = {"batch"},
               .says = "Noise level, 0 (almost clean) to " + std::to_string(levels - 1) + "."});
  WindowGraph(graph, a, network, levels).add("noisy", "level", condition, "clean");
  graph.output(
      {.name = "clean",
       .shape = {"batch", "frames", a.outputs},
       .says = "The clean window that the network sees in the noisy one: x = 2 w - 1, nominally -1 to 1; "
               "not held to it."});
}

}  // namespace mien::onnx
