#include "mien/mocap/marker_cleaning.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/builtin_face/builtin_face.h"
#include "mien/mocap/marker_retarget.h"
#include "mien/mocap/rigid_points.h"
#include "tests/project_path.h"

namespace mien::mocap::marker_cleaning_test {
namespace {

struct Lab {
  builtin_face::MarkerSet set = builtin_face::read_markers(project_path("rigs/markers.toml")).value();
  builtin_face::PlacedMarkers placed =
      builtin_face::PlacedMarkers::place(builtin_face::make_builtin(), set).value();
};

const Lab& lab() {
  static const Lab made;
  return made;
}

Eigen::Isometry3d head_at(double t) {
  Eigen::Isometry3d camera_head = Eigen::Isometry3d::Identity();
  camera_head.linear() = (Eigen::AngleAxisd(1.2 + 0.3 * std::sin(t), Vec3::UnitY()) *
                          Eigen::AngleAxisd(0.2 * std::sin(0.7 * t), Vec3::UnitX()))
                             .toRotationMatrix();
  camera_head.translation() = Vec3(1, 1.5 + 0.05 * std::sin(t), -2);
  return camera_head;
}

face::Motion smiling() {
  face::Motion motion;
  motion.name = "smile";
  for (int i = 0; i < 600; ++i) {
    face::MotionFrame& frame = motion.frames.emplace_back();
    frame.time_s = 0.01 * i;
    const auto swing = static_cast<float>(i < 100 ? 0 : 0.5 - 0.5 * std::cos(2 * M_PI * 0.01 * (i - 100)));
    frame.weights[face::shape("mouthSmile_L")] = 0.8F * swing;
    frame.weights[face::shape("mouthSmile_R")] = 0.8F * swing;
    frame.weights[face::shape("jawOpen")] = 0.3F * swing;
  }
  return motion;
}

MatchedTrack matched(const MarkerTrack& track) {
  return match_markers(track, lab().set).value();
}

MarkerTrack filmed() {
  MarkerTrack track = markers_of_motion(smiling(), lab().placed, lab().set);
  for (std::size_t i = 0; i < track.frames(); ++i)
    for (Vec3f& point : track.frame(i))
      point = (head_at(track.time_s[i]) * point.cast<double>()).cast<float>();
  return track;
}

double worst_m(const MarkerTrack& a, const MarkerTrack& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.position_m.size(); ++i)
    if (is_seen(a.position_m[i]))
      worst = std::max(worst, static_cast<double>((a.position_m[i] - b.position_m[i]).norm()));
  return worst;
}

TEST(CleanMarkers, TakesTheHeadOut) {
  const auto clean = clean_markers(matched(filmed()), lab().placed, {.outlier_sigmas = 100});
  ASSERT_TRUE(clean) << clean.error().message();
  EXPECT_EQ(clean->report.without_head, 0u);
  EXPECT_EQ(clean->report.lost + clean->report.swaps + clean->report.strays + clean->report.outliers, 0u);
  // A smile moves the reference markers a little: that much is taken for the head's.
  EXPECT_LT(worst_m(clean->track, markers_of_motion(smiling(), lab().placed, lab().set)), 0.003);
  ASSERT_TRUE(clean->head[0]);
  EXPECT_LT((clean->head[0]->translation() - head_at(0).translation()).norm(), 0.003);
}

TEST(CleanMarkers, ABodyOnTheHeadTellsItExactly) {
  MarkerTrack track = filmed();
  MarkerTrack with_body{.name = track.name, .markers = track.markers, .time_s = track.time_s};
  const Vec3 body[] = {Vec3(-0.07, 0.1, 0), Vec3(0.07, 0.1, 0), Vec3(0, 0.13, 0.02), Vec3(0, 0.1, -0.08)};
  for (const char* name : {"H1", "H2", "H3", "H4"}) with_body.markers.emplace_back(name);
  for (std::size_t i = 0; i < track.frames(); ++i) {
    const auto frame = track.frame(i);
    with_body.position_m.insert(with_body.position_m.end(), frame.begin(), frame.end());
    for (const Vec3& place : body)
      with_body.position_m.emplace_back((head_at(track.time_s[i]) * place).cast<float>());
  }
  const auto with_head = match_markers(with_body, lab().set, {.head = {"H1", "H2", "H3", "H4"}});
  ASSERT_TRUE(with_head) << with_head.error().message();
  const auto clean =
      clean_markers(*with_head, lab().placed, {.neutral_s = std::pair(0.0, 0.5), .outlier_sigmas = 100});
  ASSERT_TRUE(clean) << clean.error().message();
  EXPECT_LT(worst_m(clean->track, markers_of_motion(smiling(), lab().placed, lab().set)), 1e-5);
  EXPECT_NEAR(clean->report.scale, 1, 1e-4);
}

TEST(CleanMarkers, AnotherSizeIsScaledByTheNeutral) {
  MarkerTrack track = filmed();
  for (Vec3f& point : track.position_m) point *= 1.1F;
  const auto clean =
      clean_markers(matched(track), lab().placed, {.neutral_s = std::pair(0.0, 0.5), .outlier_sigmas = 100});
  ASSERT_TRUE(clean) << clean.error().message();
  EXPECT_NEAR(clean->report.scale, 1 / 1.1, 1e-3);
  EXPECT_LT(worst_m(clean->track, markers_of_motion(smiling(), lab().placed, lab().set)), 0.003);
}

TEST(CleanMarkers, FramesWithoutThreeReferencesHaveNoHead) {
  MarkerTrack track = filmed();
  for (const ReferenceMarker& reference : reference_markers(lab().placed))
    for (std::size_t i = 50; i < 60; ++i) track.frame(i)[reference.marker] = kLostMarker;
  const auto clean = clean_markers(matched(track), lab().placed);
  ASSERT_TRUE(clean) << clean.error().message();
  EXPECT_EQ(clean->report.without_head, 10u);
  EXPECT_EQ(clean->report.lost, 80u);
  EXPECT_FALSE(clean->head[55]);
  for (const Vec3f& point : clean->track.frame(55)) EXPECT_FALSE(is_seen(point));
}

TEST(CleanMarkers, OutliersAreLostAndCounted) {
  MarkerTrack track = markers_of_motion(smiling(), lab().placed, lab().set);
  track.frame(300)[13] += Vec3f(0, 0, 0.009F);  // Too slow a step for a jump.
  const auto clean = clean_markers(matched(track), lab().placed, {.remove_head = false});
  ASSERT_TRUE(clean);
  EXPECT_GE(clean->report.outliers, 1u);
  EXPECT_FALSE(is_seen(clean->track.frame(300)[13]));
}

TEST(CleanMarkers, WhatCannotBeMeantIsRefused) {
  const MatchedTrack good = matched(filmed());
  EXPECT_EQ(clean_markers(good, lab().placed, {.outlier_sigmas = 0}).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(clean_markers(good, lab().placed, {.neutral_s = std::pair(2.0, 1.0)}).error().code,
            ErrorCode::bad_usage);
  EXPECT_EQ(clean_markers(good, lab().placed, {.neutral_s = std::pair(90.0, 91.0)}).error().code,
            ErrorCode::bad_usage);
  EXPECT_EQ(clean_markers(MatchedTrack{}, lab().placed).error().code, ErrorCode::mismatch);
  MatchedTrack blind = good;
  for (Vec3f& point : blind.face.position_m) point = kLostMarker;
  EXPECT_EQ(clean_markers(blind, lab().placed).error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace mien::mocap::marker_cleaning_test
