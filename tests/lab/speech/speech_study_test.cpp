#include "lab/speech/speech_study.h"

#include <gtest/gtest.h>

#include "tests/model/random_network.h"
#include "tests/synthetic/speech/letter_speaker.h"

namespace mien::lab::speech_study_test {
namespace {

/// An untrained network: whatever it says, its table tells how far that is from the truth.
speech::SpeechNetworkFile untrained() {
  speech::SpeechNetworkFile file;
  file.shapes = synthetic::speech_shapes();
  file.architecture = {.name = "causal",
                       .kind = model::NetworkKind::causal,
                       .layers = 1,
                       .d_model = 32,
                       .heads = 0,
                       .d_head = 0,
                       .ffn = 0,
                       .window = 10,
                       .condition = speech::kConditionOfBlock,
                       .outputs = file.shapes.size() + 2};
  file.look_ahead = 1;
  file.mean.fill(-9);
  file.scale.fill(3);
  file.network = model::random_network(file.architecture, 3);
  // Somebody always speaks: the last output's bias.
  for (model::Tensor& tensor : file.network)
    if (tensor.shape.size() == 1 && tensor.shape[0] == file.architecture.outputs) tensor.values.back() = 5;
  return file;
}

TEST(SpeechConfidence, ATableIsTrueOfThoseItWasMeasuredOn) {
  speech::SpeechNetworkFile network = untrained();
  HeardPeople people{.voices = synthetic::VoiceUse::test, .passages = 1, .seed = 5};
  const auto before =
      study_speech_confidence(network, people, synthetic::test::letter_speaker(), no_progress);
  ASSERT_TRUE(before);
  EXPECT_TRUE(before->empty()) << "a network without a table says nothing";
  const auto table =
      measure_speech_confidence(network, people, synthetic::test::letter_speaker(), no_progress);
  ASSERT_TRUE(table) << table.error().message();
  EXPECT_EQ(table->seed, 5U);
  ASSERT_TRUE(table->regions);
  network.confidence = *table;
  people.threads = 1;
  const auto rows = study_speech_confidence(network, people, synthetic::test::letter_speaker(), no_progress);
  ASSERT_TRUE(rows);
  ASSERT_EQ(rows->size(), 7U);
  solve::Reliability mouth, jaw;
  for (const SpeechConfidenceRow& row : *rows) {
    EXPECT_GT(row.frames, 1000U) << row.sound;
    mouth.add(row.mouth);
    jaw.add(row.jaw);
  }
  EXPECT_LT(mouth.expected_error(), 0.05);
  EXPECT_LT(jaw.expected_error(), 0.05);
  EXPECT_EQ(*measure_speech_confidence(network, people, synthetic::test::letter_speaker(), no_progress),
            *table)
      << "on any number of threads";
}

TEST(SpeechConfidence, TellsWhatItsSpeakerSays) {
  const performer::Speaker mute = [](const std::string&, const std::string&,
                                     int) -> Result<performer::SpokenLine> {
    return fail(ErrorCode::not_found, "no voice");
  };
  EXPECT_EQ(measure_speech_confidence(untrained(), {}, mute, no_progress).error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace mien::lab::speech_study_test
