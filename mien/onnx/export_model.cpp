#include "mien/onnx/export_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "mien/core/files.h"
#include "mien/model/network_correction.h"
#include "mien/model/network_parts.h"
#include "mien/onnx/causal_graph.h"
#include "mien/onnx/graph.h"
#include "mien/onnx/window_graph.h"

namespace mien::onnx {
namespace {

using Json = nlohmann::json;

constexpr const char* kWeightsSay =
    "The weights of metadata `shapes`, in that order, 0 to 1; of several steps, a step's rows together.";

/// What every file says of itself.
void tell_kind(Graph& graph, const char* kind) {
  graph.tell("format", "mien-onnx");
  graph.tell("version", "1");
  graph.tell("kind", kind);
  graph.tell("rate_hz", "60");
}

/// The layout and the normalisation as JSON, for the file's metadata.
std::string describe_features(const model::FeatureLayout& layout,
                              const model::FeatureNormalisation& normalisation) {
  return Json{{"sensors", layout.sensors},
              {"values_of_a_sensor",
               {"accel_x", "accel_y", "accel_z", "rotation_w", "rotation_x", "rotation_y", "rotation_z"}},
              {"presence_flags", layout.presence_flags},
              {"mean", normalisation.mean},
              {"scale", normalisation.scale},
              {"clip", model::kFeatureClip}}
      .dump();
}

void tell_model(Graph& graph, const model::ModelFile& model) {
  graph.tell("shapes", Json(model.shapes).dump());
  graph.tell("features", describe_features(model.features, model.normalisation));
  graph.tell("mean_pose", Json(model.mean_pose).dump());
}

/// Adds the way from what sensors say to the condition, as model::encode_features goes: inputs `features`,
/// 7n numbers a frame, and `present`, 2n. `rows`: the axes before these. Returns the condition's name.
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

/// The input that the network reads, or those that it is made of; `rows`: the axes before a frame's numbers.
std::string add_condition(Graph& graph, const model::ModelFile& model, bool features,
                          const std::vector<Axis>& rows) {
  if (features) return add_features(graph, model.features, model.normalisation, rows);
  std::vector<Axis> shape = rows;
  shape.emplace_back(model.architecture.condition);
  graph.input(
      {.name = "condition",
       .shape = shape,
       .says = "A frame of features as metadata `features` says: of each sensor acceleration xyz (m/s^2) and "
               "rotation wxyz, less mean, over scale, held to +-clip, 0 where missing; then, with "
               "presence_flags, 1 or 0 for each sensor's rotation, then for each one's acceleration."});
  return "condition";
}

const char* rows_of(const ExportRequest& request) {
  return request.steps == 1 ? "batch" : "steps_times_batch";
}

Result<void> check(const ExportRequest& request, bool has_state) {
  if (request.steps < 1 || request.steps > kMostSteps)
    return fail(ErrorCode::out_of_range, fmt::format("{} steps are not 1 to {}", request.steps, kMostSteps));
  if (request.steps > 1 && !has_state)
    return fail(ErrorCode::bad_usage, "only a causal network's steps can be chained", request.part,
                "leave the chain out");
  return {};
}

std::vector<std::byte> ridge_graph(const model::ModelFile& model, const model::RidgeBaseline& ridge,
                                   bool features) {
  Graph graph("mien_ridge", "Weights linear in one frame: the baseline beside a model of Mien.");
  tell_kind(graph, "ridge");
  tell_model(graph, model);
  graph.tell("profile", ridge.profile);
  const std::string condition = add_condition(graph, model, features, {"batch"});
  std::vector<float> weight, bias;
  for (std::size_t o = 0; o < ridge.outputs; ++o) {
    const auto row = ridge.matrix.begin() + static_cast<std::ptrdiff_t>(o * (ridge.condition + 1));
    weight.insert(weight.end(), row, row + static_cast<std::ptrdiff_t>(ridge.condition));
    bias.push_back(row[static_cast<std::ptrdiff_t>(ridge.condition)]);
  }
  const std::string sum =
      graph.gemm(condition, graph.constant("weight", {ridge.outputs, ridge.condition}, weight),
                 graph.constant("bias", {ridge.outputs}, bias));
  graph.add("Clip", {sum, graph.scalar("zero", 0), graph.scalar("one", 1)}, {}, "weights");
  graph.output({.name = "weights", .shape = {"batch", ridge.outputs}, .says = kWeightsSay});
  return graph.bytes();
}

std::vector<std::byte> causal_graph(const model::ModelFile& model, const ExportRequest& request) {
  Graph graph("mien_causal", "A causal network of Mien: weights of each frame of 1/60 s when it comes.");
  tell_kind(graph, "causal");
  tell_model(graph, model);
  graph.tell("architecture", model::format_architecture(model.architecture));
  graph.tell("steps", std::to_string(request.steps));
  const std::string condition = add_condition(graph, model, request.features, {rows_of(request)});
  // The network's numbers are 2 w - 1.
  const std::vector<model::Tensor> network =
      model.correction ? model::corrected_network(model.network, *model.correction) : model.network;
  add_causal_network(graph, model.architecture, network, condition,
                     {.name = "weights", .says = kWeightsSay, .factor = 0.5F, .shift = 0.5F, .held = true},
                     request.steps);
  return graph.bytes();
}

std::vector<std::byte> window_graph(const model::ModelFile& model, bool features) {
  Graph graph(
      "mien_window",
      "One step of a window network of Mien: a noisy window and its condition in, the clean one out.");
  tell_kind(graph, "window");
  tell_model(graph, model);
  graph.tell("architecture", model::format_architecture(model.architecture));
  graph.tell("schedule", Json{{"levels", model.schedule.levels}, {"offset", model.schedule.offset}}.dump());
  graph.tell("sampler", Json{{"kind", model.sampler.kind == model::SamplerKind::ddpm ? "ddpm" : "ddim"},
                             {"levels", model::sampler_levels(model.sampler, model.schedule.levels)},
                             {"first_noise", model.sampler.first_noise}}
                            .dump());
  const std::string condition = add_condition(graph, model, features, {"batch", "frames"});
  add_window_network(graph, model.architecture, model.network, condition, model.schedule.levels);
  return graph.bytes();
}

}  // namespace

Result<std::vector<std::byte>> onnx_of(const model::ModelFile& model, const ExportRequest& request) {
  constexpr std::string_view kRidge = "ridge.";
  MIEN_TRY(model::check(model.architecture));
  MIEN_TRY(model::check_tensors(model.architecture, model.network));
  if (request.part.starts_with(kRidge)) {
    MIEN_TRY(check(request, false));
    if (const model::RidgeBaseline* ridge =
            model.ridge_for(std::string_view(request.part).substr(kRidge.size())))
      return ridge_graph(model, *ridge, request.features);
  }
  if (request.part != "network")
    return fail(ErrorCode::not_found, "the model has no such part", request.part,
                "use network, or ridge. and a profile");
  switch (model.architecture.kind) {
    case model::NetworkKind::causal:
      MIEN_TRY(check(request, true));
      return causal_graph(model, request);
    case model::NetworkKind::window:
      MIEN_TRY(check(request, false));
      return window_graph(model, request.features);
    case model::NetworkKind::views:  // Its backbones have graphs of their own.
      break;
  }
  return fail(ErrorCode::unsupported, "there is no ONNX form of this kind of network");
}

Result<std::vector<std::byte>> onnx_of(const eyewear::MarkerNetworkFile& model,
                                       const ExportRequest& request) {
  MIEN_TRY(model::check(model.architecture));
  MIEN_TRY(model::check_tensors(model.architecture, model.network));
  MIEN_TRY(check(request, true));
  if (request.part != "network")
    return fail(ErrorCode::not_found, "the model has no such part", request.part, "use network");
  if (request.features)
    return fail(ErrorCode::bad_usage,
                "the light of eyewear is normalised by a wearer's calibration, not by the model", {},
                "leave the features out");
  Graph graph("mien_eyewear",
              "A network of Mien for smart eyewear: light to markers on the skin, frame by frame.");
  tell_kind(graph, "eyewear");
  graph.tell("sensors", Json(model.sensors).dump());
  graph.tell("markers", Json(model.markers).dump());
  graph.tell("architecture", model::format_architecture(model.architecture));
  graph.tell("steps", std::to_string(request.steps));
  graph.input({.name = "condition",
               .shape = {rows_of(request), model.architecture.condition},
               .says = "Two numbers a sensor, in metadata `sensors`' order: (log light - neutral) / range of "
                       "the wearer, 0 "
                       "where it is missing, and 1 where it is there, else 0."});
  add_causal_network(
      graph, model.architecture, model.network, "condition",
      {.name = "displacement_m",
       .says = "Displacement from neutral, xyz of each marker in metadata `markers`' order, metres in the "
               "head's frame (+X the performer's left, +Y up, +Z forward), on Mien's built-in face.",
       .factor = static_cast<float>(model.scale_m)},
      request.steps);
  return graph.bytes();
}

Result<std::vector<std::byte>> onnx_of(const model::BackboneShape& shape,
                                       std::span<const model::Tensor> tensors) {
  MIEN_TRY(model::check(shape));
  MIEN_TRY(model::check_tensors(model::tensor_specs(shape), tensors));
  Graph graph("mien_backbone", "A network of Mien that looks at a camera's picture.");
  tell_kind(graph, "backbone");
  graph.input({.name = "pictures",
               .shape = {"batch", std::size_t{1}, shape.size, shape.size},
               .says = "Pictures, line by line, 0 (black) to 1."});
  using Integers = std::vector<std::int64_t>;
  for (const model::Tensor& tensor : tensors) graph.constant(tensor.name, tensor.shape, tensor.values);
  std::string x = "pictures";
  for (std::size_t i = 0; i < shape.widths.size(); ++i) {
    const std::string sum = graph.add(
        "Conv", {x, tensors[2 * i].name, tensors[2 * i + 1].name},
        {{"kernel_shape", Integers{3, 3}}, {"strides", Integers{2, 2}}, {"pads", Integers{1, 1, 1, 1}}});
    x = graph.add("Relu", {sum});
  }
  x = graph.add("Flatten", {x}, {{"axis", std::int64_t{1}}});
  graph.gemm(x, tensors[tensors.size() - 2].name, tensors.back().name, "features");
  graph.output({.name = "features",
                .shape = {"batch", shape.features},
                .says = "What the picture shows, in the network's own terms."});
  return graph.bytes();
}

namespace {

/// How a headset's answer is read.
constexpr const char* kHeadsetAnswer =
    "53 weights and the tongue as 2 w - 1; yaw and pitch of the left and the right eye over 0.7 rad; "
    "openness "
    "of both as 2 (o / 1.5) - 1; pupils as (mm - 4.5) / 3.5";

/// What a network of pictures answers to what its backbones found.
Result<std::vector<std::byte>> onnx_of_moment(const headset::ViewsFile& model, const ExportRequest& request) {
  MIEN_TRY(check(request, false));
  Graph graph("mien_headset_moment",
              "A network of Mien for a headset's cameras: what is found in their views to the face.");
  tell_kind(graph, "headset_moment");
  const std::size_t found = model::kViews * model.architecture.features;
  graph.input({.name = "features",
               .shape = {"batch", found},
               .says = "Features of four views: left eye, right eye, left half of the mouth, right half."});
  graph.input({.name = "differences",
               .shape = {"batch", found},
               .says = "The same less those of the face at rest; 0 where either is not known."});
  const auto constant = [&](const std::string& name) {
    const auto tensor = std::ranges::find(model.network, name, &model::Tensor::name);
    return graph.constant(name, tensor->shape, tensor->values);
  };
  const std::string read = graph.add("Concat", {"features", "differences"}, {{"axis", std::int64_t{1}}});
  const std::string hidden =
      graph.add("Relu", {graph.gemm(read, constant("hidden.weight"), constant("hidden.bias"))});
  graph.gemm(hidden, constant("output.weight"), constant("output.bias"), "answer");
  graph.output({.name = "answer",
                .shape = {"batch", model.architecture.outputs},
                .says = fmt::format("{}.", kHeadsetAnswer)});
  // Tokens of views that are missing, which stand for their features.
  const auto missing = std::ranges::find(model.network, "missing", &model::Tensor::name);
  graph.tell("missing", Json(missing->values).dump());
  return graph.bytes();
}

}  // namespace

Result<std::vector<std::byte>> onnx_of(const headset::ViewsFile& model, const ExportRequest& request) {
  MIEN_TRY(model::check(model.architecture));
  MIEN_TRY(model::check_tensors(model.architecture, model.network));
  if (request.features)
    return fail(ErrorCode::bad_usage, "what is found in pictures is normalised by nothing", {},
                "leave the features out");
  const model::BackboneShape shape = model::backbone_shape(model.architecture);
  const std::vector<model::TensorSpec> specs = model::tensor_specs(shape);
  for (const std::string_view part : {"eye", "mouth"}) {
    if (request.part != part) continue;
    MIEN_TRY(check(request, false));
    std::vector<model::Tensor> tensors;
    for (const model::TensorSpec& spec : specs) {
      const auto found =
          std::ranges::find(model.network, fmt::format("{}.{}", part, spec.name), &model::Tensor::name);
      tensors.push_back({.name = spec.name, .shape = spec.shape, .values = found->values});
    }
    return onnx_of(shape, tensors);
  }
  if (request.part == "moment") return onnx_of_moment(model, request);
  if (request.part != "network" || !model.memory)
    return fail(
        ErrorCode::not_found, "the model has no such part", request.part,
        model.memory ? "use network, moment, eye or mouth" : "use moment, eye or mouth: it has no memory");
  const headset::ViewsMemory& memory = *model.memory;
  MIEN_TRY(check(request, true));
  MIEN_TRY(model::check(memory.architecture));
  MIEN_TRY(model::check_tensors(memory.architecture, memory.network));
  Graph graph("mien_headset",
              "A network of Mien for a headset's cameras: what is found in their views to the face, frame by "
              "frame of 1/60 s.");
  tell_kind(graph, "headset");
  graph.tell("architecture", model::format_architecture(memory.architecture));
  graph.tell("steps", std::to_string(request.steps));
  graph.input({.name = "condition",
               .shape = {rows_of(request), memory.architecture.condition},
               .says =
                   "Features of four views (left eye, right eye, left half of the mouth, right half), the "
                   "same less those of the face at rest (0 where unknown), of each view its age (shares of "
                   "0.1 s, 1 where it is missing) and whether it is there (0 or 1), whether the face at rest "
                   "is known (0 or 1), and the answer of the graph `moment` to them."});
  add_causal_network(
      graph, memory.architecture, memory.network, "condition",
      {.name = "answer",
       .says =
           fmt::format("To be added to the moment's answer, which has {}, each times 1 - the sigmoid of its "
                       "region's logit (the tongue's is the jaw's, of directions the gaze's, of lids' gaps "
                       "and pupils the eyes'); then six "
                       "logits, of brows, eyes, cheeks, mouth, jaw and gaze, to be made probabilities by the "
                       "maps in metadata `judgements` (offset, slope).",
                       kHeadsetAnswer),
       .factor = 1},
      request.steps);
  Json maps = Json::array();
  for (const model::LogisticMap& map : memory.judgements) maps.push_back({map.offset, map.slope});
  graph.tell("judgements", maps.dump());
  return graph.bytes();
}

Result<std::vector<std::byte>> onnx_of_file(const std::filesystem::path& path, const ExportRequest& request) {
  MIEN_TRY_ASSIGN(const std::vector<std::byte> bytes, read_file(path));
  const std::string where = path.string();
  const auto model = model::parse_model(bytes, where);
  if (model) return onnx_of(*model, request);
  // Each format refuses others by their name; what is wrong with one of its own files is its to say.
  const auto markers = eyewear::parse_marker_network(bytes, where);
  if (markers) return onnx_of(*markers, request);
  const auto views = headset::parse_views_file(bytes, where);
  if (views) return onnx_of(*views, request);
  for (const Error* error : {&markers.error(), &views.error()})
    if (error->code != ErrorCode::unsupported) return std::unexpected(*error);
  return std::unexpected(model.error());
}

Result<std::vector<std::byte>> echo_of(std::span<const std::byte> onnx) {
  ::onnx::ModelProto model;
  if (!model.ParseFromArray(onnx.data(), static_cast<int>(onnx.size())))
    return fail(ErrorCode::malformed, "these bytes are not an ONNX file");
  ::onnx::GraphProto& graph = *model.mutable_graph();
  graph.clear_node();
  graph.clear_initializer();
  graph.clear_output();
  for (const ::onnx::ValueInfoProto& input : graph.input()) {
    ::onnx::ValueInfoProto& output = *graph.add_output();
    output = input;
    output.set_name("same_" + input.name());
    ::onnx::NodeProto& node = *graph.add_node();
    node.set_op_type("Identity");
    node.add_input(input.name());
    node.add_output(output.name());
  }
  const std::string text = model.SerializeAsString();
  const auto bytes = std::as_bytes(std::span(text));
  return std::vector<std::byte>(bytes.begin(), bytes.end());
}

}  // namespace mien::onnx
