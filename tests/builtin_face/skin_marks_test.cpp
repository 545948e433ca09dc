#include "mien/builtin_face/skin_marks.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace mien::builtin_face::skin_marks_test {
namespace {

struct Amounts {
  float freckles = 0, stubble = 0;  ///< Most anywhere.
  std::size_t moles = 0;
};

Amounts amounts(const BuiltinParameters& parameters) {
  const face::Face face = make_builtin(parameters);
  const face::SkinMarks marks = skin_marks(parameters, face);
  EXPECT_EQ(marks.amount.size(), face.neutral_m.size());
  Amounts most{.moles = marks.moles.size()};
  for (const Eigen::Vector2f& at : marks.amount) {
    most.freckles = std::max(most.freckles, at.x());
    most.stubble = std::max(most.stubble, at.y());
    EXPECT_GE(at.minCoeff(), 0);
    EXPECT_LE(at.maxCoeff(), 1);
  }
  return most;
}

TEST(SkinMarks, FrecklesLieOnFairSkinMostWhereHairIsRed) {
  const float red = amounts({.skin_tone = 0.02, .hair_tone = 0.2, .hair_red = 1}).freckles;
  const float fair = amounts({.skin_tone = 0.02, .hair_tone = 0.2, .hair_red = 0}).freckles;
  EXPECT_GT(red, 3 * fair);
  EXPECT_GT(fair, 0);
  EXPECT_EQ(amounts({.skin_tone = 0.7, .hair_red = 1}).freckles, 0);
}

TEST(SkinMarks, StubbleGoesByTheBeardAndKeepsToIt) {
  EXPECT_EQ(amounts({}).stubble, 0);
  EXPECT_NEAR(amounts({.beard = 0.5}).stubble, 0.5, 0.01);
  const BuiltinParameters parameters{.beard = 1};
  const face::Face face = make_builtin(parameters);
  const face::SkinMarks marks = skin_marks(parameters, face);
  for (std::size_t i = 0; i < face.neutral_m.size(); ++i) {
    if (face.neutral_m[i].y() <= 0.03F) continue;
    EXPECT_EQ(marks.amount[i].y(), 0) << "above the cheekbones";
  }
}

TEST(SkinMarks, MolesAreAPersonsOwnAndNoneOfTheSymmetricFace) {
  EXPECT_EQ(amounts({}).moles, 0U);
  std::size_t most = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed)
    most = std::max(most, amounts({.asymmetry_seed = seed}).moles);
  EXPECT_GE(most, 2U);
  EXPECT_LE(most, 9U);
  const BuiltinParameters parameters{.asymmetry_seed = 5};
  const face::Face face = make_builtin(parameters);
  const auto once = skin_marks(parameters, face), twice = skin_marks(parameters, face);
  ASSERT_EQ(once.moles.size(), twice.moles.size());
  for (std::size_t i = 0; i < once.moles.size(); ++i)
    EXPECT_EQ(once.moles[i].centre_m, twice.moles[i].centre_m);
}

}  // namespace
}  // namespace mien::builtin_face::skin_marks_test
