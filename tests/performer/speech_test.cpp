#include "mien/performer/speech.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "mien/core/time.h"
#include "mien/performer/performer.h"

namespace mien::performer::speech_test {
namespace {

using face::shape;

Utterance utterance_of(std::initializer_list<const char*> sounds, double each_s = 0.1) {
  Utterance utterance{.language = "en", .text = {}, .phonemes = {}, .duration_s = 0};
  double now_s = 0.3;
  for (const char* ipa : sounds) {
    utterance.phonemes.push_back({ipa, now_s, now_s + each_s});
    now_s += each_s;
  }
  utterance.duration_s = now_s + 0.3;
  return utterance;
}

face::Motion say(const Utterance& utterance, const Style& style, std::uint64_t seed = 1) {
  Script script;
  Segment segment;
  segment.block = Block::reading;
  segment.duration_s = utterance.duration_s;
  segment.utterance = utterance;
  script.segments.push_back(segment);
  return perform(script, style, Random(seed));
}

const face::BlendshapeWeights& at(const face::Motion& motion, double time_s) {
  return motion.frames[static_cast<std::size_t>(std::lround(time_s * kFrameRateHz))].weights;
}

TEST(Speech, BilabialsAlwaysClose) {
  // In every language, however fast, whoever speaks.
  Random random(5);
  int closures = 0;
  for (const std::string_view language : languages())
    for (const double rate : {0.8, 1.0, 1.4}) {
      const Utterance utterance = random_utterance(language, 20, rate, random);
      const auto motion = say(utterance, draw_style(random));
      for (const auto& phoneme : utterance.phonemes) {
        if (phoneme.ipa != "p" && phoneme.ipa != "b" && phoneme.ipa != "m") continue;
        float gap = 1;
        const auto first = static_cast<std::size_t>((phoneme.start_s - 0.02) * kFrameRateHz);
        const auto last = std::min(static_cast<std::size_t>((phoneme.end_s + 0.02) * kFrameRateHz) + 1,
                                   motion.frames.size());
        for (std::size_t i = first; i < last; ++i)
          gap = std::min(gap, motion.frames[i].weights[shape("jawOpen")] -
                                  motion.frames[i].weights[shape("mouthClose")]);
        // Right at the cut end of a script the lips may still be on their way.
        if (phoneme.end_s < utterance.duration_s - 0.1) {
          EXPECT_LT(gap, 0.01F) << language << " " << phoneme.start_s;
        }
        ++closures;
      }
    }
  EXPECT_GT(closures, 100);
}

TEST(Speech, OpenVowelsOpenTheJawAndRoundOnesRoundTheLips) {
  const auto aa = at(say(utterance_of({"t", "ɑː", "t"}, 0.15), plain_style()), 0.525);
  const auto ii = at(say(utterance_of({"t", "iː", "t"}, 0.15), plain_style()), 0.525);
  const auto uu = at(say(utterance_of({"t", "uː", "t"}, 0.15), plain_style()), 0.525);
  EXPECT_GT(aa[shape("jawOpen")], 2 * ii[shape("jawOpen")]);
  EXPECT_GT(uu[shape("mouthPucker")], 0.4F);
  EXPECT_LT(ii[shape("mouthPucker")], 0.1F);
  EXPECT_GT(ii[shape("mouthStretch_L")], 2 * uu[shape("mouthStretch_L")]);
}

TEST(Speech, NeighboursColourASound) {
  // The s of "usu" is rounder than that of "isi": coarticulation, not a switch of poses.
  const auto usu = at(say(utterance_of({"uː", "s", "uː"}), plain_style()), 0.45);
  const auto isi = at(say(utterance_of({"iː", "s", "iː"}), plain_style()), 0.45);
  EXPECT_GT(usu[shape("mouthPucker")], isi[shape("mouthPucker")] + 0.15F);
}

TEST(Speech, LabiodentalsTuckTheLowerLip) {
  const auto f = at(say(utterance_of({"ɑː", "f", "ɑː"}), plain_style()), 0.45);
  const auto k = at(say(utterance_of({"ɑː", "k", "ɑː"}), plain_style()), 0.45);
  EXPECT_GT(f[shape("mouthRollLower")], k[shape("mouthRollLower")] + 0.1F);
  EXPECT_LT(f[shape("jawOpen")], k[shape("jawOpen")]);
}

TEST(Speech, SilenceClosesTheMouth) {
  Utterance silence{.language = "en", .text = {}, .phonemes = {}, .duration_s = 5};
  for (const auto& frame : say(silence, plain_style()).frames) {
    EXPECT_LT(frame.weights[shape("jawOpen")], 0.01F);
    EXPECT_LT(frame.weights[shape("mouthPucker")], 0.01F);
  }
}

TEST(Speech, MouthMovesAtTheRateOfSyllables) {
  Random random(2);
  const Utterance utterance = random_utterance("en", 60, 1.0, random);
  const auto motion = say(utterance, plain_style());
  int turns = 0;
  for (std::size_t i = 2; i < motion.frames.size(); ++i) {
    const auto jaw = [&](std::size_t j) { return motion.frames[j].weights[shape("jawOpen")]; };
    if (jaw(i - 1) > jaw(i - 2) && jaw(i - 1) >= jaw(i) && jaw(i - 1) > 0.08F) ++turns;
  }
  const double rate = turns / 60.0;
  EXPECT_GT(rate, 2.0);
  EXPECT_LT(rate, 7.5);
}

TEST(RandomUtterance, SpeaksAtLeastFourLanguagesUnlikeEachOther) {
  ASSERT_GE(languages().size(), 4U);
  std::set<std::set<std::string>> inventories;
  for (const std::string_view language : languages()) {
    Random random(3);
    const Utterance utterance = random_utterance(language, 300, 1, random);
    EXPECT_EQ(utterance.language, language);
    std::set<std::string> inventory;
    for (const auto& phoneme : utterance.phonemes) inventory.insert(phoneme.ipa);
    EXPECT_GT(inventory.size(), 25U) << language;
    inventories.insert(std::move(inventory));
  }
  EXPECT_EQ(inventories.size(), languages().size());
  const auto has = [](std::string_view language, std::string_view ipa) {
    Random random(4);
    const Utterance utterance = random_utterance(language, 600, 1, random);
    return std::ranges::any_of(utterance.phonemes,
                               [&](const auto& phoneme) { return phoneme.ipa.ends_with(ipa); });
  };
  EXPECT_TRUE(has("en", "θ"));
  EXPECT_FALSE(has("ja", "θ"));
  EXPECT_TRUE(has("de", "øː"));
  EXPECT_FALSE(has("es", "øː"));
  EXPECT_TRUE(has("fr", "ɥ"));
  EXPECT_TRUE(has("cmn", "tɕ"));
}

TEST(RandomUtterance, PhonemesAreInOrderAndInTime) {
  for (const std::string_view language : languages()) {
    Random random(6);
    const Utterance utterance = random_utterance(language, 60, 1, random);
    double free_s = 0;
    double spoken_s = 0;
    for (const auto& phoneme : utterance.phonemes) {
      EXPECT_GE(phoneme.start_s, free_s - 1e-9);
      EXPECT_GT(phoneme.end_s, phoneme.start_s + 0.02);
      EXPECT_LT(phoneme.end_s - phoneme.start_s, 0.8);
      free_s = phoneme.end_s;
      spoken_s += phoneme.end_s - phoneme.start_s;
    }
    EXPECT_LE(free_s, 60);
    // People pause; mean sound lengths are 50 to 130 ms.
    EXPECT_GT(spoken_s / 60, 0.6) << language;
    EXPECT_LT(spoken_s / 60, 0.97) << language;
    const double mean_s = spoken_s / static_cast<double>(utterance.phonemes.size());
    EXPECT_GT(mean_s, 0.045) << language;
    EXPECT_LT(mean_s, 0.13) << language;
  }
}

TEST(RandomUtterance, IsDrawnFromItsSeed) {
  Random a(1);
  Random b(1);
  EXPECT_EQ(random_utterance("de", 10, 1, a), random_utterance("de", 10, 1, b));
  EXPECT_NE(random_utterance("de", 10, 1, a), random_utterance("de", 10, 1, b = Random(2)));
}

TEST(RandomUtterance, ActedLinesOpenMoreInAngerThanInSadness) {
  const auto opening = [](Emotion emotion) {
    Script script;
    Segment segment;
    segment.block = Block::acted;
    segment.emotion = emotion;
    segment.intensity = 0.8;
    segment.duration_s = 30;
    script.segments.push_back(segment);
    double sum = 0;
    for (const auto& frame : perform(script, plain_style(), Random(3)).frames)
      sum += frame.weights[shape("jawOpen")];
    return sum;
  };
  EXPECT_GT(opening(Emotion::anger), 1.3 * opening(Emotion::sadness));
}

constexpr std::string_view kGood =
    R"({"language":"en","text":"pa","rate_hz":22050,"phonemes":[{"ipa":"p","start_s":0.1,"end_s":0.2},{"ipa":"ˈɑː","start_s":0.2,"end_s":0.45}]})";

TEST(ParseUtterance, ReadsWhatSpeakWrites) {
  const auto utterance = parse_utterance(kGood);
  ASSERT_TRUE(utterance.has_value()) << utterance.error().message();
  EXPECT_EQ(utterance->language, "en");
  EXPECT_EQ(utterance->text, "pa");
  ASSERT_EQ(utterance->phonemes.size(), 2U);
  EXPECT_EQ(utterance->phonemes[1].ipa, "ˈɑː");
  EXPECT_DOUBLE_EQ(utterance->phonemes[1].end_s, 0.45);
  EXPECT_DOUBLE_EQ(utterance->duration_s, 0.45);
}

TEST(ParseUtterance, RefusesEachWrongInputAlone) {
  const auto code = [](std::string_view json) {
    const auto result = parse_utterance(json);
    return result ? ErrorCode::internal : result.error().code;
  };
  EXPECT_EQ(code(""), ErrorCode::malformed);
  EXPECT_EQ(code("[]"), ErrorCode::malformed);
  EXPECT_EQ(code(kGood.substr(0, kGood.size() - 3)), ErrorCode::malformed);
  EXPECT_EQ(code(R"({"phonemes":[]})"), ErrorCode::malformed);
  EXPECT_EQ(code(R"({"language":"en"})"), ErrorCode::malformed);
  EXPECT_EQ(code(R"({"language":3,"phonemes":[]})"), ErrorCode::malformed);
  EXPECT_EQ(code(R"({"language":"en","phonemes":[1]})"), ErrorCode::malformed);
  EXPECT_EQ(code(R"({"language":"en","phonemes":[{"ipa":"p","start_s":0}]})"), ErrorCode::malformed);
  EXPECT_EQ(code(R"({"language":"en","phonemes":[{"ipa":"p","start_s":"0","end_s":1}]})"),
            ErrorCode::malformed);
  EXPECT_EQ(code(R"({"language":"en","phonemes":[{"ipa":"p","start_s":-1,"end_s":1}]})"),
            ErrorCode::out_of_range);
  EXPECT_EQ(code(R"({"language":"en","phonemes":[{"ipa":"p","start_s":1,"end_s":0.5}]})"),
            ErrorCode::out_of_range);
  EXPECT_EQ(code(R"({"language":"en","phonemes":[{"ipa":"p","start_s":1,"end_s":1e300}]})"),
            ErrorCode::out_of_range);
  EXPECT_EQ(code(R"({"language":"en","phonemes":[{"ipa":"p","start_s":1,"end_s":1e999}]})"),
            ErrorCode::malformed);
  EXPECT_EQ(
      code(
          R"({"language":"en","phonemes":[{"ipa":"p","start_s":1,"end_s":2},{"ipa":"a","start_s":0,"end_s":2}]})"),
      ErrorCode::out_of_range);
  EXPECT_EQ(code("{\"language\":\"en\",\"phonemes\":[{\"ipa\":\"" + std::string(33, 'a') +
                 "\",\"start_s\":0,\"end_s\":1}]}"),
            ErrorCode::out_of_range);
  EXPECT_EQ(code("{\"language\":\"en\",\"phonemes\":[{\"ipa\":\"\xFF\",\"start_s\":0,\"end_s\":1}]}"),
            ErrorCode::malformed);
}

TEST(ParseUtterance, SurvivesDeepNesting) {
  EXPECT_FALSE(parse_utterance(std::string(200'000, '[')).has_value());
}

}  // namespace
}  // namespace mien::performer::speech_test
