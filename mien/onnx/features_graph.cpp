#include "mien/onnx/features_graph.h"

#include <nlohmann/json.hpp>

namespace mien::onnx {

std::string add_features(Graph& graph, const model::FeatureLayout& layout,
                         const model::FeatureNormalisation& normalisation, const std::vector<Axis>& rows) {
  const std::size_t n = layout.sensors.size();
  const auto with = [&](std::size_t width) {
    std::vector<Axis> shape = rows;
    shape.emplace_back(width);
    return shape;
  };
  graph.input(
      {.name = "features",
       .shape = with(layout.value_count()),
       .says = "Of each sensor in metadata `features`' order: linear acceleration xyz relative to the head, "
               "m/s^2, and the skin's rotation from neutral wxyz, unit, w >= 0; both in the head's frame: +X "
               "the performer's left, +Y up, +Z forward. What is missing may be anything."});
  graph.input(
      {.name = "present",
       .shape = with(2 * n),
       .says = "1 where it is there, else 0: the rotation of each sensor, then the acceleration of each."});

  const std::string mean = graph.constant("features.mean", {layout.value_count()}, normalisation.mean);
  const std::string scale = graph.constant("features.scale", {layout.value_count()}, normalisation.scale);
  std::vector<std::int64_t> flag_of_value;
  for (std::size_t s = 0; s < n; ++s)
    for (std::size_t i = 0; i < 7; ++i) flag_of_value.push_back(static_cast<std::int64_t>(i < 3 ? n + s : s));
  const std::string flags = graph.constant("features.flag", flag_of_value);

  const Attribute last = {"axis", std::int64_t{-1}};
  const std::string there = graph.add("Greater", {"present", graph.scalar("features.half", 0.5F)});
  const std::string held = graph.add("Clip", {graph.add("Div", {graph.add("Sub", {"features", mean}), scale}),
                                              graph.scalar("features.low", -model::kFeatureClip),
                                              graph.scalar("features.high", model::kFeatureClip)});
  const std::string values = graph.add(
      "Where", {graph.add("Gather", {there, flags}, {last}), held, graph.scalar("features.missing", 0)});
  if (!layout.presence_flags) return values;
  const std::string as_numbers =
      graph.add("Cast", {there}, {{"to", std::int64_t{::onnx::TensorProto::FLOAT}}});
  return graph.add("Concat", {values, as_numbers}, {last});
}

std::string describe_features(const model::FeatureLayout& layout,
                              const model::FeatureNormalisation& normalisation) {
  return nlohmann::json{
      {"sensors", layout.sensors},
      {"values_of_a_sensor",
       {"accel_x", "accel_y", "accel_z", "rotation_w", "rotation_x", "rotation_y", "rotation_z"}},
      {"presence_flags", layout.presence_flags},
      {"mean", normalisation.mean},
      {"scale", normalisation.scale},
      {"clip", model::kFeatureClip}}
      .dump();
}

}  // namespace mien::onnx
