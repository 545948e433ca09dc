#include "mien/mocap/marker_retarget.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/builtin_face/builtin_face.h"
#include "tests/project_path.h"

namespace mien::mocap::marker_retarget_test {
namespace {

const builtin_face::MarkerSet& set() {
  static const builtin_face::MarkerSet read =
      builtin_face::read_markers(project_path("rigs/markers.toml")).value();
  return read;
}

face::Motion opening() {
  face::Motion motion;
  motion.name = "opening";
  for (int i = 0; i < 120; ++i) {
    face::MotionFrame& frame = motion.frames.emplace_back();
    frame.time_s = i / 60.0;
    frame.weights[face::shape("jawOpen")] = static_cast<float>(0.4 - 0.4 * std::cos(0.05 * i));
    frame.has_face = i < 60 || i >= 70;
  }
  return motion;
}

TEST(RetargetMarkers, GivesTheWeightsBack) {
  const auto placed = builtin_face::PlacedMarkers::place(builtin_face::make_builtin(), set());
  ASSERT_TRUE(placed);
  const face::Motion motion = opening();
  const auto matched = match_markers(markers_of_motion(motion, *placed, set()), set());
  ASSERT_TRUE(matched);
  const auto clean = clean_markers(*matched, *placed, {.outlier_sigmas = 100, .remove_head = false});
  ASSERT_TRUE(clean) << clean.error().message();
  const auto solved = retarget_markers(*clean, *placed);
  ASSERT_TRUE(solved) << solved.error().message();
  ASSERT_EQ(solved->motion.frames.size(), motion.frames.size());
  EXPECT_EQ(solved->without_face, 10u);
  EXPECT_FALSE(solved->motion.has_head);
  EXPECT_LT(solved->residual_mm, 0.2);
  for (std::size_t i = 0; i < motion.frames.size(); ++i) {
    EXPECT_EQ(solved->motion.frames[i].has_face, motion.frames[i].has_face);
    if (motion.frames[i].has_face) {
      EXPECT_NEAR(solved->motion.frames[i].weights[face::shape("jawOpen")],
                  motion.frames[i].weights[face::shape("jawOpen")], 0.05);
    }
  }
}

TEST(RetargetMarkers, NeedsTheFacesMarkers) {
  const auto placed = builtin_face::PlacedMarkers::place(builtin_face::make_builtin(), set());
  ASSERT_TRUE(placed);
  EXPECT_EQ(retarget_markers(CleanMarkers{}, *placed).error().code, ErrorCode::mismatch);
}

}  // namespace
}  // namespace mien::mocap::marker_retarget_test
