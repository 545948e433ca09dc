#include "mien/model/model_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/core/files.h"
#include "mien/model/network_correction.h"
#include "tests/model/random_network.h"

namespace mien::model::model_file_test {
namespace {

TEST(ModelFile, RoundTripsWhole) {
  const ModelFile model = small_model();
  const auto bytes = format_model(model);
  ASSERT_TRUE(bytes) << bytes.error().message();
  const auto back = parse_model(*bytes, "test");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->architecture, model.architecture);
  EXPECT_EQ(back->features, model.features);
  EXPECT_EQ(back->normalisation.mean, model.normalisation.mean);
  EXPECT_EQ(back->normalisation.scale, model.normalisation.scale);
  EXPECT_EQ(back->shapes, model.shapes);
  EXPECT_EQ(back->mean_pose, model.mean_pose);
  EXPECT_EQ(back->ridge, model.ridge);
  EXPECT_EQ(back->schedule, model.schedule);
  EXPECT_EQ(back->sampler, model.sampler);
  EXPECT_EQ(back->recipe, model.recipe);
  EXPECT_EQ(back->results, model.results);
  EXPECT_EQ(back->network, model.network);
  EXPECT_EQ(*format_model(*back), *bytes);
  ASSERT_NE(back->ridge_for("lab"), nullptr);
  EXPECT_EQ(back->ridge_for("device"), nullptr);
}

TEST(ModelFile, ACausalOneRoundTripsWithoutASampler) {
  const ModelFile model = small_causal_model();
  const auto bytes = format_model(model);
  ASSERT_TRUE(bytes) << bytes.error().message();
  const auto back = parse_model(*bytes, "test");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->architecture, model.architecture);
  EXPECT_EQ(back->architecture.kind, NetworkKind::causal);
  EXPECT_EQ(back->network, model.network);
  EXPECT_EQ(*format_model(*back), *bytes);
  const TensorFile file = *parse_safetensors(*bytes, "test");
  EXPECT_FALSE(file.metadata.contains("sampler"));
  EXPECT_FALSE(file.metadata.contains("schedule"));
}

ConfidenceTable small_table(std::size_t shapes) {
  ConfidenceTable table;
  table.coverage_edges = {0.5F};
  table.value_edges = {0.2F, 0.6F};
  table.measured_from = 0.35F;
  table.people = 24;
  table.seed = 2001;
  for (std::size_t k = 0; k < shapes; ++k) {
    table.explained.insert(table.explained.end(), {0.25F, 0.75F});
    table.within.insert(table.within.end(), {0.5F, 0.25F, 0.125F, 1, 0.75F, 0.5F});
  }
  return table;
}

TEST(ModelFile, AConfidenceTableRoundTripsAndAnOlderFileHasNone) {
  for (ModelFile model : {small_model(), small_causal_model()}) {
    EXPECT_FALSE(parse_model(*format_model(model), "test")->confidence);
    model.confidence = small_table(model.shapes.size());
    const auto bytes = format_model(model);
    ASSERT_TRUE(bytes) << bytes.error().message();
    const auto back = parse_model(*bytes, "test");
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(back->confidence, model.confidence);
    EXPECT_EQ(*format_model(*back), *bytes);
  }
}

RegionMaps some_maps() {
  RegionMaps maps;
  for (std::size_t r = 0; r < maps.size(); ++r) maps[r] = {0.1F * static_cast<float>(r) - 1, 1.0F / 3};
  return maps;
}

TEST(ModelFile, RegionsMapsRoundTripAndChangeNothingElse) {
  ModelFile model = small_causal_model();
  model.confidence = small_table(model.shapes.size());
  const auto without = format_model(model);
  model.confidence->regions = some_maps();
  const auto bytes = format_model(model);
  ASSERT_TRUE(bytes) << bytes.error().message();
  auto back = parse_model(*bytes, "test");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->confidence, model.confidence) << "to the bit";
  back->confidence->regions.reset();
  EXPECT_EQ(*format_model(*back), *without);
  EXPECT_FALSE(parse_model(*without, "test")->confidence->regions);
}

