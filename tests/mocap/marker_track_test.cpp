#include "mien/mocap/marker_track.h"

#include <gtest/gtest.h>

namespace mien::mocap::marker_track_test {
namespace {

builtin_face::MarkerSet set_of(std::vector<std::string> names) {
  builtin_face::MarkerSet set{.name = "set"};
  for (std::string& name : names) set.markers.push_back({.name = std::move(name)});
  return set;
}

/// One frame, in which marker i is at x = i.
MarkerTrack track_of(std::vector<std::string> names) {
  MarkerTrack track{.name = "track"};
  track.markers = std::move(names);
  track.time_s = {0};
  for (std::size_t i = 0; i < track.count(); ++i)
    track.position_m.emplace_back(static_cast<float>(i), 0.0F, 0.0F);
  return track;
}

TEST(MatchMarkers, PutsThemInTheSetsOrder) {
  const auto matched = match_markers(track_of({"chin", "tip"}), set_of({"tip", "brow", "chin"}));
  ASSERT_TRUE(matched) << matched.error().message();
  EXPECT_EQ(matched->face.markers, (std::vector<std::string>{"tip", "brow", "chin"}));
  EXPECT_EQ(matched->face.frame(0)[0].x(), 1);
  EXPECT_FALSE(is_seen(matched->face.frame(0)[1]));
  EXPECT_EQ(matched->face.frame(0)[2].x(), 0);
  EXPECT_EQ(matched->missing, std::vector<std::string>{"brow"});
  EXPECT_EQ(matched->head.count(), 0u);
}

TEST(MatchMarkers, CaseAndWhatStandsBeforeAColonDoNotCount) {
  const auto matched = match_markers(track_of({"Face:Tip", "Unlabeled 12", "*3"}), set_of({"tip"}));
  ASSERT_TRUE(matched) << matched.error().message();
  EXPECT_EQ(matched->face.frame(0)[0].x(), 0);
  EXPECT_EQ(matched->unlabelled, 2u);
}

TEST(MatchMarkers, NamesCanBeGivenAndLeftOut) {
  const auto matched = match_markers(track_of({"M1", "M2", "H1", "H2"}), set_of({"tip"}),
                                     {.renamed = {{"M1", ""}, {"M2", "tip"}}, .head = {"H2", "H1"}});
  ASSERT_TRUE(matched) << matched.error().message();
  EXPECT_EQ(matched->face.frame(0)[0].x(), 1);
  ASSERT_EQ(matched->head.count(), 2u);
  EXPECT_EQ(matched->head.frame(0)[0].x(), 3);
}

TEST(MatchMarkers, StrangersAreAllListed) {
  const auto matched = match_markers(track_of({"tip", "knee", "toe"}), set_of({"tip"}));
  ASSERT_FALSE(matched);
  EXPECT_EQ(matched.error().code, ErrorCode::mismatch);
  EXPECT_NE(matched.error().what.find("knee, toe"), std::string::npos);
}

TEST(MatchMarkers, WhatCannotBeMeantIsRefused) {
  const builtin_face::MarkerSet set = set_of({"tip", "chin"});
  EXPECT_EQ(match_markers(track_of({"tip", "A:tip"}), set).error().code, ErrorCode::mismatch);
  EXPECT_EQ(match_markers(track_of({"*1"}), set).error().code, ErrorCode::mismatch);
  EXPECT_EQ(match_markers(track_of({"tip"}), set, {.renamed = {{"M1", "tip"}}}).error().code,
            ErrorCode::not_found);
  EXPECT_EQ(match_markers(track_of({"M1"}), set, {.renamed = {{"M1", "nose"}}}).error().code,
            ErrorCode::not_found);
  EXPECT_EQ(match_markers(track_of({"tip"}), set, {.head = {"H1"}}).error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace mien::mocap::marker_track_test
