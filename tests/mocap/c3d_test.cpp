#include "mien/mocap/c3d.h"

#include <gtest/gtest.h>

#include <limits>
#include <span>

#include "tests/mocap/c3d_bytes.h"

namespace mien::mocap::c3d_test {
namespace {

C3dFile two() {
  C3dFile file;
  file.values = {1, 2, 3, 0.5F, 4, 5, 6, 0,   // Frame 1.
                 1, 2, 3, -1,   4, 5, 7, 0};  // Frame 2: the first is not seen.
  return file;
}

Result<MarkerRecording> read(const C3dFile& file) {
  return parse_c3d(file.bytes(), "two.c3d");
}

TEST(C3d, ReadsFloats) {
  ASSERT_TRUE(is_c3d(two().bytes()));
  const auto recording = read(two());
  ASSERT_TRUE(recording) << recording.error().message();
  const MarkerTrack& track = recording->track;
  EXPECT_EQ(track.markers, (std::vector<std::string>{"tip", "chin_L"}));
  EXPECT_EQ(track.time_s, (std::vector<double>{0, 0.01}));
  EXPECT_TRUE(track.frame(0)[0].isApprox(Vec3f(0.001F, 0.002F, 0.003F)));
  EXPECT_FALSE(is_seen(track.frame(1)[0]));
  EXPECT_TRUE(track.frame(1)[1].isApprox(Vec3f(0.004F, 0.005F, 0.007F)));
}

TEST(C3d, ReadsScaledIntegers) {
  C3dFile file = two();
  file.floats = false;
  file.units = "m ";
  const auto recording = read(file);
  ASSERT_TRUE(recording) << recording.error().message();
  EXPECT_EQ(recording->track.frame(0)[0], Vec3f(0.5F, 1, 1.5F));
  EXPECT_FALSE(is_seen(recording->track.frame(1)[0]));
}

TEST(C3d, PointsWithoutALabelOfTheirOwnAreNumbered) {
  C3dFile file = two();
  file.labels = {"tip", "tip"};
  EXPECT_EQ(read(file)->track.markers[1], "*2");
  file.labels = {"", "tip"};
  EXPECT_EQ(read(file)->track.markers[0], "*1");
}

TEST(C3d, MoreFramesThanCanBeCountedAreThoseThatAreThere) {
  C3dFile file = two();
  file.frames_said = 65535;
  EXPECT_EQ(read(file)->track.frames(), 2u);
  file.frames_said = 1;
  EXPECT_EQ(read(file)->track.frames(), 1u);
}

TEST(C3d, WhatIsWrongIsRefused) {
  const auto code = [](auto change) {
    C3dFile file = two();
    change(file);
    const auto recording = read(file);
    return recording ? ErrorCode::internal : recording.error().code;
  };
  EXPECT_EQ(code([](C3dFile& f) { f.processor = 85; }), ErrorCode::unsupported);
  EXPECT_EQ(code([](C3dFile& f) { f.processor = 86; }), ErrorCode::unsupported);
  EXPECT_EQ(code([](C3dFile& f) { f.processor = 1; }), ErrorCode::malformed);
  EXPECT_EQ(code([](C3dFile& f) { f.units = "in"; }), ErrorCode::unsupported);
  EXPECT_EQ(code([](C3dFile& f) { f.rate_hz = 0; }), ErrorCode::out_of_range);
  EXPECT_EQ(code([](C3dFile& f) { f.rate_hz = std::numeric_limits<float>::quiet_NaN(); }),
            ErrorCode::malformed);
  EXPECT_EQ(code([](C3dFile& f) { f.frames_said = 300; }), ErrorCode::truncated);
  EXPECT_EQ(code([](C3dFile& f) { f.rate_hz = 1e-30F; }), ErrorCode::out_of_range);
  EXPECT_EQ(code([](C3dFile& f) { f.frames_said = 0; }), ErrorCode::truncated);
  EXPECT_EQ(code([](C3dFile& f) { f.values[0] = 1e7F; }), ErrorCode::out_of_range);
  // A position that is no number was not seen.
  C3dFile file = two();
  file.values[0] = std::numeric_limits<float>::infinity();
  ASSERT_TRUE(read(file));
  EXPECT_FALSE(is_seen(read(file)->track.frame(0)[0]));
}

TEST(C3d, WhereverItIsCutItIsRefusedOrWhole) {
  const std::vector<std::byte> bytes = two().bytes();
  std::size_t end = bytes.size();  // Of what is not padding.
  while (bytes[end - 1] == std::byte{0}) --end;
  for (std::size_t size = 0; size < end; ++size) {
    const auto recording = parse_c3d(std::span(bytes).first(size), "cut");
    EXPECT_FALSE(recording) << size;
  }
}

}  // namespace
}  // namespace mien::mocap::c3d_test
