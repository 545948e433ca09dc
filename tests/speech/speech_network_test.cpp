#include "mien/speech/speech_network.h"

#include <gtest/gtest.h>

#include "mien/speech/listeners.h"
#include "tests/folder.h"
#include "tests/model/random_network.h"

namespace mien::speech::speech_network_test {
namespace {

/// An untrained network of four shapes.
SpeechNetworkFile small() {
  SpeechNetworkFile file;
  file.shapes = {"jawOpen", "mouthFunnel", "mouthLowerDown_L", "mouthLowerDown_R"};
  file.architecture = {.name = "causal",
                       .kind = model::NetworkKind::causal,
                       .layers = 1,
                       .d_model = 32,
                       .heads = 0,
                       .d_head = 0,
                       .ffn = 0,
                       .window = 10,
                       .condition = kConditionOfBlock,
                       .outputs = 6};
  file.look_ahead = 1;
  for (std::size_t b = 0; b < kMelBands; ++b) {
    file.mean[b] = -9.5F - 0.01F * static_cast<float>(b);
    file.scale[b] = 3.25F;
  }
  file.recipe = "seed = 1\n";
  file.results = R"({"closure": 1})";
  file.network = model::random_network(file.architecture, 2);
  return file;
}

ErrorCode refusal(const SpeechNetworkFile& file) {
  const auto bytes = format_speech_network(file);
  return bytes ? ErrorCode::internal : bytes.error().code;
}

TEST(SpeechNetwork, IsReadBackAsItWasWritten) {
  const mien::test::Folder folder;
  const SpeechNetworkFile file = small();
  ASSERT_TRUE(write_speech_network(folder / "speech.safetensors", file));
  const auto back = read_speech_network(folder / "speech.safetensors");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->architecture, file.architecture);
  EXPECT_EQ(back->shapes, file.shapes);
  EXPECT_EQ(back->look_ahead, 1u);
  EXPECT_EQ(back->mean, file.mean);
  EXPECT_EQ(back->scale, file.scale);
  EXPECT_EQ(back->recipe, file.recipe);
  EXPECT_EQ(back->results, file.results);
  EXPECT_EQ(back->network, file.network);
}

TEST(SpeechNetwork, KeepsWhatItsAnswersAreWorth) {
  SpeechNetworkFile file = small();
  model::ConfidenceTable& table = file.confidence.emplace();
  table.coverage_edges = {0.5F};
  table.value_edges = {0.25F};
  table.explained.assign(2 * face::kShapeCount, 0.5F);
  table.within.assign(4 * face::kShapeCount, 0.875F);
  table.regions.emplace()[0] = {.offset = 1, .slope = 0.5F};
  const auto bytes = format_speech_network(file);
  ASSERT_TRUE(bytes) << bytes.error().message();
  const auto back = parse_speech_network(*bytes, "t");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->confidence, file.confidence);
  auto network = SpeechNetwork::create(*back);
  ASSERT_TRUE(network);
  EXPECT_NE(LearnedListener(std::move(*network)).confidence(), nullptr);
  table.within[3] = 1.5F;
  EXPECT_EQ(refusal(file), ErrorCode::out_of_range);
  EXPECT_EQ(small().confidence, std::nullopt);
}

TEST(SpeechNetwork, RefusesWhatDoesNotHoldTogether) {
  SpeechNetworkFile file = small();
  file.shapes.pop_back();
  EXPECT_EQ(refusal(file), ErrorCode::mismatch);
  file = small();
  file.shapes[1] = "jawOpen";
  EXPECT_EQ(refusal(file), ErrorCode::mismatch);
  file = small();
  file.shapes[1] = "jawopen";
  EXPECT_EQ(refusal(file), ErrorCode::mismatch);
  file = small();
  file.scale[7] = 0;
  EXPECT_EQ(refusal(file), ErrorCode::out_of_range);
  file = small();
  file.look_ahead = 2;
  EXPECT_EQ(refusal(file), ErrorCode::out_of_range);
  file = small();
  file.network.pop_back();
  EXPECT_EQ(refusal(file), ErrorCode::mismatch);
  file = small();
  file.architecture.condition = 40;
  EXPECT_EQ(refusal(file), ErrorCode::mismatch);
  EXPECT_EQ(parse_speech_network({}, "t").error().code, ErrorCode::truncated);
}

TEST(SpeechNetwork, AnswersWithSharesAndClosesTheLipsAsFarAsItSays) {
  LearnedListener listener(SpeechNetwork::create(small()).value());
  Block block;
  for (std::size_t i = 0; i < block.size(); ++i)
    block[i] = static_cast<std::int16_t>((i * 7919) % 8000 - 4000);
  const DeviceTime time{std::chrono::seconds(5)};
  const Heard first = listener.push(time, block);
  EXPECT_EQ(first.time, time - std::chrono::milliseconds(10)) << "its middle, a block before";
  for (int i = 0; i < 20; ++i) {
    const Heard heard = listener.push(time, block);
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      EXPECT_GE(heard.weights[k], 0);
      EXPECT_LE(heard.weights[k], 1);
    }
    EXPECT_LE(heard.weights[face::shape("mouthClose")], heard.weights[face::shape("jawOpen")]);
    EXPECT_EQ(heard.weights[face::shape("browInnerUp_L")], 0);
    EXPECT_GE(heard.voice, 0);
    EXPECT_LE(heard.voice, 1);
  }
  listener.reset();
  EXPECT_EQ(listener.push(time, block).weights, first.weights) << "as at the beginning";
}

}  // namespace
}  // namespace mien::speech::speech_network_test
