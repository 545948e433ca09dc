#include "mien/synthetic/speech/spoken_passage.h"

#include <gtest/gtest.h>

#include <algorithm>

#include <cmath>

#include "mien/performer/lines.h"
#include "tests/synthetic/speech/letter_speaker.h"

namespace mien::synthetic::spoken_passage_test {
namespace {

TEST(SpokenPassage, LipsMeetInTheMiddleOfEachBilabial) {
  const performer::Utterance said{
      .language = "en",
      .text = "",
      .phonemes = {{"a", 0, 0.2}, {"m", 0.2, 0.3}, {"ˈa", 0.3, 0.5}, {"p", 0.5, 0.52}, {"t", 0.52, 0.6}},
      .duration_s = 0.6};
  const auto closures = closures_of(said);
  ASSERT_EQ(closures.size(), 2U);
  EXPECT_NEAR(closures[0].begin_s, 0.215, 1e-9);
  EXPECT_NEAR(closures[0].end_s, 0.275, 1e-9);
  EXPECT_NEAR(closures[1].end_s - closures[1].begin_s, 0.040, 1e-9) << "however short";
}

TEST(SpokenPassage, TwoInARowAreOne) {
  const performer::Utterance said{
      .language = "en", .text = "", .phonemes = {{"m", 0, 0.05}, {"p", 0.05, 0.1}}, .duration_s = 0.1};
  EXPECT_EQ(closures_of(said).size(), 1U);
}

TEST(SpokenPassage, TheFaceClosesWhenTheSoundDoes) {
  const auto passage = speak_passage(test::letter_speaker(), "one", 0, Random(3));
  ASSERT_TRUE(passage) << passage.error().message();
  EXPECT_NEAR(static_cast<double>(passage->sound.size()) / speech::kRateHz, passage->utterance.duration_s,
              1e-3);
  EXPECT_NEAR(passage->face.duration_s(), passage->utterance.duration_s, 0.05);
  ASSERT_GT(passage->closures.size(), 5U);
  const face::MotionCurve curve(passage->face);
  double open = 0, closed = 0;
  for (const Closure& closure : passage->closures) {
    const auto frame = curve.at(0.5 * (closure.begin_s + closure.end_s));
    const float jaw = frame.weights[face::shape("jawOpen")], close = frame.weights[face::shape("mouthClose")];
    open += double{jaw};
    closed += double{close};
    // The letters of a closure are silent.
    const auto middle = static_cast<std::size_t>(0.5 * (closure.begin_s + closure.end_s) * speech::kRateHz);
    EXPECT_NEAR(passage->sound[middle], 0, 1e-3);
  }
  EXPECT_GT(closed, 0.9 * open);
}

TEST(SpokenPassage, TheSameSeedSaysTheSame) {
  const auto one = speak_passage(test::letter_speaker(), "one", 1, Random(3));
  const auto two = speak_passage(test::letter_speaker(), "one", 1, Random(3));
  const auto other = speak_passage(test::letter_speaker(), "one", 1, Random(4));
  ASSERT_TRUE(one && two && other);
  EXPECT_EQ(one->sound, two->sound);
  EXPECT_EQ(one->utterance, two->utterance);
  EXPECT_NE(one->utterance, other->utterance);
}

TEST(SpokenPassage, AReadingBeginsAsThePassageDoesAndIsAsLongAsAsked) {
  const auto passage = speak_passage(test::letter_speaker(), "one", 1, Random(3));
  const auto reading = speak_passage(test::letter_speaker(), "one", 1, Random(3), 40);
  ASSERT_TRUE(passage && reading);
  ASSERT_LT(passage->utterance.duration_s, 40) << "the test needs a longer one";
  EXPECT_GE(reading->utterance.duration_s, 40);
  EXPECT_LT(reading->utterance.duration_s, 60) << "by a line at most";
  EXPECT_NEAR(reading->face.duration_s(), reading->utterance.duration_s, 0.05);
  const std::size_t said = passage->utterance.phonemes.size();
  ASSERT_GT(reading->utterance.phonemes.size(), said);
  EXPECT_EQ(reading->utterance.phonemes[said - 1], passage->utterance.phonemes.back());
}

TEST(SpokenPassage, WhoHasNoLanguageSpeaksInventedLines) {
  std::vector<std::string> said;
  const performer::Speaker letters = test::letter_speaker();
  const performer::Speaker listening = [&](const std::string& voice, const std::string& text, int rate) {
    said.push_back(text);
    return letters(voice, text, rate);
  };
  const auto passage = speak_passage(listening, "somebody", performer::kNoLanguage, Random(4));
  ASSERT_TRUE(passage) << passage.error().message();
  ASSERT_EQ(said.size(), 3U);
  for (const performer::ReadingLanguage& language : performer::reading_languages())
    for (const std::string_view line : language.lines) EXPECT_EQ(std::ranges::count(said, line), 0);
}

TEST(SpokenPassage, ResamplingMovesNothing) {
  Sound sound{.rate_hz = 22'050, .samples = std::vector<float>(22'050)};
  sound.samples[11'025] = 1;
  const auto out = resampled(sound);
  ASSERT_TRUE(out);
  ASSERT_EQ(out->size(), 16'000U);
  const auto loudest = std::ranges::max_element(*out, {}, [](float s) { return std::abs(s); });
  EXPECT_NEAR(static_cast<double>(loudest - out->begin()), 8'000, 1);
}

TEST(SpokenPassage, BlocksAreClippedAndFilledUp) {
  const std::vector<float> sound(speech::kBlockSamples + 1, 2);
  const auto blocks = blocks_of(sound);
  ASSERT_EQ(blocks.size(), 2U);
  EXPECT_EQ(blocks[0][0], 32'767);
  EXPECT_EQ(blocks[1][0], 32'767);
  EXPECT_EQ(blocks[1][1], 0);
}

}  // namespace
}  // namespace mien::synthetic::spoken_passage_test
