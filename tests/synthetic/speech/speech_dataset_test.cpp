#include "mien/synthetic/speech/speech_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "mien/face/profile.h"
#include "mien/performer/lines.h"
#include "mien/speech/speech_network.h"
#include "tests/synthetic/speech/letter_speaker.h"

namespace mien::synthetic::speech_dataset_test {
namespace {

using testing::HasSubstr;

TEST(SpeechDataset, VoicesAreApartAndOfFourLanguages) {
  std::set<std::string> all;
  std::size_t count = 0;
  for (const VoiceUse use :
       {VoiceUse::training, VoiceUse::validation, VoiceUse::confidence, VoiceUse::test}) {
    std::set<std::size_t> languages;
    for (const Voice& voice : voices_for(use)) {
      all.insert(voice.name);
      languages.insert(voice.language);
      ++count;
    }
    for (std::size_t l = 0; l < performer::reading_languages().size(); ++l)
      EXPECT_TRUE(languages.contains(l));
    EXPECT_EQ(languages.size(), performer::reading_languages().size());
  }
  EXPECT_EQ(all.size(), count) << "none is used twice";
  EXPECT_GE(voices_for(VoiceUse::training).size() / 4, 8U);
}

TEST(SpeechDataset, ShapesHaveNames) {
  EXPECT_EQ(speech_shapes().size(), 18U);
  for (const std::string& name : speech_shapes())
    EXPECT_LT(face::shape_index(name), face::kShapeCount) << name;
}

TEST(SpeechDataset, TruthIsThatOfTheMouthABlockBefore) {
  SpeechDataRecipe recipe{.passages = 1, .validation_passages = 1, .other_seconds = 5, .look_ahead = 0};
  const auto now = make_speech_dataset(recipe, test::letter_speaker());
  recipe.look_ahead = 1;
  const auto later = make_speech_dataset(recipe, test::letter_speaker(), no_progress, 1);
  ASSERT_TRUE(now && later);
  ASSERT_EQ(now->train.sequences.size(), later->train.sequences.size());
  std::size_t speech = 0;
  const std::size_t shapes = speech_shapes().size();
  for (std::size_t i = 0; i < now->train.sequences.size(); ++i) {
    const SpeechSequence &a = now->train.sequences[i], &b = later->train.sequences[i];
    ASSERT_EQ(a.mel.size(), a.blocks * speech::kConditionOfBlock);
    ASSERT_EQ(a.mouth.size(), a.blocks * shapes);
    EXPECT_EQ(a.mel, b.mel);
    for (std::size_t k = 1; k < a.blocks; ++k) {
      EXPECT_EQ(b.closure[k], a.closure[k - 1]);
      EXPECT_NEAR(b.mouth[k * shapes], a.mouth[(k - 1) * shapes], 1e-5);
    }
    if (a.speech) {
      ++speech;
      EXPECT_GT(std::ranges::count(a.voiced, 1.0F), 50);
    } else {
      EXPECT_EQ(std::ranges::count(a.voiced, 1.0F), 0);
      EXPECT_EQ(*std::ranges::max_element(a.mouth), 0);
    }
  }
  EXPECT_EQ(speech, 48U + 3 * 12);
}

TEST(SpeechDataset, PeopleSayAsMuchAsTheRecipeAsksFor) {
  const SpeechDataRecipe recipe{
      .passages = 1, .people = 0, .other_people = 2, .validation_passages = 1, .other_seconds = 5};
  const auto data = make_speech_dataset(recipe, test::letter_speaker());
  ASSERT_TRUE(data) << data.error().message();
  std::size_t english = 0, others = 0;
  for (const SpeechSequence& one : data->train.sequences) {
    english += one.voice.starts_with("flite:") ? 1 : 0;
    others += one.voice.starts_with("festival:") ? 1 : 0;
  }
  EXPECT_EQ(english, 0U);
  EXPECT_EQ(others, 9U * 2);
}

TEST(SpeechDataset, SaysWhatIsWrongWithItsRecipe) {
  const auto complaint = [](std::string_view text) {
    const auto recipe = parse_speech_data_recipe(text, "mine.toml");
    return recipe ? std::string() : recipe.error().message();
  };
  EXPECT_EQ(complaint("passages = 3\nlook_ahead = 0\n"), "");
  EXPECT_THAT(complaint("passages = 0"), HasSubstr("from 1 to 1000"));
  EXPECT_THAT(complaint("look_ahead = 2"), HasSubstr("from 0 to 1"));
  EXPECT_THAT(complaint("other_seconds = nan"), HasSubstr("from 5 to 3600"));
  EXPECT_THAT(complaint("voices = 3"), HasSubstr("other_seconds, passages, people, seed"));
}

TEST(SpeechDataset, TellsWhatItsSpeakerSays) {
  const performer::Speaker mute = [](const std::string&, const std::string&,
                                     int) -> Result<performer::SpokenLine> {
    return fail(ErrorCode::not_found, "nobody speaks");
  };
  const auto data = make_speech_dataset({}, mute);
  ASSERT_FALSE(data);
  EXPECT_THAT(data.error().message(), HasSubstr("nobody speaks"));
}

}  // namespace
}  // namespace mien::synthetic::speech_dataset_test
