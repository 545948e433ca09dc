#include "mien/speech/articulator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string_view>
#include <vector>

#include "mien/builtin_face/builtin_face.h"

namespace mien::speech::articulator_test {
namespace {

using face::shape;

/// Sounds of so many ms each, one after the other, from 0.5 s on.
std::vector<TimedSound> said(std::initializer_list<std::pair<std::string_view, int>> sounds) {
  std::vector<TimedSound> out;
  double at_s = 0.5;
  for (const auto& [symbol, ms] : sounds) {
    out.push_back({Visemes::standard().of_arpabet(symbol), at_s, at_s + 1e-3 * ms});
    at_s = out.back().end_s;
  }
  return out;
}

double middle(const TimedSound& sound) {
  return 0.5 * (sound.begin_s + sound.end_s);
}

TEST(Articulator, SilenceIsAMouthAtRest) {
  const Articulator articulator;
  EXPECT_EQ(articulator.at(1, {}).weights, face::BlendshapeWeights{});
  const auto sounds = said({{"AA", 100}});
  for (const double t : {-1.0, 0.0, 1.2, 3.0}) {
    const Mouth mouth = articulator.at(t, sounds);
    for (std::size_t k = 0; k < face::kShapeCount; ++k) EXPECT_NEAR(mouth.weights[k], 0, 1e-3);
    EXPECT_EQ(mouth.closure, 0);
  }
}

TEST(Articulator, OpenVowelsOpenTheJaw) {
  const auto sounds = said({{"T", 70}, {"AA", 140}, {"T", 70}, {"IY", 120}, {"S", 90}});
  const Articulator articulator;
  const auto jaw = [&](std::size_t i) {
    return articulator.at(middle(sounds[i]), sounds).weights[shape("jawOpen")];
  };
  EXPECT_GT(jaw(1), 0.3F);
  EXPECT_LT(jaw(3), 0.2F);
  EXPECT_LT(jaw(4), jaw(3));
}

TEST(Articulator, TheLipsMeetForEveryBilabial) {
  const Articulator articulator;
  // However short the sound and however open its neighbours.
  for (const char* bilabial : {"P", "B", "M"})
    for (const int ms : {15, 40, 90, 200}) {
      const auto sounds = said({{"AA", 150}, {bilabial, ms}, {"AA", 150}});
      double first = -1, last = -1;
      for (double t = 0.4; t < 1.2; t += 0.001) {
        const Mouth mouth = articulator.at(t, sounds);
        EXPECT_LE(mouth.weights[shape("mouthClose")], mouth.weights[shape("jawOpen")]);
        if (mouth.closure < 0.999F) continue;
        EXPECT_FLOAT_EQ(mouth.weights[shape("mouthClose")], mouth.closure * mouth.weights[shape("jawOpen")]);
        EXPECT_NEAR(mouth.weights[shape("mouthLowerDown_L")], 0, 1e-3);
        if (first < 0) first = t;
        last = t;
      }
      ASSERT_GT(first, 0) << bilabial << ms;
      EXPECT_GE(last - first, 0.035) << bilabial << " of " << ms << " ms";
      EXPECT_LE(first, sounds[1].begin_s + 0.01);
      EXPECT_GE(last, sounds[1].begin_s + 0.7e-3 * ms);
      // Not before, and not for long after.
      EXPECT_EQ(articulator.at(sounds[1].begin_s - 0.18, sounds).closure, 0);
      EXPECT_EQ(articulator.at(sounds[1].end_s + 0.07, sounds).closure, 0);
    }
}

/// The gap between the inner lips on the built-in face, in their middle, mm.
double gap_mm(const face::BlendshapeWeights& weights) {
  static const face::Face face = builtin_face::make_builtin();
  constexpr std::size_t kUpper = 62, kLower = 66;  // Multi-PIE's.
  std::vector<Vec3f> vertices(face.neutral_m.size());
  face::evaluate(face, weights, 0, vertices);
  return 1e3 * double{(vertices[face.landmarks[kUpper]] - vertices[face.landmarks[kLower]]).norm()};
}

TEST(Articulator, ClosedLipsHaveNoGapOnAFace) {
  const Articulator articulator;
  for (const char* before : {"AA", "IY", "UW", "S", "OW"}) {
    const auto sounds = said({{before, 120}, {"M", 70}, {"AE", 120}});
    const double open = gap_mm(articulator.at(middle(sounds[2]), sounds).weights);
    const double shut = gap_mm(articulator.at(middle(sounds[1]), sounds).weights);
    EXPECT_LT(shut, 1) << "after " << before;
    EXPECT_GT(open, 5);
  }
}

TEST(Articulator, RoundVowelsRoundTheLipsBeforeTheyAreHeard) {
  const auto sounds = said({{"S", 90}, {"T", 60}, {"UW", 150}});
  const Articulator articulator;
  const auto pucker = [&](double t) { return articulator.at(t, sounds).weights[shape("mouthPucker")]; };
  EXPECT_GT(pucker(middle(sounds[2])), 0.5F);
  EXPECT_GT(pucker(middle(sounds[1])), 0.2F) << "while the t is said";
  EXPECT_LT(pucker(sounds[0].begin_s - 0.1), 0.1F);
}

TEST(Articulator, ADiphthongMovesFromItsFirstPartToItsSecond) {
  const auto sounds = said({{"AW", 200}});
  const Articulator articulator;
  const auto early = articulator.at(0.55, sounds).weights, late = articulator.at(0.69, sounds).weights;
  EXPECT_GT(early[shape("jawOpen")], late[shape("jawOpen")] + 0.1F);
  EXPECT_GT(late[shape("mouthPucker")], early[shape("mouthPucker")] + 0.1F);
}

TEST(Articulator, MovesWithoutJumps) {
  const auto sounds =
      said({{"M", 60}, {"AA", 90}, {"P", 50}, {"UW", 80}, {"S", 90}, {"AY", 180}, {"B", 60}, {"IY", 90}});
  const Articulator articulator;
  Mouth before = articulator.at(0, sounds);
  for (double t = 0.001; t < 2; t += 0.001) {
    const Mouth now = articulator.at(t, sounds);
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      EXPECT_NEAR(now.weights[k], before.weights[k], 0.03) << face::kShapeNames[k] << " at " << t;
      EXPECT_GE(now.weights[k], 0);
      EXPECT_LE(now.weights[k], 1);
    }
    before = now;
  }
}

}  // namespace
}  // namespace mien::speech::articulator_test
