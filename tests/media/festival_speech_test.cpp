#include "mien/media/festival_speech.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mien/media/phone_names.h"

namespace mien::media::festival_speech_test {
namespace {

using testing::HasSubstr;

TEST(FestivalSpeech, AsksForVoicePaceAndText) {
  const auto script = festival_script("czech_dita", R"(say "a\b")", 350, "/tmp/x.wav");
  ASSERT_TRUE(script) << script.error().message();
  EXPECT_THAT(*script, HasSubstr("(voice_czech_dita)"));
  EXPECT_THAT(*script, HasSubstr("'Duration_Stretch 0.5000"));
  EXPECT_THAT(*script, HasSubstr(R"((Utterance Text "say \"a\\b\""))"));
  EXPECT_THAT(*script, HasSubstr("(utt.save.wave said \"/tmp/x.wav\" 'riff)"));
}

TEST(FestivalSpeech, RefusesOtherVoicesLettersAndRates) {
  EXPECT_THAT(festival_script("nobody", "a", 175, "x").error().message(), HasSubstr("czech_dita"));
  EXPECT_EQ(festival_script("czech_dita", "", 175, "x").error().code, ErrorCode::bad_usage);
  EXPECT_EQ(festival_script("czech_dita", "für", 175, "x").error().code, ErrorCode::bad_usage);
  EXPECT_EQ(festival_script("czech_dita", "a\n(quit)", 175, "x").error().code, ErrorCode::bad_usage);
  EXPECT_EQ(festival_script("czech_dita", "a", 20, "x").error().code, ErrorCode::bad_usage);
  EXPECT_FALSE(parse_festival_phones("", "nobody"));
}

TEST(FestivalSpeech, ReadsPhonesAmongWhatVoicesSay) {
  const auto phones = parse_festival_phones(
      "using default diphone\nmien-phone 0.22 #\n\nmien-phone 0.3 m\nmien-phone 0.4125 a1\nmien-phone 0.5 "
      "tS\n",
      "lp_diphone");
  ASSERT_TRUE(phones) << phones.error().message();
  ASSERT_EQ(phones->size(), 4U);
  EXPECT_EQ((*phones)[0].text, "") << "a pause";
  EXPECT_EQ((*phones)[1].text, "m");
  EXPECT_EQ((*phones)[1].start_s, 0.22);
  EXPECT_EQ((*phones)[2].text, "a");
  EXPECT_EQ((*phones)[2].end_s, 0.4125);
  EXPECT_EQ((*phones)[3].text, "tʃ");
}

TEST(FestivalSpeech, RefusesPhonesWithoutTheirTime) {
  for (const char* printed : {"mien-phone m", "mien-phone nan m", "mien-phone 1e999 m", "mien-phone 0.5m",
                              "mien-phone 0.5 a\nmien-phone 0.4 b", "mien-phone "})
    EXPECT_EQ(parse_festival_phones(printed, "lp_diphone").error().code, ErrorCode::malformed) << printed;
}

TEST(PhoneNames, EachSetHasItsOwn) {
  EXPECT_EQ(ipa_of(PhoneSet::english, "ay"), "aɪ");
  EXPECT_EQ(ipa_of(PhoneSet::russian, "ay"), "ʌ");
  EXPECT_EQ(ipa_of(PhoneSet::russian, "pp"), "p") << "a soft one";
  EXPECT_EQ(ipa_of(PhoneSet::russian, "aa"), "a");
  EXPECT_EQ(ipa_of(PhoneSet::continental, "ch"), "x");
  EXPECT_EQ(ipa_of(PhoneSet::english, "ch"), "tʃ");
  EXPECT_EQ(ipa_of(PhoneSet::continental, "p:"), "p");
  for (const PhoneSet set : {PhoneSet::english, PhoneSet::continental, PhoneSet::russian}) {
    for (const char* closing : {"p", "b", "m"}) EXPECT_EQ(ipa_of(set, closing), closing);
    for (const char* pause : {"#", "pau", "", "_"}) EXPECT_EQ(ipa_of(set, pause), "");
  }
}

}  // namespace
}  // namespace mien::media::festival_speech_test
