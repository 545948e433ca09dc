#include "lab/speech/mouth_score.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/builtin_face/builtin_face.h"

namespace mien::lab::mouth_score_test {
namespace {

constexpr std::size_t kJaw = face::shape("jawOpen"), kBrow = face::shape("browOuterUp_L");

/// A jaw that opens and closes.
std::vector<face::BlendshapeWeights> talk(float gain) {
  std::vector<face::BlendshapeWeights> frames(60);
  for (std::size_t f = 0; f < frames.size(); ++f)
    frames[f][kJaw] = 0.3F + gain * std::sin(0.3F * static_cast<float>(f));
  return frames;
}

TEST(MouthScore, BrowsDoNotCountAndTheJawDoes) {
  const measure::Meter meter(builtin_face::make_builtin());
  const auto truth = talk(0.2F);
  auto shown = truth;
  for (face::BlendshapeWeights& weights : shown) weights[kBrow] = 1;
  const measure::Stretch brows{truth, shown};
  const MouthScore exact = score_mouth(meter, {&brows, 1});
  EXPECT_NEAR(exact.mouth_mm, 0, 1e-6);
  EXPECT_NEAR(exact.jaw.value(), 1, 1e-6);

  const auto against = talk(-0.2F);
  const measure::Stretch jaws{truth, against};
  const MouthScore wrong = score_mouth(meter, {&jaws, 1});
  EXPECT_GT(wrong.mouth_mm, 0.1);
  EXPECT_NEAR(wrong.jaw.value(), -1, 1e-6);
  // Both as one.
  const std::array both = {brows, jaws};
  EXPECT_NEAR(score_mouth(meter, both).mouth_mm, 0.5 * wrong.mouth_mm, 1e-6);
}

TEST(MouthScore, AJawThatStandsStillHasNoCorrelation) {
  const measure::Meter meter(builtin_face::make_builtin());
  const auto truth = talk(0.2F), still = talk(0);
  const measure::Stretch stretch{truth, still};
  EXPECT_FALSE(score_mouth(meter, {&stretch, 1}).jaw);
}

}  // namespace
}  // namespace mien::lab::mouth_score_test