TEST(ModelFile, RefusesMapsThatAreNotTheFiveRegions) {
  ModelFile model = small_causal_model();
  model.confidence = small_table(model.shapes.size());
  for (const float wrong : {std::nanf(""), 1e7F, -INFINITY}) {
    model.confidence->regions = some_maps();
    (*model.confidence->regions)[3].slope = wrong;
    EXPECT_EQ(format_model(model).error().code, ErrorCode::out_of_range) << wrong;
    (*model.confidence->regions)[3] = {wrong, 1};
    EXPECT_EQ(format_model(model).error().code, ErrorCode::out_of_range) << wrong;
  }
  model.confidence->regions = some_maps();
  const TensorFile file = *parse_safetensors(*format_model(model), "test");
  const std::string& whole = file.metadata.at("confidence");
  const auto refused = [&](const std::string& from, const std::string& to) {
    TensorFile other = file;
    std::string& text = other.metadata["confidence"];
    text.replace(text.find(from), from.size(), to);
    return parse_model(write_safetensors(other), "test").error().code;
  };
  ASSERT_NE(whole.find("\"brows\":[-1.0,"), std::string::npos) << whole;
  EXPECT_EQ(refused("\"brows\":[-1.0,", "\"brows\":[null,"), ErrorCode::malformed);
  EXPECT_EQ(refused("\"brows\":[-1.0,", "\"brows\":[\"-1\","), ErrorCode::malformed);
  EXPECT_EQ(refused("\"brows\":[-1.0,", "\"brows\":[1e300,"), ErrorCode::out_of_range);
  EXPECT_EQ(refused("\"brows\":[-1.0,", "\"brows\":[-1.0,2,"), ErrorCode::malformed);
  EXPECT_EQ(refused("\"brows\":[-1.0,", "\"ears\":[-1.0,"), ErrorCode::malformed);
  EXPECT_EQ(refused("\"brows\":[-1.0,", "\"ears\":[1,1],\"brows\":[-1.0,"), ErrorCode::malformed);
  EXPECT_EQ(refused("\"regions\":{", "\"regions\":3,\"r\":{"), ErrorCode::malformed);
}

TEST(ModelFile, RefusesAConfidenceTableThatDoesNotHoldTogether) {
  const auto refused = [](const auto& spoil) {
    ModelFile model = small_causal_model();
    model.confidence = small_table(model.shapes.size());
    spoil(*model.confidence);
    const auto bytes = format_model(model);
    return bytes ? ErrorCode::internal : bytes.error().code;
  };
  using Table = ConfidenceTable;
  const float nan = std::nanf("");
  EXPECT_EQ(refused([](Table& t) { t.explained.pop_back(); }), ErrorCode::mismatch);
  EXPECT_EQ(refused([](Table& t) { t.within.push_back(0); }), ErrorCode::mismatch);
  EXPECT_EQ(refused([](Table& t) { t.coverage_edges = {}; }), ErrorCode::mismatch);
  EXPECT_EQ(refused([](Table& t) { t.value_edges.assign(kMostConfidenceBins, 0.5F); }),
            ErrorCode::out_of_range);
  EXPECT_EQ(refused([](Table& t) { t.value_edges = {0.6F, 0.2F}; }), ErrorCode::out_of_range);
  EXPECT_EQ(refused([](Table& t) { t.coverage_edges = {0}; }), ErrorCode::out_of_range);
  EXPECT_EQ(refused([&](Table& t) { t.coverage_edges = {nan}; }), ErrorCode::out_of_range);
  EXPECT_EQ(refused([](Table& t) { t.within[3] = 1.5F; }), ErrorCode::out_of_range);
  EXPECT_EQ(refused([&](Table& t) { t.explained[2] = nan; }), ErrorCode::out_of_range);
  EXPECT_EQ(refused([](Table& t) { t.measured_from = -1; }), ErrorCode::out_of_range);
  EXPECT_EQ(refused([](Table& t) { t.explained[1] = 0.125F; }), ErrorCode::out_of_range) << "grows with loss";
}

TEST(ModelFile, RefusesAConfidenceTableHalfThere) {
  ModelFile model = small_causal_model();
  model.confidence = small_table(model.shapes.size());
  TensorFile file = *parse_safetensors(*format_model(model), "test");
  TensorFile without = file;
  without.metadata.erase("confidence");
  EXPECT_EQ(parse_model(write_safetensors(without), "test").error().code, ErrorCode::mismatch);
  without = file;
  without.metadata["confidence"] = "{}";
  EXPECT_EQ(parse_model(write_safetensors(without), "test").error().code, ErrorCode::malformed);
  std::erase_if(file.tensors, [](const Tensor& t) { return t.name == "confidence.within"; });
  EXPECT_EQ(parse_model(write_safetensors(file), "test").error().code, ErrorCode::mismatch);
}

