#include "mien/train/tasks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "mien/speech/speech_network.h"
#include "mien/train/trainer.h"
#include "tests/folder.h"
#include "tests/train/toy_data.h"

namespace mien::train::speech_task_test {
namespace {

using testing::HasSubstr;

/// A jaw that follows one loud band, lips that close where nothing is heard, and a hiss in which nobody
/// speaks.
synthetic::SpeechDataset toy_speech(const std::string& voice, std::size_t passages) {
  const std::size_t shapes = synthetic::speech_shapes().size();
  synthetic::SpeechDataset data;
  for (std::size_t p = 0; p <= passages; ++p) {
    Random random = Random(7).fork(voice, p);
    synthetic::SpeechSequence& s = data.sequences.emplace_back();
    s.speech = p < passages;
    s.voice = s.speech ? voice : "hiss";
    s.blocks = 200;
    float jaw = 0;
    for (std::size_t b = 0; b < s.blocks; ++b) {
      if (b % 8 == 0) jaw = random.chance(0.3) ? 0 : static_cast<float>(random.uniform(0.3, 1));
      for (std::size_t i = 0; i < speech::kConditionOfBlock; ++i) {
        const std::size_t band = i % speech::kMelBands;
        const double level = !s.speech                          ? -16 + 0.3 * static_cast<double>(band)
                             : jaw > 0 && band > 5 && band < 20 ? -8 + 6 * double{jaw}
                                                                : -16;
        s.mel.push_back(static_cast<float>(level + 0.2 * random.normal()));
      }
      s.mouth.push_back(s.speech ? jaw : 0);
      for (std::size_t k = 1; k < shapes; ++k) s.mouth.push_back(0.05F);
      s.closure.push_back(s.speech && jaw == 0 ? 1 : 0);
      s.voiced.push_back(s.speech ? 1 : 0);
    }
  }
  return data;
}

Recipe toy_speech_recipe(std::size_t steps) {
  return *parse_recipe(toy_causal_recipe(steps), "test");
}

TEST(SpeechTask, LearnsAToyThatCanBeListenedTo) {
  const mien::test::Folder folder;
  const auto task = make_speech_task(toy_speech_recipe(400), toy_speech("one", 6), toy_speech("two", 2));
  ASSERT_TRUE(task) << task.error().message();
  const auto report =
      train(**task, {.out = folder / "toy.safetensors", .device = "cpu", .threads = 1}, no_progress);
  ASSERT_TRUE(report) << report.error().message();
  const auto results = nlohmann::json::parse(report->results)["speech"];
  EXPECT_GT(results["jaw_correlation"].get<double>(), 0.6);
  EXPECT_GT(results["closure_recall"].get<double>(), 0.7);
  EXPECT_LT(results["voice_in_other_sounds"].get<double>(), 0.2);
  const auto file = speech::read_speech_network(folder / "toy.safetensors");
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->shapes, synthetic::speech_shapes());
  EXPECT_EQ(file->look_ahead, 1U);
  EXPECT_TRUE(speech::SpeechNetwork::create(*file));
  EXPECT_EQ(nlohmann::json::parse(file->results)["speech"], results);
}

TEST(SpeechTask, ABatchDependsOnItsSeedAlone) {
  const auto task = make_speech_task(toy_speech_recipe(10), toy_speech("one", 3), toy_speech("two", 1));
  ASSERT_TRUE(task) << task.error().message();
  const Batch one = (*task)->random_batch(8, Random(1)), two = (*task)->random_batch(8, Random(1));
  EXPECT_EQ(one.windows, 8U);
  EXPECT_EQ(one.condition, two.condition);
  EXPECT_NE(one.condition, (*task)->random_batch(8, Random(2)).condition);
  EXPECT_EQ(one.condition.size(), 8 * (*task)->recipe().architecture.window * speech::kConditionOfBlock);
  EXPECT_EQ(one.clean.size(),
            8 * (*task)->recipe().architecture.window * (synthetic::speech_shapes().size() + 2));
}

TEST(SpeechTask, RefusesWhatCannotBeTrained) {
  const Recipe recipe = toy_speech_recipe(10);
  const auto complaint = [&](synthetic::SpeechDataset training, synthetic::SpeechDataset validation) {
    const auto task = make_speech_task(recipe, std::move(training), std::move(validation));
    return task ? std::string() : task.error().message();
  };
  EXPECT_THAT(complaint({}, toy_speech("two", 1)), HasSubstr("no passage"));
  EXPECT_THAT(complaint(toy_speech("one", 1), toy_speech("one", 1)), HasSubstr("speaks in training and"));
  synthetic::SpeechDataset mute = toy_speech("one", 1);
  mute.sequences.erase(mute.sequences.begin());
  EXPECT_THAT(complaint(mute, toy_speech("two", 1)), HasSubstr("no passage"))
      << "other sounds alone teach nothing";
  synthetic::SpeechDataset broken = toy_speech("one", 1);
  broken.sequences[0].closure.pop_back();
  EXPECT_THAT(complaint(broken, toy_speech("two", 1)), HasSubstr("do not fit"));
  broken = toy_speech("one", 1);
  broken.sequences[0].mel[3] = NAN;
  EXPECT_THAT(complaint(broken, toy_speech("two", 1)), HasSubstr("not finite"));
  broken = toy_speech("one", 1);
  broken.look_ahead = 0;
  EXPECT_THAT(complaint(broken, toy_speech("two", 1)), HasSubstr("look ahead"));
}

}  // namespace
}  // namespace mien::train::speech_task_test
