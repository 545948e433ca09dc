#include "mien/mocap/marker_swaps.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mien::mocap::marker_swaps_test {
namespace {

constexpr std::size_t kFrames = 500;

/// Three markers that sway together at 100 Hz, 12 and 14 mm apart.
MarkerTrack swaying() {
  MarkerTrack track{.name = "sway"};
  track.markers = {"a", "b", "c"};
  for (std::size_t i = 0; i < kFrames; ++i) {
    const double t = 0.01 * static_cast<double>(i);
    const auto sway = static_cast<float>(0.005 * std::sin(3 * t));
    track.time_s.push_back(t);
    track.position_m.emplace_back(sway, 0.0F, 0.0F);
    track.position_m.emplace_back(0.012F + 0.5F * sway, 0.0F, sway);
    track.position_m.emplace_back(0.006F, 0.0126F - sway, 0.0F);
  }
  return track;
}

void swap_in(MarkerTrack& track, std::size_t a, std::size_t b, std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) std::swap(track.frame(i)[a], track.frame(i)[b]);
}

TEST(MendSwaps, WhatIsRightStays) {
  MarkerTrack track = swaying();
  EXPECT_TRUE(mend_swaps(track).empty());
  EXPECT_EQ(track.position_m, swaying().position_m);
}

TEST(MendSwaps, GivesNamesBack) {
  MarkerTrack track = swaying();
  swap_in(track, 0, 1, 100, 160);
  swap_in(track, 1, 2, 300, 301);
  const auto swaps = mend_swaps(track);
  ASSERT_EQ(swaps.size(), 2u);
  EXPECT_EQ(track.position_m, swaying().position_m);
  for (const MarkerSwap& swap : swaps) {
    EXPECT_TRUE(swap.mended);
    EXPECT_EQ(swap.begin, swap.a == 0 ? 100u : 300u);
    EXPECT_EQ(swap.end, swap.a == 0 ? 160u : 301u);
  }
}

TEST(MendSwaps, FromTheFirstFrameAndToTheLast) {
  MarkerTrack track = swaying();
  swap_in(track, 0, 1, 0, 80);
  swap_in(track, 0, 1, 450, kFrames);
  EXPECT_EQ(mend_swaps(track).size(), 2u);
  EXPECT_EQ(track.position_m, swaying().position_m);
}

TEST(MendSwaps, GoOnBehindAGap) {
  MarkerTrack track = swaying();
  swap_in(track, 0, 1, 100, 160);
  for (std::size_t i = 90; i < 130; ++i) track.frame(i)[0] = kLostMarker;
  MarkerTrack whole = swaying();
  for (std::size_t i = 90; i < 130; ++i) {
    // What was lost under the name "a" was b where the names were crossed.
    whole.frame(i)[i < 100 ? 0 : 1] = kLostMarker;
  }
  (void)mend_swaps(track);
  for (std::size_t i = 130; i < kFrames; ++i)
    for (std::size_t m = 0; m < 3; ++m) EXPECT_EQ(track.frame(i)[m], whole.frame(i)[m]) << i;
}

TEST(LoseStrays, OnesThatJumpAwayAndComeBackAreLost) {
  MarkerTrack track = swaying();
  for (std::size_t i = 200; i < 240; ++i) track.frame(i)[1] += Vec3f(0.05F, 0.02F, 0);
  const auto strays = lose_strays(track);
  ASSERT_EQ(strays.size(), 1u);
  EXPECT_EQ(strays[0].marker, 1u);
  EXPECT_EQ(strays[0].begin, 200u);
  EXPECT_EQ(strays[0].end, 240u);
  for (std::size_t i = 0; i < kFrames; ++i) EXPECT_EQ(is_seen(track.frame(i)[1]), i < 200 || i >= 240);
}

TEST(LoseStrays, AMarkerThatMovesOnStays) {
  MarkerTrack track = swaying();
  for (std::size_t i = 200; i < kFrames; ++i) track.frame(i)[1] += Vec3f(0.05F, 0.02F, 0);
  EXPECT_TRUE(lose_strays(track).empty());
}

TEST(UsualPlaces, AreMediansOfWhatIsSeen) {
  MarkerTrack track{.markers = {"a", "b"}, .time_s = {0, 1, 2}};
  track.position_m = {Vec3f(1, 5, 0), kLostMarker, Vec3f(2, 4, 0), kLostMarker, Vec3f(9, 3, 0), kLostMarker};
  const auto places = usual_places(track);
  EXPECT_EQ(places[0], Vec3f(2, 4, 0));
  EXPECT_FALSE(is_seen(places[1]));
}

}  // namespace
}  // namespace mien::mocap::marker_swaps_test
