#include "mien/mocap/trc.h"

#include <gtest/gtest.h>

#include <string>

namespace mien::mocap::trc_test {
namespace {

const std::string kTwo =
    "PathFileType\t4\t(X/Y/Z)\ttwo.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
    "100.00\t100.00\t4\t2\tmm\t100.00\t1\t4\n"
    "Frame#\tTime\ttip\t\t\tchin_L\t\t\n"
    "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n"
    "\n"
    "1\t0.00\t1\t2\t3\t4\t5\t6\n"
    "2\t0.01\t\t\t\t4\t5\t6\n"
    "3\t0.02\t1\t2\t3\tnan\tnan\tnan\t\n"
    "4\t0.03\t1\t2\t3\t0\t0\t0.0\n";

Result<MarkerRecording> with(const std::string& what, const std::string& instead) {
  std::string text = kTwo;
  text.replace(text.find(what), what.size(), instead);
  return parse_trc(text, "two.trc");
}

TEST(Trc, ReadsPositionsTimesAndWhatIsLost) {
  ASSERT_TRUE(is_trc(kTwo));
  const auto read = parse_trc(kTwo, "two.trc");
  ASSERT_TRUE(read) << read.error().message();
  const MarkerTrack& track = read->track;
  EXPECT_EQ(track.markers, (std::vector<std::string>{"tip", "chin_L"}));
  EXPECT_EQ(track.time_s, (std::vector<double>{0, 0.01, 0.02, 0.03}));
  EXPECT_TRUE(track.frame(0)[1].isApprox(Vec3f(0.004F, 0.005F, 0.006F)));
  EXPECT_FALSE(is_seen(track.frame(1)[0]));
  EXPECT_FALSE(is_seen(track.frame(2)[1]));
  EXPECT_FALSE(is_seen(track.frame(3)[1]));
}

TEST(Trc, UnitsAreRead) {
  EXPECT_FLOAT_EQ(with("\tmm\t", "\tm\t")->track.frame(0)[0].x(), 1);
  EXPECT_FLOAT_EQ(with("\tmm\t", "\tcm\t")->track.frame(0)[0].x(), 0.01F);
  EXPECT_EQ(with("\tmm\t", "\tin\t").error().code, ErrorCode::unsupported);
}

TEST(Trc, WhatWasWrittenComesBack) {
  const auto read = parse_trc(kTwo, "two");
  ASSERT_TRUE(read);
  const std::string text = format_trc(read->track);
  const auto again = parse_trc(text, "again");
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(format_trc(again->track), text);
  EXPECT_EQ(again->track.markers, read->track.markers);
  EXPECT_FALSE(is_seen(again->track.frame(1)[0]));
}

TEST(Trc, WhatIsWrongIsRefused) {
  EXPECT_EQ(with("PathFileType", "FileType").error().code, ErrorCode::malformed);
  EXPECT_EQ(with("Units", "Lengths").error().code, ErrorCode::malformed);
  EXPECT_EQ(with("\t2\tmm", "\t3\tmm").error().code, ErrorCode::malformed);
  EXPECT_EQ(with("\t2\tmm", "\t\tmm").error().code, ErrorCode::malformed);
  EXPECT_EQ(with("Frame#", "Frame").error().code, ErrorCode::malformed);
  EXPECT_EQ(with("tip\t\t\tchin_L", "tip\t\tchin_L").error().code, ErrorCode::malformed);
  EXPECT_EQ(with("chin_L", "tip").error().code, ErrorCode::malformed);
  EXPECT_EQ(with("X1\tY1", "U1\tV1").error().code, ErrorCode::malformed);
  EXPECT_EQ(with("2\t0.01\t\t\t\t", "2\t0.01\t1\t\t\t").error().code, ErrorCode::malformed);
  EXPECT_EQ(with("3\t0.02", "3\t0.01").error().code, ErrorCode::malformed);
  EXPECT_EQ(with("1\t2\t3\t4\t5\t6", "1\t2\t3\t4\t5\t6\t7").error().code, ErrorCode::malformed);
  EXPECT_EQ(parse_trc(kTwo.substr(0, kTwo.find("1\t0.00")), "cut").error().code, ErrorCode::truncated);
  EXPECT_FALSE(parse_trc("PathFileType", "cut"));
}

}  // namespace
}  // namespace mien::mocap::trc_test
