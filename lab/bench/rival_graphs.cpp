#include "lab/bench/rival_graphs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "mien/core/random.h"
#include "mien/onnx/graph.h"

namespace mien::lab {
namespace {

using Integers = std::vector<std::int64_t>;

/// Adds layers with weights that keep the numbers' size.
class Layers {
 public:
  Layers(onnx::Graph& graph, std::uint64_t seed) : graph_(graph), random_(seed) {}

  struct Convolution {
    std::size_t in = 1, out = 1, kernel = 1, stride = 1, groups = 1;
  };
  std::string convolve(const std::string& x, const Convolution& c) {
    const std::size_t inputs = c.in / c.groups;
    const auto pad = static_cast<std::int64_t>(c.kernel / 2), kernel = static_cast<std::int64_t>(c.kernel),
               stride = static_cast<std::int64_t>(c.stride);
    return graph_.add("Conv",
                      {x, weights({c.out, inputs, c.kernel, c.kernel}, inputs * c.kernel * c.kernel),
                       weights({c.out}, c.out)},
                      {{"kernel_shape", Integers{kernel, kernel}},
                       {"strides", Integers{stride, stride}},
                       {"pads", Integers{pad, pad, pad, pad}},
                       {"group", static_cast<std::int64_t>(c.groups)}});
  }
  /// x sigmoid(x).
  std::string swish(const std::string& x) { return graph_.add("Mul", {x, graph_.add("Sigmoid", {x})}); }
  /// Of one row a picture, what it answers; the graph's output.
  void answer(const std::string& x, std::size_t in, std::size_t out) {
    const std::string flat = graph_.add("Flatten", {x}, {{"axis", std::int64_t{1}}});
    const std::string sum = graph_.gemm(flat, weights({out, in}, in), weights({out}, out));
    graph_.add("Sigmoid", {sum}, {}, "answer");
    graph_.output({.name = "answer", .shape = {std::size_t{1}, out}, .says = "Nothing: weights are random."});
  }

 private:
  std::string weights(const std::vector<std::size_t>& shape, std::size_t inputs) {
    std::size_t count = 1;
    for (const std::size_t n : shape) count *= n;
    const double spread = std::sqrt(1 / static_cast<double>(inputs));
    std::vector<float> values(count);
    for (float& value : values) value = static_cast<float>(spread * random_.normal());
    return graph_.constant(fmt::format("weights.{}", number_++), shape, values);
  }

  onnx::Graph& graph_;
  Random random_;
  std::size_t number_ = 0;
};

void add_pictures(onnx::Graph& graph, const std::vector<std::size_t>& shape) {
  graph.input({.name = "pictures",
               .shape = {shape.begin(), shape.end()},
               .says = "Pictures, line by line, 0 (black) to 1."});
}

/// An inverted residual with squeeze and excitation, MBConv of the paper.
struct Stage {
  std::size_t expansion, out, repeats, stride, kernel;
};

std::string add_block(onnx::Graph& graph, Layers& layers, const std::string& x, std::size_t in,
                      const Stage& stage, std::size_t stride) {
  const std::size_t wide = in * stage.expansion, squeezed = std::max<std::size_t>(1, in / 4);
  std::string y = x;
  if (stage.expansion > 1) y = layers.swish(layers.convolve(y, {.in = in, .out = wide}));
  y = layers.swish(layers.convolve(
      y, {.in = wide, .out = wide, .kernel = stage.kernel, .stride = stride, .groups = wide}));
  const std::string mean = graph.add("GlobalAveragePool", {y});
  const std::string few = layers.swish(layers.convolve(mean, {.in = wide, .out = squeezed}));
  const std::string gate = graph.add("Sigmoid", {layers.convolve(few, {.in = squeezed, .out = wide})});
  y = layers.convolve(graph.add("Mul", {y, gate}), {.in = wide, .out = stage.out});
  return stride == 1 && in == stage.out ? graph.add("Add", {x, y}) : y;
}

}  // namespace

RivalGraph rival_eye_graph(std::uint64_t seed) {
  constexpr std::size_t kEyeSide = 112, kEyePictures = 4, kNumbers = 7;
  RivalGraph rival{.onnx = {}, .input = {1, kEyePictures, kEyeSide, kEyeSide}};
  onnx::Graph graph("rival_eye", "A network of the size of open eye trackers', with random weights.");
  add_pictures(graph, rival.input);
  Layers layers(graph, seed);
  std::string x = "pictures";
  std::size_t in = kEyePictures;
  for (const std::size_t out : {14, 21, 32, 47, 70, 106}) {
    if (in != kEyePictures)
      x = graph.add("MaxPool", {x}, {{"kernel_shape", Integers{2, 2}}, {"strides", Integers{2, 2}}});
    x = graph.add("Relu", {layers.convolve(x, {.in = in, .out = out, .kernel = 3})});
    in = out;
  }
  layers.answer(graph.add("GlobalMaxPool", {x}), in, kNumbers);
  rival.onnx = graph.bytes();
  return rival;
}

RivalGraph rival_mouth_graph(std::uint64_t seed) {
  constexpr std::size_t kFaceSide = 224, kStem = 32, kHead = 1280, kShapes = 45;
  constexpr Stage kStages[] = {{1, 16, 1, 1, 3},  {6, 24, 2, 2, 3},  {6, 40, 2, 2, 5}, {6, 80, 3, 2, 3},
                               {6, 112, 3, 1, 5}, {6, 192, 4, 2, 5}, {6, 320, 1, 1, 3}};
  RivalGraph rival{.onnx = {}, .input = {1, 1, kFaceSide, kFaceSide}};
  onnx::Graph graph("rival_mouth", "EfficientNet-B0 with random weights.");
  add_pictures(graph, rival.input);
  Layers layers(graph, seed);
  std::string x =
      layers.swish(layers.convolve("pictures", {.in = 1, .out = kStem, .kernel = 3, .stride = 2}));
  std::size_t in = kStem;
  for (const Stage& stage : kStages)
    for (std::size_t i = 0; i < stage.repeats; ++i) {
      x = add_block(graph, layers, x, in, stage, i == 0 ? stage.stride : 1);
      in = stage.out;
    }
  x = layers.swish(layers.convolve(x, {.in = in, .out = kHead}));
  layers.answer(graph.add("GlobalAveragePool", {x}), kHead, kShapes);
  rival.onnx = graph.bytes();
  return rival;
}

}  // namespace mien::lab
