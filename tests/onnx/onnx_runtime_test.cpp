// Exported files in ONNX Runtime against our own run time, on random input.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "mien/core/files.h"
#include "mien/core/random.h"
#include "mien/headset/views_file.h"
#include "mien/model/causal_network.h"
#include "mien/model/denoiser.h"
#include "mien/model/views_network.h"
#include "mien/onnx/export_model.h"
#include "tests/folder.h"
#include "tests/model/random_backbone.h"
#include "tests/onnx/example_models.h"
#include "tests/project_path.h"

namespace mien::onnx::onnx_runtime_test {
namespace {

using Json = nlohmann::json;
using Floats = std::vector<float>;

constexpr double kLimit = 1e-4;

bool installed() {
  return std::filesystem::exists(project_path("script/onnxruntime/node_modules/onnxruntime-node")) &&
         std::system("node --version > /dev/null 2>&1") == 0;
}
#define MIEN_SKIP_WITHOUT_ONNX_RUNTIME() \
  if (!installed()) GTEST_SKIP() << "no node, or no ONNX Runtime: run script/bootstrap"

/// What an exported file answers to calls: see script/onnxruntime/replay.mjs.
Json replay(const std::vector<std::byte>& onnx, const Json& calls) {
  const mien::test::Folder folder;
  EXPECT_TRUE(write_file(folder / "model.onnx", onnx));
  EXPECT_TRUE(write_file(folder / "calls.json", calls.dump()));
  const std::string command = fmt::format("node '{}/script/onnxruntime/replay.mjs' '{}' '{}' > '{}'",
                                          project_path(""), (folder / "model.onnx").string(),
                                          (folder / "calls.json").string(), (folder / "out").string());
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  std::ifstream answer(folder / "out");
  return Json::parse(answer, nullptr, false);
}

Json tensor(std::vector<std::size_t> dims, const Floats& data) {
  return {{"dims", std::move(dims)}, {"data", data}};
}

double largest_difference(const Json& answer, const Floats& expected) {
  const auto data = answer.at("data").get<Floats>();
  if (data.size() != expected.size()) return std::numeric_limits<double>::infinity();
  double largest = 0;
  for (std::size_t i = 0; i < data.size(); ++i)
    largest = std::max(largest, std::abs(double{data[i]} - double{expected[i]}));
  return largest;
}

Floats noise(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  Floats values(count);
  for (float& v : values) v = static_cast<float>(random.normal());
  return values;
}

/// What becomes of a number of the network.
using Answer = std::function<float(float)>;

/// The run time over frames of one performance: what the graph's answer should be.
Floats run_causal(const model::Architecture& a, const std::vector<model::Tensor>& tensors,
                  const Floats& conditions, const Answer& answer) {
  const model::CausalNetwork network = model::CausalNetwork::create(a, tensors).value();
  model::CausalNetwork::State state(network);
  Floats all, one(a.outputs);
  for (std::size_t at = 0; at < conditions.size(); at += a.condition) {
    network.step(std::span(conditions).subspan(at, a.condition), state, one);
    for (const float y : one) all.push_back(answer(y));
  }
  return all;
}

/// Frame by frame for two performances at a time; the largest difference over all.
double causal_difference(const std::vector<std::byte>& onnx, const std::string& output,
                         const model::Architecture& a, const std::vector<model::Tensor>& tensors,
                         std::size_t frames, const Answer& answer) {
  const Floats first = noise(frames * a.condition, 5), second = noise(frames * a.condition, 6);
  Json calls = Json::array();
  for (std::size_t f = 0; f < frames; ++f) {
    Floats both;
    for (const Floats* one : {&first, &second})
      both.insert(both.end(), one->begin() + static_cast<std::ptrdiff_t>(f * a.condition),
                  one->begin() + static_cast<std::ptrdiff_t>((f + 1) * a.condition));
    calls.push_back({{"condition", tensor({2, a.condition}, both)}});
  }
  const Json answers = replay(onnx, calls);
  const Floats one = run_causal(a, tensors, first, answer), other = run_causal(a, tensors, second, answer);
  double largest = answers.size() == frames ? 0 : std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < answers.size(); ++f) {
    Floats expected;
    for (const Floats* from : {&one, &other})
      expected.insert(expected.end(), from->begin() + static_cast<std::ptrdiff_t>(f * a.outputs),
                      from->begin() + static_cast<std::ptrdiff_t>((f + 1) * a.outputs));
    largest = std::max(largest, largest_difference(answers[f].at(output), expected));
  }
  return largest;
}

struct WindowCall {
  std::size_t frames, level;
};

double window_difference(const model::ModelFile& model, const std::vector<WindowCall>& windows) {
  const model::Architecture& a = model.architecture;
  const model::Denoiser denoiser = model::Denoiser::create(a, model.network).value();
  model::Denoiser::Workspace workspace(denoiser);
  Json calls = Json::array();
  std::vector<Floats> expected;
  for (const auto& [frames, level] : windows) {
    const Floats condition = noise(frames * a.condition, 7 + frames),
                 noisy = noise(frames * a.outputs, level);
    calls.push_back({{"noisy", tensor({1, frames, a.outputs}, noisy)},
                     {"condition", tensor({1, frames, a.condition}, condition)},
                     {"level", tensor({1}, {static_cast<float>(level)})}});
    denoiser.set_condition(condition, workspace);
    denoiser.predict(noisy, level, expected.emplace_back(noisy.size()), workspace);
  }
  const Json answers = replay(onnx_of(model).value(), calls);
  double largest = answers.size() == windows.size() ? 0 : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < answers.size(); ++i)
    largest = std::max(largest, largest_difference(answers[i].at("clean"), expected[i]));
  return largest;
}

