#include "mien/onnx/export_model.h"

#include <gmock/gmock.h>
#include <onnx/checker.h>
#include <onnx/shape_inference/implementation.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "mien/model/network_correction.h"
#include "tests/folder.h"
#include "tests/headset/small_model.h"
#include "tests/model/random_backbone.h"
#include "tests/onnx/example_models.h"
#include "tests/project_path.h"

namespace mien::onnx::export_model_test {
namespace {

using Json = nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// ONNX's own word on a file: it must hold together, and its shapes must fit each other, node by node.
void check_file(const std::vector<std::byte>& bytes) {
  ::onnx::ModelProto model = test::parsed(bytes);
  ASSERT_NO_THROW(::onnx::checker::check_model(model));
  const ::onnx::ShapeInferenceOptions strict(true, 1, true);
  ASSERT_NO_THROW(::onnx::shape_inference::InferShapes(model, ::onnx::OpSchemaRegistry::Instance(), strict));
}

std::string shape_of(const ::onnx::ValueInfoProto& port) {
  std::string text = port.name() + ":";
  for (const auto& axis : port.type().tensor_type().shape().dim())
    text += " " + (axis.has_dim_param() ? axis.dim_param() : std::to_string(axis.dim_value()));
  return text;
}
template <class Ports>
std::vector<std::string> shapes_of(const Ports& ports) {
  std::vector<std::string> texts;
  for (const auto& port : ports) {
    EXPECT_FALSE(port.doc_string().empty()) << port.name();
    texts.push_back(shape_of(port));
  }
  return texts;
}

TEST(ExportModel, ACausalNetworkTakesItsStateAndGivesTheNext) {
  const auto bytes = onnx_of(test::causal_model()).value();
  check_file(bytes);
  const auto model = test::parsed(bytes);
  EXPECT_THAT(shapes_of(model.graph().input()),
              ElementsAre("condition: batch 18", "state_0: batch 32", "state_1: batch 32"));
  EXPECT_THAT(shapes_of(model.graph().output()),
              ElementsAre("weights: batch 3", "next_state_0: batch 32", "next_state_1: batch 32"));
  EXPECT_EQ(model.opset_import(0).version(), 17);
  EXPECT_EQ(bytes, onnx_of(test::causal_model()).value()) << "the same model gives the same bytes";
}

TEST(ExportModel, AWearersCorrectionIsInTheOutputLayer) {
  model::ModelFile model = test::causal_model();
  const auto numbers_of = [](const model::ModelFile& file, const std::string& name) {
    const auto graph = test::parsed(onnx_of(file).value()).graph();
    for (const auto& constant : graph.initializer())
      if (constant.name() == name) {
        std::vector<float> values(constant.raw_data().size() / sizeof(float));
        std::memcpy(values.data(), constant.raw_data().data(), constant.raw_data().size());
        return values;
      }
    return std::vector<float>();
  };
  const std::vector<float> plain = numbers_of(model, "output.bias"),
                           plain_weights = numbers_of(model, "output.weight");
  const model::Architecture& a = model.architecture;
  model.correction = {.network = model::correction_key(model.network),
                      .weights = std::vector<float>(a.outputs * a.d_model),
                      .bias = std::vector<float>(a.outputs, 0.5F)};
  for (std::size_t i = 0; i < model.correction->weights.size(); ++i)
    model.correction->weights[i] = 0.001F * static_cast<float>(i);
  const std::vector<float> corrected = numbers_of(model, "output.bias"),
                           corrected_weights = numbers_of(model, "output.weight");
  ASSERT_EQ(corrected.size(), a.outputs);
  // The graph answers with weights, half as wide as the network's numbers.
  for (std::size_t k = 0; k < a.outputs; ++k) EXPECT_NEAR(corrected[k], plain[k] + 0.25F, 1e-6F);
  ASSERT_EQ(corrected_weights.size(), a.outputs * a.d_model);
  for (std::size_t i = 0; i < corrected_weights.size(); ++i)
    EXPECT_NEAR(corrected_weights[i], plain_weights[i] + 0.0005F * static_cast<float>(i), 1e-6F);
}

TEST(ExportModel, AWindowOfAnyLength) {
  const auto bytes = onnx_of(test::window_model()).value();
  check_file(bytes);
  const auto model = test::parsed(bytes);
  EXPECT_THAT(shapes_of(model.graph().input()),
              ElementsAre("condition: batch frames 18", "noisy: batch frames 3", "level: batch"));
  EXPECT_THAT(shapes_of(model.graph().output()), ElementsAre("clean: batch frames 3"));
}

TEST(ExportModel, TheRidgeOfAProfile) {
  const auto bytes = onnx_of(test::window_model(), {.part = "ridge.lab"}).value();
  check_file(bytes);
  const auto model = test::parsed(bytes);
  EXPECT_THAT(shapes_of(model.graph().input()), ElementsAre("condition: batch 18"));
  EXPECT_THAT(shapes_of(model.graph().output()), ElementsAre("weights: batch 3"));
  EXPECT_EQ(test::metadata(model).at("profile"), "lab");
}

TEST(ExportModel, AHeadsetsModelHasItsMemoryAndItsBackbones) {
  headset::ViewsFile file = headset::test::small_views_file();
  EXPECT_EQ(onnx_of(file).error().code, ErrorCode::not_found) << "it has no memory";
  file.memory = headset::test::small_memory();
  const auto memory = onnx_of(file), eye = onnx_of(file, {.part = "eye"}),
             mouth = onnx_of(file, {.part = "mouth"}), moment = onnx_of(file, {.part = "moment"});
  ASSERT_TRUE(memory) << memory.error().message();
  ASSERT_TRUE(eye) << eye.error().message();
  ASSERT_TRUE(mouth) << mouth.error().message();
  EXPECT_NE(*eye, *mouth);
  ASSERT_TRUE(moment) << moment.error().message();
  check_file(*moment);
  const auto of_moment = test::parsed(*moment);
  EXPECT_THAT(shapes_of(of_moment.graph().input()),
              ElementsAre("features: batch 32", "differences: batch 32"));
  EXPECT_THAT(shapes_of(of_moment.graph().output()), ElementsAre("answer: batch 62"));
  EXPECT_EQ(onnx_of(file, {.part = "ridge.lab"}).error().code, ErrorCode::not_found);
  EXPECT_EQ(onnx_of(file, {.features = true}).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(onnx_of(file, {.part = "eye", .steps = 2}).error().code, ErrorCode::bad_usage);
  const mien::test::Folder folder;
  ASSERT_TRUE(headset::write_views_file(folder / "headset.safetensors", file));
  EXPECT_EQ(onnx_of_file(folder / "headset.safetensors"), *memory);
}

TEST(ExportModel, EyewearAnswersWithMarkers) {
  const auto bytes = onnx_of(eyewear::test::small_marker_network()).value();
  check_file(bytes);
  const auto model = test::parsed(bytes);
  EXPECT_THAT(shapes_of(model.graph().input()), ElementsAre("condition: batch 6", "state_0: batch 32"));
  EXPECT_THAT(shapes_of(model.graph().output()),
              ElementsAre("displacement_m: batch 6", "next_state_0: batch 32"));
  const auto texts = test::metadata(model);
  EXPECT_EQ(texts.at("kind"), "eyewear");
  EXPECT_EQ(Json::parse(texts.at("sensors")), Json({"s0", "s1", "s2"}));
  EXPECT_EQ(Json::parse(texts.at("markers")), Json::array({"brow", "chin"}));
}

TEST(ExportModel, MetadataSaysWhatTheNumbersMean) {
  const model::ModelFile from = test::causal_model();
  const auto texts = test::metadata(test::parsed(onnx_of(from).value()));
  EXPECT_EQ(texts.at("format"), "mien-onnx");
  EXPECT_EQ(texts.at("kind"), "causal");
  EXPECT_EQ(Json::parse(texts.at("shapes")), Json(from.shapes));
  const Json features = Json::parse(texts.at("features"));
  EXPECT_EQ(features.at("sensors"), Json(from.features.sensors));
  EXPECT_EQ(features.at("mean").size(), 14u);
  EXPECT_EQ(features.at("scale")[0], 0.5);
  EXPECT_EQ(features.at("clip"), 8);
  EXPECT_EQ(features.at("presence_flags"), true);
  const auto window = test::metadata(test::parsed(onnx_of(test::window_model()).value()));
  EXPECT_EQ(Json::parse(window.at("schedule")).at("levels"), 1000);
  EXPECT_EQ(Json::parse(window.at("sampler")).at("levels").size(), 5u);
}

TEST(ExportModel, SeveralFramesInARow) {
  const auto bytes = onnx_of(test::causal_model(), {.steps = 4}).value();
  check_file(bytes);
  const auto model = test::parsed(bytes);
  EXPECT_EQ(shape_of(model.graph().input(0)), "condition: steps_times_batch 18");
  EXPECT_EQ(shape_of(model.graph().input(1)), "state_0: batch 32");
  EXPECT_EQ(shape_of(model.graph().output(0)), "weights: steps_times_batch 3");
  EXPECT_EQ(model.graph().initializer_size(),
            test::parsed(onnx_of(test::causal_model()).value()).graph().initializer_size())
      << "the weights stand in it once";
}

TEST(ExportModel, WhatSensorsSayInsteadOfTheCondition) {
  for (const model::ModelFile& from : {test::causal_model(), test::window_model()}) {
    const auto bytes = onnx_of(from, {.features = true}).value();
    check_file(bytes);
    const auto model = test::parsed(bytes);
    EXPECT_THAT(shape_of(model.graph().input(0)), HasSubstr("features: batch"));
    EXPECT_THAT(shape_of(model.graph().input(0)), HasSubstr(" 14"));
    EXPECT_THAT(shape_of(model.graph().input(1)), HasSubstr(" 4"));
    check_file(onnx_of(from, {.part = "ridge.lab", .features = true}).value());
  }
}

TEST(ExportModel, AnEchoHasTheSameInputs) {
  const auto bytes = onnx_of(test::causal_model(), {.steps = 4}).value();
  const auto echo = echo_of(bytes).value();
  check_file(echo);
  EXPECT_EQ(shapes_of(test::parsed(echo).graph().input()), shapes_of(test::parsed(bytes).graph().input()));
  EXPECT_LT(echo.size(), 10'000u) << "no weights are in it";
  EXPECT_EQ(echo_of(std::as_bytes(std::span("no such file"))).error().code, ErrorCode::malformed);
}

TEST(ExportModel, RefusesWhatCannotBeMeant) {
  const auto code = [](const ExportRequest& request, const model::ModelFile& model) {
    const auto made = onnx_of(model, request);
    return made ? ErrorCode::internal : made.error().code;
  };
  const model::ModelFile causal = test::causal_model(), window = test::window_model();
  EXPECT_EQ(code({.part = "ridge.device"}, causal), ErrorCode::not_found);
  EXPECT_EQ(code({.part = "nose"}, causal), ErrorCode::not_found);
  EXPECT_EQ(code({.part = ""}, causal), ErrorCode::not_found);
  EXPECT_EQ(code({.steps = 0}, causal), ErrorCode::out_of_range);
  EXPECT_EQ(code({.steps = kMostSteps + 1}, causal), ErrorCode::out_of_range);
  EXPECT_EQ(code({.steps = 2}, window), ErrorCode::bad_usage);
  EXPECT_EQ(code({.part = "ridge.lab", .steps = 2}, causal), ErrorCode::bad_usage);
  model::ModelFile broken = causal;
  broken.network.pop_back();
  EXPECT_EQ(code({}, broken), ErrorCode::mismatch);
  broken = causal;
  broken.architecture.d_model = 33;
  EXPECT_EQ(code({}, broken), ErrorCode::out_of_range);

  const auto glasses = eyewear::test::small_marker_network();
  EXPECT_EQ(onnx_of(glasses, {.features = true}).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(onnx_of(glasses, {.part = "ridge.lab"}).error().code, ErrorCode::not_found);
}

TEST(ExportModel, ReadsFilesOfEitherFormatAndNoOther) {
  const mien::test::Folder folder;
  ASSERT_TRUE(model::write_model(folder / "causal.safetensors", test::causal_model()));
  ASSERT_TRUE(
      eyewear::write_marker_network(folder / "eyewear.safetensors", eyewear::test::small_marker_network()));
  EXPECT_EQ(onnx_of_file(folder / "causal.safetensors"), onnx_of(test::causal_model()));
  EXPECT_EQ(onnx_of_file(folder / "eyewear.safetensors"), onnx_of(eyewear::test::small_marker_network()));
  EXPECT_EQ(onnx_of_file(folder / "missing.safetensors").error().code, ErrorCode::not_found);
  EXPECT_EQ(onnx_of_file(project_path("README.md")).error().code, ErrorCode::malformed);
}

TEST(ExportModel, ABackboneTakesPictures) {
  const model::BackboneShape shape{.size = 32, .widths = {4, 8}, .features = 6};
  const auto tensors = model::random_backbone(shape, 1);
  const auto bytes = onnx_of(shape, tensors).value();
  check_file(bytes);
  const auto model = test::parsed(bytes);
  EXPECT_THAT(shapes_of(model.graph().input()), ElementsAre("pictures: batch 1 32 32"));
  EXPECT_THAT(shapes_of(model.graph().output()), ElementsAre("features: batch 6"));
  EXPECT_EQ(test::metadata(model).at("kind"), "backbone");
  EXPECT_EQ(onnx_of({.size = 64, .widths = {4, 8}, .features = 6}, tensors).error().code,
            ErrorCode::mismatch);
  EXPECT_EQ(onnx_of({.size = 1}, tensors).error().code, ErrorCode::out_of_range);
}

}  // namespace
}  // namespace mien::onnx::export_model_test
