#include "mien/synthetic/shifted_person.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "mien/virtual/performance.h"

namespace mien::synthetic::shifted_person_test {
namespace {

constexpr std::size_t kOtherNeutral = 1, kOtherResponse = 2;

/// The motion before another system reports it.
face::Motion as_performed(const Random& root, double seconds) {
  return virt::draw_motion(seconds, virt::draw_person(root).style, root);
}

bool moves_alike(const face::Motion& a, const face::Motion& b, std::size_t shape) {
  return std::ranges::equal(a.frames, b.frames, [&](const face::MotionFrame& x, const face::MotionFrame& y) {
    return x.weights[shape] == y.weights[shape];
  });
}

TEST(ShiftedPerson, ReportsWhatStaysWithinAFace) {
  for (std::size_t kind = 0; kind < 2 * kShiftKinds; ++kind) {
    const ShiftedPerson person = draw_shifted_person(kind, 10, Random(3));
    ASSERT_EQ(person.motion.frames.size(), 600U) << kind;
    for (const face::MotionFrame& frame : person.motion.frames) {
      EXPECT_LE(frame.weights[face::shape("mouthClose")], frame.weights[face::shape("jawOpen")]);
      for (const float weight : frame.weights.values) {
        EXPECT_GE(weight, 0);
        EXPECT_LE(weight, 1.3);
      }
    }
  }
}

TEST(ShiftedPerson, AnotherNeutralIsAnOffsetThatFullWeightsDoNotShow) {
  const face::Motion performed = as_performed(Random(4), 5);
  const face::Motion reported = draw_shifted_person(kOtherNeutral, 5, Random(4)).motion;
  ASSERT_EQ(reported.frames.size(), performed.frames.size());
  std::size_t offset = 0;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    if (moves_alike(performed, reported, k)) continue;
    ++offset;
    // w' = r + (1 - r) w: of any frame the same r follows.
    const auto rest = [&](std::size_t f) {
      return (reported.frames[f].weights[k] - performed.frames[f].weights[k]) /
             (1 - performed.frames[f].weights[k]);
    };
    if (performed.frames[0].weights[k] < 0.9F && performed.frames[200].weights[k] < 0.9F) {
      EXPECT_NEAR(rest(0), rest(200), 1e-3) << face::kShapeNames[k];
    }
    EXPECT_GE(rest(0), 0) << face::kShapeNames[k];
  }
  EXPECT_GT(offset, 4U);
  EXPECT_LT(offset, 30U);
  for (const std::size_t anchored : {face::shape("jawOpen"), face::shape("eyeBlink_L"),
                                     face::shape("eyeLookUp_R"), face::shape("mouthClose")})
    EXPECT_TRUE(moves_alike(performed, reported, anchored)) << face::kShapeNames[anchored];
}

TEST(ShiftedPerson, AnotherResponseBendsEveryShapeThatIsNotAnchored) {
  const face::Motion performed = as_performed(Random(5), 5);
  const face::Motion reported = draw_shifted_person(kOtherResponse, 5, Random(5)).motion;
  std::size_t bent = 0;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) bent += moves_alike(performed, reported, k) ? 0 : 1;
  EXPECT_GT(bent, 35U);
}

TEST(ShiftedPerson, SameRandomStateGivesTheSameBits) {
  for (std::size_t kind = 0; kind < kShiftKinds; ++kind) {
    const face::Motion one = draw_shifted_person(kind, 2, Random(6)).motion;
    const face::Motion two = draw_shifted_person(kind, 2, Random(6)).motion;
    for (std::size_t k = 0; k < face::kShapeCount; ++k) EXPECT_TRUE(moves_alike(one, two, k)) << kind;
  }
}

}  // namespace
}  // namespace mien::synthetic::shifted_person_test