TEST(ModelFile, AWearersSkinRoundTripsAndIsChecked) {
  ModelFile model = small_causal_model();
  model.skin = Skin{.standard = std::vector<float>(18, 0.25F),
                    .covariance = {0.02F, 0.01F, 0, 0.01F, 0.02F, 0, 0, 0, 0},
                    .wearer = {}};
  for (const bool worn : {false, true}) {
    if (worn) model.skin->wearer.assign(18, 0.5F);
    const auto back = parse_model(*format_model(model), "test");
    ASSERT_TRUE(back) << back.error().message();
    ASSERT_TRUE(back->skin);
    EXPECT_EQ(back->skin->standard, model.skin->standard);
    EXPECT_EQ(back->skin->covariance, model.skin->covariance);
    EXPECT_EQ(back->skin->wearer, model.skin->wearer);
  }
  for (const auto spoil :
       {+[](Skin& s) { s.wearer.pop_back(); }, +[](Skin& s) { s.covariance.push_back(0); },
        +[](Skin& s) { s.standard[3] = 100; }, +[](Skin& s) { s.covariance[4] = -1; },
        +[](Skin& s) { s.covariance[1] = s.covariance[3] = 12; }, +[](Skin& s) { s.covariance[1] = 0; },
        +[](Skin& s) { s.wearer[0] = std::nanf(""); }}) {
    ModelFile spoilt = model;
    spoil(*spoilt.skin);
    EXPECT_FALSE(format_model(spoilt));
  }
}

TEST(ModelFile, ACorrectionRoundTripsAndIsChecked) {
  ModelFile model = small_causal_model();
  const Architecture& a = model.architecture;
  model.correction = Correction{.network = correction_key(model.network),
                                .weights = std::vector<float>(a.outputs * a.d_model, 0.25F),
                                .bias = std::vector<float>(a.outputs, -0.5F)};
  const auto bytes = format_model(model);
  ASSERT_TRUE(bytes) << bytes.error().message();
  const auto back = parse_model(*bytes, "test");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->correction, model.correction);
  EXPECT_FALSE(parse_model(format_model(small_causal_model()).value(), "test")->correction);
  for (const auto spoil :
       {+[](Correction& c) { c.weights.pop_back(); }, +[](Correction& c) { c.weights[0] = 11; },
        +[](Correction& c) { c.weights[0] = std::nanf(""); }, +[](Correction& c) { c.bias.clear(); },
        +[](Correction& c) { c.network = "0123456789abcdef"; }}) {
    ModelFile spoilt = model;
    spoil(*spoilt.correction);
    EXPECT_FALSE(format_model(spoilt));
  }
  // What a file says of the network is no key.
  TensorFile file = *parse_safetensors(*bytes, "test");
  for (const char* said : {R"({"network":7})", R"({"network":""})", "{}", "no JSON"}) {
    file.metadata["correction"] = said;
    EXPECT_FALSE(parse_model(write_safetensors(file), "test")) << said;
  }
  ModelFile window = small_model();
  window.correction = model.correction;
  EXPECT_FALSE(format_model(window));
}

TEST(ModelFile, FilesThatNameNoKindAreWindowNetworks) {
  TensorFile file = *parse_safetensors(*format_model(small_model()), "test");
  std::string& architecture = file.metadata["architecture"];
  const std::string kind = R"("kind":"window",)";
  ASSERT_NE(architecture.find(kind), std::string::npos);
  architecture.erase(architecture.find(kind), kind.size());
  const auto model = parse_model(write_safetensors(file), "test");
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(model->architecture, small_model().architecture);
}

/// Each change alone must be refused, by the writer and, where the bytes can be made at all, by the reader.
TEST(ModelFile, RefusesModelsThatDoNotHoldTogether) {
  const auto refused = [](const char* what, auto&& change) {
    ModelFile model = small_model();
    change(model);
    EXPECT_FALSE(format_model(model)) << what;
  };
  refused("width", [](ModelFile& m) { m.architecture.d_model = 33; });
  refused("layers", [](ModelFile& m) { m.architecture.layers = 1000; });
  refused("condition", [](ModelFile& m) { m.features.presence_flags = false; });
  refused("sensors twice", [](ModelFile& m) { m.features.sensors[1] = m.features.sensors[0]; });
  refused("shapes", [](ModelFile& m) { m.shapes.pop_back(); });
  refused("mean pose", [](ModelFile& m) { m.mean_pose.clear(); });
  refused("scale", [](ModelFile& m) { m.normalisation.scale[3] = 0; });
  refused("normalisation", [](ModelFile& m) { m.normalisation.mean.push_back(0); });
  refused("ridge twice", [](ModelFile& m) { m.ridge.push_back(m.ridge[0]); });
  refused("ridge size", [](ModelFile& m) { m.ridge[0].matrix.pop_back(); });
  refused("steps", [](ModelFile& m) { m.sampler.steps = 1001; });
  refused("noise", [](ModelFile& m) { m.sampler.first_noise = -0.1; });
  refused("tensor missing", [](ModelFile& m) { m.network.pop_back(); });
  refused("tensor order", [](ModelFile& m) { std::swap(m.network[0], m.network[2]); });
  refused("tensor shape", [](ModelFile& m) { std::swap(m.network[0].shape[0], m.network[0].shape[1]); });
}