double ridge_difference(const model::ModelFile& model, const model::RidgeBaseline& ridge) {
  constexpr std::size_t kFrames = 300;
  const Floats conditions = noise(kFrames * ridge.condition, 9);
  Floats expected(kFrames * ridge.outputs);
  for (std::size_t f = 0; f < kFrames; ++f)
    ridge.predict(std::span(conditions).subspan(f * ridge.condition, ridge.condition),
                  std::span(expected).subspan(f * ridge.outputs, ridge.outputs));
  const Json answers = replay(onnx_of(model, {.part = "ridge." + ridge.profile}).value(),
                              Json::array({{{"condition", tensor({kFrames, ridge.condition}, conditions)}}}));
  return largest_difference(answers.at(0).at("weights"), expected);
}

double moment_difference(const headset::ViewsFile& file) {
  constexpr std::size_t kMoments = 40;
  const model::ViewsNetwork network = model::ViewsNetwork::create(file.architecture, file.network).value();
  model::ViewsNetwork::Workspace workspace(network);
  const std::size_t count = model::kViews * file.architecture.features;
  const Floats features = noise(kMoments * count, 10), differences = noise(kMoments * count, 11);
  Floats expected(kMoments * file.architecture.outputs);
  for (std::size_t m = 0; m < kMoments; ++m)
    network.answer(std::span(features).subspan(m * count, count),
                   std::span(differences).subspan(m * count, count), workspace,
                   std::span(expected).subspan(m * file.architecture.outputs, file.architecture.outputs));
  const Json answers = replay(onnx_of(file, {.part = "moment"}).value(),
                              Json::array({{{"features", tensor({kMoments, count}, features)},
                                            {"differences", tensor({kMoments, count}, differences)}}}));
  return largest_difference(answers.at(0).at("answer"), expected);
}

/// What was measured, for the eyes of who runs it and for docs/method/onnx.md.
void expect_parity(const std::string& what, double difference) {
  fmt::print("{}: largest difference {:.2g}\n", what, difference);
  EXPECT_LE(difference, kLimit) << what;
}

TEST(OnnxRuntime, ACausalNetworkFrameByFrame) {
  MIEN_SKIP_WITHOUT_ONNX_RUNTIME();
  const model::ModelFile model = test::causal_model();
  expect_parity("small causal", causal_difference(onnx_of(model).value(), "weights", model.architecture,
                                                  model.network, 300, model::from_network));
}

TEST(OnnxRuntime, AWindowOfAnyLengthAtAnyLevel) {
  MIEN_SKIP_WITHOUT_ONNX_RUNTIME();
  expect_parity("small window",
                window_difference(test::window_model(), {{8, 0}, {8, 999}, {5, 400}, {1, 10}}));
}

