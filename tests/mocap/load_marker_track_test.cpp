#include "mien/mocap/load_marker_track.h"

#include <gtest/gtest.h>

#include "mien/core/files.h"
#include "tests/folder.h"
#include "tests/mocap/c3d_bytes.h"

namespace mien::mocap::load_marker_track_test {
namespace {

MarkerTrack one() {
  MarkerTrack track{.name = "one", .markers = {"tip"}, .time_s = {0, 0.5}};
  track.position_m = {Vec3f(0.25F, 0.5F, 1), kLostMarker};
  return track;
}

TEST(LoadMarkerTrack, EachFormatIsToldByItsContent) {
  const mien::test::Folder folder;
  for (const char* name : {"one.csv", "one.trc"}) {
    const auto path = folder / name;
    ASSERT_TRUE(write_marker_track(path, one()));
    EXPECT_TRUE(is_marker_recording(path));
    const auto track = load_marker_track(path);
    ASSERT_TRUE(track) << track.error().message();
    EXPECT_EQ(track->name, "one");
    EXPECT_EQ(track->markers, one().markers);
    EXPECT_TRUE(track->position_m[0].isApprox(one().position_m[0]));
  }
  C3dFile file;
  file.labels = {"tip"};
  file.values = {1, 2, 3, 0};
  ASSERT_TRUE(write_file(folder / "one.c3d", file.bytes()));
  EXPECT_TRUE(is_marker_recording(folder / "one.c3d"));
  EXPECT_EQ(load_marker_track(folder / "one.c3d")->frames(), 1u);
}

TEST(LoadMarkerTrack, OthersAreNone) {
  const mien::test::Folder folder;
  ASSERT_TRUE(write_file(folder / "face.csv", std::string_view("Timecode,BlendShapeCount\n")));
  EXPECT_FALSE(is_marker_recording(folder / "face.csv"));
  EXPECT_EQ(load_marker_track(folder / "face.csv").error().code, ErrorCode::unsupported);
  EXPECT_FALSE(is_marker_recording(folder / "none.csv"));
  EXPECT_EQ(load_marker_track(folder / "none.csv").error().code, ErrorCode::not_found);
  EXPECT_EQ(write_marker_track(folder / "one.c3d", one()).error().code, ErrorCode::bad_usage);
}

}  // namespace
}  // namespace mien::mocap::load_marker_track_test