TEST(ModelFile, RefusesCausalModelsThatDoNotHoldTogether) {
  const auto refused = [](const char* what, auto&& change) {
    ModelFile model = small_causal_model();
    change(model);
    EXPECT_FALSE(format_model(model)) << what;
  };
  refused("width", [](ModelFile& m) { m.architecture.d_model = 48; });
  refused("heads", [](ModelFile& m) { m.architecture.heads = 1; });
  refused("feed-forward", [](ModelFile& m) { m.architecture.ffn = 32; });
  refused("layers", [](ModelFile& m) { m.architecture.layers = 2; });
  refused("kind", [](ModelFile& m) { m.architecture.kind = NetworkKind::window; });
  refused("tensor missing", [](ModelFile& m) { m.network.pop_back(); });
  refused("a window network's", [](ModelFile& m) { m.network = small_model().network; });
}

TEST(ModelFile, RefusesWrongDescriptions) {
  const auto bytes = format_model(small_model());
  ASSERT_TRUE(bytes);
  const TensorFile file = *parse_safetensors(*bytes, "test");
  const auto refused = [&](const char* name, const char* text, ErrorCode code) {
    TensorFile changed = file;
    changed.metadata[name] = text;
    const auto parsed = parse_model(write_safetensors(changed), "test");
    ASSERT_FALSE(parsed) << name << text;
    EXPECT_EQ(parsed.error().code, code) << parsed.error().message();
  };
  refused("format", "other", ErrorCode::unsupported);
  refused("version", "2", ErrorCode::unsupported);
  refused("architecture", "[", ErrorCode::malformed);
  refused("architecture", "{}", ErrorCode::malformed);
  refused(
      "architecture",
      R"({"name":"x","layers":-1,"d_model":32,"heads":1,"d_head":32,"ffn":32,"window":8,"condition":18,"outputs":3})",
      ErrorCode::out_of_range);
  refused("architecture", R"({"name":"x","kind":"oracle"})", ErrorCode::unsupported);
  refused("architecture", R"({"name":"x","kind":3})", ErrorCode::malformed);
  refused(
      "architecture",
      R"({"name":"x","kind":"causal","layers":1,"d_model":32,"heads":0,"d_head":0,"ffn":-1,"window":8,"condition":18,"outputs":3})",
      ErrorCode::out_of_range);
  refused(
      "architecture",
      R"({"name":"x","kind":"causal","layers":1,"d_model":32,"heads":0,"d_head":0,"ffn":0,"window":8,"condition":18,"outputs":3})",
      ErrorCode::mismatch);
  refused("features", R"({"sensors":[1,2],"presence_flags":true})", ErrorCode::malformed);
  refused("sampler", R"({"kind":"ddim","hold":"clean","steps":0,"seed":1})", ErrorCode::out_of_range);
  refused("ridge", R"([{"profile":"device","penalty":1,"validation_mse":1}])", ErrorCode::mismatch);
  refused("ridge", "[]", ErrorCode::mismatch);

  TensorFile extra = file;
  extra.tensors.push_back({.name = "stowaway", .shape = {1}, .values = {0}});
  EXPECT_FALSE(parse_model(write_safetensors(extra), "test"));
}

TEST(Architecture, TheNamedOnesHaveTheirPublishedSize) {
  // 53 weights and 11 sensors of 7 numbers: the figures that the published network has.
  const auto faithful = named_architecture("faithful", 77);
  ASSERT_TRUE(faithful);
  EXPECT_EQ(faithful->input(), 130U);
  EXPECT_NEAR(static_cast<double>(parameter_count(*faithful)), 10.755e6, 0.005e6);
  EXPECT_NEAR(flop_count(*faithful), 2.800e9, 0.005e9);
  const auto light = named_architecture("light", 77);
  ASSERT_TRUE(light);
  EXPECT_NEAR(static_cast<double>(parameter_count(*light)), 3.289e6, 0.005e6);
  const auto causal = named_architecture("causal", 99);
  ASSERT_TRUE(causal);
  EXPECT_TRUE(check(*causal));
  EXPECT_FALSE(named_architecture("heavy", 77));
}

}  // namespace
}  // namespace mien::model::model_file_test