TEST(OnnxRuntime, TheModelsThatAreInstalled) {
  MIEN_SKIP_WITHOUT_ONNX_RUNTIME();
  const auto model_of = [](const char* name) {
    return model::read_model(std::filesystem::path(project_path("models")) / name).value();
  };
  const model::ModelFile live = model_of("live.safetensors"), window = model_of("default.safetensors");
  expect_parity("live.safetensors, 2 x 300 frames",
                causal_difference(onnx_of(live).value(), "weights", live.architecture, live.network, 300,
                                  model::from_network));
  expect_parity(
      "default.safetensors, windows of 120, 60 and 1 frames",
      window_difference(window, {{120, 0}, {120, 250}, {120, 500}, {120, 999}, {60, 999}, {1, 999}}));
  for (const model::ModelFile* model : {&live, &window})
    for (const model::RidgeBaseline& ridge : model->ridge)
      expect_parity("ridge." + ridge.profile + ", 300 frames", ridge_difference(*model, ridge));
  const auto glasses = eyewear::read_marker_network(project_path("models/eyewear.safetensors")).value();
  const auto scale = static_cast<float>(glasses.scale_m);
  expect_parity("eyewear.safetensors, 2 x 300 frames, of the network's unit",
                causal_difference(onnx_of(glasses).value(), "displacement_m", glasses.architecture,
                                  glasses.network, 300, [&](float y) { return scale * y; }) /
                    glasses.scale_m);
  const auto headset = headset::read_views_file(project_path("models/headset.safetensors")).value();
  ASSERT_TRUE(headset.memory);
  expect_parity("headset.safetensors, its memory, 2 x 300 frames, of the network's unit",
                causal_difference(onnx_of(headset).value(), "answer", headset.memory->architecture,
                                  headset.memory->network, 300, [](float y) { return y; }));
  expect_parity("headset.safetensors, what it answers to 40 moments", moment_difference(headset));
}

TEST(OnnxRuntime, StepsInOneGraphAreTheStepsOneByOne) {
  MIEN_SKIP_WITHOUT_ONNX_RUNTIME();
  constexpr std::size_t kSteps = 16;
  const model::ModelFile model = test::causal_model();
  const model::Architecture& a = model.architecture;
  const Floats conditions = noise(kSteps * a.condition, 8);
  Json call = {{"condition", tensor({kSteps, a.condition}, conditions)}};
  for (std::size_t i = 0; i < a.layers; ++i)
    call[fmt::format("state_{}", i)] = tensor({1, a.d_model}, Floats(a.d_model));
  const Json answers = replay(onnx_of(model, {.steps = kSteps}).value(), Json::array({call}));
  EXPECT_LE(largest_difference(answers.at(0).at("weights"),
                               run_causal(a, model.network, conditions, model::from_network)),
            kLimit);
}

TEST(OnnxRuntime, WhatSensorsSayBecomesTheCondition) {
  MIEN_SKIP_WITHOUT_ONNX_RUNTIME();
  const model::ModelFile model = test::causal_model();
  const model::Architecture& a = model.architecture;
  constexpr std::size_t kFrames = 40;
  const std::size_t sensors = model.features.sensors.size();
  Random random(2);
  Json calls = Json::array();
  Floats conditions(kFrames * a.condition);
  for (std::size_t f = 0; f < kFrames; ++f) {
    // Loud enough that some are held to the clip.
    Floats values = noise(7 * sensors, f);
    for (float& v : values) v *= 5;
    std::vector<std::uint8_t> present(2 * sensors);
    for (auto& flag : present) flag = random.uniform() < 0.7 ? 1 : 0;
    model::encode_values(model.features, model.normalisation, values, present,
                         std::span(conditions).subspan(f * a.condition, a.condition));
    // What is missing may be anything.
    if (present[sensors] == 0) values[0] = 1e30F;
    calls.push_back({{"features", tensor({1, values.size()}, values)},
                     {"present", tensor({1, present.size()}, {present.begin(), present.end()})}});
  }
  const Json answers = replay(onnx_of(model, {.features = true}).value(), calls);
  const Floats expected = run_causal(a, model.network, conditions, model::from_network);
  ASSERT_EQ(answers.size(), kFrames);
  for (std::size_t f = 0; f < kFrames; ++f) {
    const auto from = expected.begin() + static_cast<std::ptrdiff_t>(f * a.outputs);
    EXPECT_LE(
        largest_difference(answers[f].at("weights"), {from, from + static_cast<std::ptrdiff_t>(a.outputs)}),
        kLimit)
        << f;
  }
}

TEST(OnnxRuntime, PicturesGiveTheSameFeatures) {
  MIEN_SKIP_WITHOUT_ONNX_RUNTIME();
  for (const model::BackboneShape& shape :
       {model::BackboneShape{}, model::BackboneShape{.size = 33, .widths = {5, 20, 7}, .features = 9}}) {
    const auto tensors = model::random_backbone(shape, 5);
    const model::Backbone backbone = model::Backbone::create(shape, tensors).value();
    model::Backbone::Workspace workspace(backbone, 2);
    const Floats pictures = noise(2 * shape.size * shape.size, 9);
    Floats features(2 * shape.features);
    backbone.apply(pictures, workspace, features);
    const Json call = {{"pictures", tensor({2, 1, shape.size, shape.size}, pictures)}};
    const Json answers = replay(onnx_of(shape, tensors).value(), Json::array({call}));
    EXPECT_LE(largest_difference(answers.at(0).at("features"), features), kLimit);
  }
}

}  // namespace
}  // namespace mien::onnx::onnx_runtime_test
