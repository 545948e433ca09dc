#include "mien/virtual/performance.h"

#include <gtest/gtest.h>

#include <utility>

#include "tests/virtual/three_sensors.h"

namespace mien::virt::performance_test {
namespace {

Performance performed(const Wearing& wearing, std::uint64_t seed = 1) {
  const Random root(seed);
  VirtualPerson person = draw_person(root);
  auto out =
      perform_with(wearing, person.face, draw_motion(2, person.style, root), test::three_sensors(), root);
  EXPECT_TRUE(out) << out.error().message();
  return std::move(*out);
}

TEST(Performance, LastsAsLongAsItsMotionAfterThePrologue) {
  const Performance played = performed({.faults = test::mild_faults()});
  EXPECT_EQ(played.sites.size(), 3U);
  EXPECT_NEAR(played.end_s - played.begin_s, 2, 0.05);
  EXPECT_GT(played.begin_s, 8) << "neutral, nod, shake";
  const Performance lab = performed({.lab = true});
  EXPECT_LT(lab.begin_s, 5) << "neutral alone";
}

TEST(Performance, WornAnotherWayTheRestIsTheSame) {
  const Wearing plain{.faults = test::mild_faults()};
  Wearing off = plain;
  off.faults.mount_position_mm = 5;
  Wearing turned = plain;
  turned.turn_rad = 0.2;
  Wearing skin = plain;
  skin.kinematics = KinematicsSpread{};
  const Performance first = performed(plain);
  for (const Wearing& other : {off, turned, skin}) {
    const Performance second = performed(other);
    ASSERT_EQ(second.session.truth.size(), first.session.truth.size());
    EXPECT_EQ(second.session.truth[700].weights, first.session.truth[700].weights);
    face::BlendshapeWeights weights;
    weights[face::shape("jawOpen")] = 1;
    EXPECT_GT(angle_between(second.sites[0].rotation(weights), first.sites[0].rotation(weights)), 1e-4);
  }
  EXPECT_EQ(performed(plain).session.samples.size(), first.session.samples.size());
}

TEST(Performance, NeedsAMotion) {
  const auto none =
      perform_with({}, draw_person(Random(1)).face, face::Motion{}, test::three_sensors(), Random(1));
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::bad_usage);
}

}  // namespace
}  // namespace mien::virt::performance_test
