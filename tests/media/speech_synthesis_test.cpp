#include "mien/media/speech_synthesis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

namespace mien::media::speech_synthesis_test {
namespace {

void expect_sound_times(const SpokenText& spoken) {
  ASSERT_FALSE(spoken.phonemes.empty());
  double last_s = 0;
  for (const SpokenSpan& p : spoken.phonemes) {
    EXPECT_GE(p.start_s, last_s);
    EXPECT_GE(p.end_s, p.start_s);
    last_s = p.end_s;
  }
  EXPECT_LE(last_s, spoken.sound.duration_s() + 1e-3);
}

TEST(Speech, SpeaksSeveralLanguages) {
  for (const char* language : {"en-us", "de", "fr-fr", "es", "it"}) {
    const auto spoken = speak(language, "Papa, banana.");
    ASSERT_TRUE(spoken.has_value()) << spoken.error().message();
    expect_sound_times(*spoken);
    EXPECT_EQ(spoken->words.size(), 2U) << language;
    EXPECT_GT(spoken->sound.duration_s(), 0.5) << language;
    const float loudest = std::ranges::max(spoken->sound.samples, {}, [](float s) { return std::abs(s); });
    EXPECT_GT(std::abs(loudest), 0.05F) << language;
  }
}

TEST(Speech, HasVariantsOfEachVoice) {
  const auto plain = speak("fr-fr", "Papa");
  const auto other = speak("fr-fr+f3", "Papa");
  ASSERT_TRUE(plain && other);
  EXPECT_NE(plain->sound.samples, other->sound.samples);
  EXPECT_FALSE(speak("fr-fr+nobody", "Papa"));
  EXPECT_FALSE(speak("xx+f3", "Papa"));
}

TEST(Speech, VoicesOfPeopleSpeakToo) {
  for (const char* voice : {"flite:slt", "flite:rms", "flite:awb", "flite:kal16"}) {
    const auto spoken = speak(voice, "My mother put a plum beside the window.");
    ASSERT_TRUE(spoken) << spoken.error().message();
    expect_sound_times(*spoken);
    EXPECT_EQ(spoken->sound.rate_hz, 16'000U);
    std::string ipa;
    for (const SpokenSpan& p : spoken->phonemes) ipa += p.text;
    EXPECT_NE(ipa.find("maɪ"), std::string::npos) << ipa;
    EXPECT_NE(ipa.find("pl"), std::string::npos) << ipa;
    const auto fast = speak(voice, "My mother put a plum beside the window.", 260);
    ASSERT_TRUE(fast);
    EXPECT_LT(fast->sound.duration_s(), 0.8 * spoken->sound.duration_s());
  }
  EXPECT_FALSE(speak("flite:nobody", "Papa"));
}

TEST(Speech, TellsPhonemesWordsAndPauses) {
  const auto spoken = speak("en-us", "Map. Map.");
  ASSERT_TRUE(spoken.has_value());
  std::string ipa;
  for (const SpokenSpan& p : spoken->phonemes) ipa += p.text.empty() ? "|" : p.text;
  EXPECT_NE(ipa.find("m"), std::string::npos) << ipa;
  EXPECT_NE(ipa.find("p|m"), std::string::npos) << ipa;
  ASSERT_EQ(spoken->words.size(), 2U);
  EXPECT_EQ(spoken->words[0].text, "Map");
  EXPECT_LT(spoken->words[0].end_s, spoken->words[1].start_s + 1e-9);
}

TEST(Speech, KeepsItsTimesAndIsFasterWhenAsked) {
  const auto once = speak("en-us", "The quick brown fox.");
  const auto fast = speak("en-us", "The quick brown fox.", 300);
  const auto again = speak("en-us", "The quick brown fox.");
  ASSERT_TRUE(once && fast && again);
  ASSERT_EQ(once->phonemes.size(), again->phonemes.size());
  for (std::size_t i = 0; i < once->phonemes.size(); ++i) {
    EXPECT_EQ(once->phonemes[i].text, again->phonemes[i].text);
    EXPECT_NEAR(once->phonemes[i].start_s, again->phonemes[i].start_s, 2e-3);
  }
  EXPECT_LT(fast->sound.duration_s(), 0.8 * once->sound.duration_s());
}

TEST(Speech, CountsCharactersNotBytes) {
  const auto spoken = speak("fr-fr", "\xC3\xA9t\xC3\xA9 beau");
  ASSERT_TRUE(spoken.has_value());
  ASSERT_EQ(spoken->words.size(), 2U);
  EXPECT_EQ(spoken->words[0].text, "\xC3\xA9t\xC3\xA9");
  EXPECT_EQ(spoken->words[1].text, "beau");
}

TEST(Speech, RefusesWhatItCannotSay) {
  EXPECT_EQ(speak("no-such-tongue", "Hello").error().code, ErrorCode::bad_usage);
  EXPECT_EQ(speak("en-us", " \n ").error().code, ErrorCode::bad_usage);
  EXPECT_EQ(speak("en-us", "Hello", 1).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(speak("en-us", std::string(200'000, 'a')).error().code, ErrorCode::bad_usage);
  EXPECT_TRUE(speak("en-us", "\xFF\xFE broken bytes").has_value()) << "bad UTF-8 is read over";
}

TEST(Speech, JsonHoldsTheTimes) {
  const auto spoken = speak("de", "Guten Tag");
  ASSERT_TRUE(spoken.has_value());
  const auto tree = nlohmann::json::parse(spoken_text_json("de", "Guten \"Tag\"", 175, *spoken));
  EXPECT_EQ(tree["language"], "de");
  EXPECT_EQ(tree["text"], "Guten \"Tag\"");
  EXPECT_EQ(tree["rate_hz"], 22050);
  EXPECT_EQ(tree["phonemes"].size(), spoken->phonemes.size());
  EXPECT_EQ(tree["words"][1]["text"], "Tag");
  EXPECT_DOUBLE_EQ(tree["phonemes"][0]["start_s"].get<double>(), spoken->phonemes[0].start_s);
}

}  // namespace
}  // namespace mien::media::speech_synthesis_test
