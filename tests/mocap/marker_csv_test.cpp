#include "mien/mocap/marker_csv.h"

#include <gtest/gtest.h>

#include <string>

namespace mien::mocap::marker_csv_test {
namespace {

const std::string kTwo =
    "# from the lab\n"
    "time_s,tip_x_mm,tip_y_mm,tip_z_mm,chin_L_x_mm,chin_L_y_mm,chin_L_z_mm\n"
    "0,1,2,3,-4,5.5,6\n"
    "0.01,,,,-4,5.5,6.25\r\n"
    "\n"
    "0.02,1,2,3\n";

TEST(MarkerCsv, IsToldByItsFirstCell) {
  EXPECT_TRUE(is_marker_csv(kTwo));
  EXPECT_TRUE(is_marker_csv("\xEF\xBB\xBFtime_s,a_x_m\n"));
  EXPECT_FALSE(is_marker_csv("Timecode,BlendShapeCount\n"));
  EXPECT_FALSE(is_marker_csv(""));
}

TEST(MarkerCsv, ReadsPositionsTimesAndWhatIsLost) {
  const auto read = parse_marker_csv(kTwo, "two.csv");
  ASSERT_TRUE(read) << read.error().message();
  const MarkerTrack& track = read->track;
  EXPECT_EQ(track.markers, (std::vector<std::string>{"tip", "chin_L"}));
  EXPECT_EQ(track.time_s, (std::vector<double>{0, 0.01, 0.02}));
  EXPECT_TRUE(track.frame(0)[0].isApprox(Vec3f(0.001F, 0.002F, 0.003F)));
  EXPECT_FALSE(is_seen(track.frame(1)[0]));
  EXPECT_TRUE(track.frame(1)[1].isApprox(Vec3f(-0.004F, 0.0055F, 0.00625F)));
  EXPECT_FALSE(is_seen(track.frame(2)[1]));
  EXPECT_TRUE(read->warnings.empty());
}

TEST(MarkerCsv, MetresAreMetres) {
  const auto read = parse_marker_csv("time_s,a_x_m,a_y_m,a_z_m\n5,1,nan,nan\n", "m");
  EXPECT_EQ(read.error().code, ErrorCode::malformed);
  const auto whole = parse_marker_csv("time_s,a_x_m,a_y_m,a_z_m\n5,1,+2,-3e-1\n6,NaN,nan,\n", "m");
  ASSERT_TRUE(whole) << whole.error().message();
  EXPECT_TRUE(whole->track.frame(0)[0].isApprox(Vec3f(1, 2, -0.3F)));
  EXPECT_FALSE(is_seen(whole->track.frame(1)[0]));
}

TEST(MarkerCsv, WhatWasWrittenComesBack) {
  const auto read = parse_marker_csv(kTwo, "two");
  ASSERT_TRUE(read);
  const std::string text = format_marker_csv(read->track);
  const auto again = parse_marker_csv(text, "again");
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(format_marker_csv(again->track), text);
  EXPECT_EQ(again->track.time_s, read->track.time_s);
}

TEST(MarkerCsv, ALastRowThatWasCutIsLeftOut) {
  const auto read = parse_marker_csv(kTwo + "0.03,1,2", "two");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->track.frames(), 3u);
  EXPECT_EQ(read->warnings.size(), 1u);
}

struct Wrong {
  const char* text;
  ErrorCode code;
};
class WrongMarkerCsv : public testing::TestWithParam<Wrong> {};

TEST_P(WrongMarkerCsv, IsRefused) {
  const auto read = parse_marker_csv(GetParam().text, "wrong");
  ASSERT_FALSE(read) << GetParam().text;
  EXPECT_EQ(read.error().code, GetParam().code) << read.error().message();
}

INSTANTIATE_TEST_SUITE_P(
    All, WrongMarkerCsv,
    testing::Values(
        Wrong{"", ErrorCode::malformed}, Wrong{"time,a_x_mm,a_y_mm,a_z_mm\n0,1,2,3\n", ErrorCode::malformed},
        Wrong{"time_s\n0\n", ErrorCode::malformed},                             // No marker.
        Wrong{"time_s,a_x_mm,a_y_mm\n0,1,2\n", ErrorCode::malformed},           // Two axes.
        Wrong{"time_s,a_x_mm,a_z_mm,a_y_mm\n0,1,2,3\n", ErrorCode::malformed},  // Their order.
        Wrong{"time_s,a_x_mm,b_y_mm,a_z_mm\n0,1,2,3\n", ErrorCode::malformed},  // Two markers.
        Wrong{"time_s,a_x_mm,a_y_mm,a_z_m\n0,1,2,3\n", ErrorCode::malformed},   // Two units.
        Wrong{"time_s,a_x_in,a_y_in,a_z_in\n0,1,2,3\n", ErrorCode::malformed},  // No unit of ours.
        Wrong{"time_s,a_x_mm,a_y_mm,a_z_mm,a_x_mm,a_y_mm,a_z_mm\n0,1,2,3\n", ErrorCode::malformed},
        Wrong{"time_s,a_x_mm,a_y_mm,a_z_mm\n", ErrorCode::truncated},             // No frame.
        Wrong{"time_s,a_x_mm,a_y_mm,a_z_mm\n0,1,2,3,4\n", ErrorCode::malformed},  // Too many cells.
        Wrong{"time_s,a_x_mm,a_y_mm,a_z_mm\n0,1,2\n", ErrorCode::malformed},      // Half a position.
        Wrong{"time_s,a_x_mm,a_y_mm,a_z_mm\n0,1,x,3\n", ErrorCode::malformed},
        Wrong{"time_s,a_x_mm,a_y_mm,a_z_mm\n,1,2,3\n", ErrorCode::malformed},  // No time.
        Wrong{"time_s,a_x_mm,a_y_mm,a_z_mm\n0,1,2,3\n0,1,2,3\n", ErrorCode::malformed},
        Wrong{"time_s,a_x_mm,a_y_mm,a_z_mm\n0,1,2,inf\n", ErrorCode::out_of_range},
        Wrong{"time_s,a_x_mm,a_y_mm,a_z_mm\n0,1,2,1e6\n", ErrorCode::out_of_range},  // A kilometre.
        Wrong{"time_s,a_x_mm,a_y_mm,a_z_mm\n1e12,1,2,3\n", ErrorCode::out_of_range}));

// As Motive writes it: measured markers beside a rigid body and its solved markers.
const std::string kMotive =
    "Format Version,1.23,Take Name,\"Take 1, late\",Capture Frame Rate,120.000000,Length "
    "Units,Meters,Coordinate "
    "Space,Global\r\n"
    "\r\n"
    ",Type,Rigid Body,Rigid Body,Rigid Body Marker,Rigid Body Marker,Rigid Body "
    "Marker,Marker,Marker,Marker,Marker,"
    "Marker,Marker\r\n"
    ",Name,Hat,Hat,Hat:1,Hat:1,Hat:1,\"Face:tip\",\"Face:tip\",\"Face:tip\",Unlabeled 7,Unlabeled "
    "7,Unlabeled 7\r\n"
    ",ID,1,1,2,2,2,3,3,3,4,4,4\r\n"
    ",,Rotation,Position,Position,Position,Position,Position,Position,Position,Position,Position,Position\r\n"
    "Frame,Time (Seconds),X,X,X,Y,Z,X,Y,Z,X,Y,Z\r\n"
    "0,0.000000,0.1,0.2,9,9,9,0.5,1.25,-0.5,1,1,1\r\n"
    "1,0.008333,0.1,0.2,9,9,9,,,,1,1,1\r\n";

TEST(MotiveCsv, MeasuredMarkersAreTaken) {
  ASSERT_TRUE(is_motive_csv(kMotive));
  const auto read = parse_motive_csv(kMotive, "motive");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->track.markers, (std::vector<std::string>{"Face:tip", "Unlabeled 7"}));
  ASSERT_EQ(read->track.frames(), 2u);
  EXPECT_EQ(read->track.time_s[1], 0.008333);
  EXPECT_EQ(read->track.frame(0)[0], Vec3f(0.5F, 1.25F, -0.5F));
  EXPECT_FALSE(is_seen(read->track.frame(1)[0]));
}

TEST(MotiveCsv, WhatIsMissingIsSaid) {
  const auto without = [](const std::string& what, const std::string& with) {
    std::string text = kMotive;
    text.replace(text.find(what), what.size(), with);
    return parse_motive_csv(text, "motive");
  };
  EXPECT_EQ(without("Format Version", "Version").error().code, ErrorCode::malformed);
  EXPECT_EQ(without("Length Units", "Units").error().code, ErrorCode::malformed);
  EXPECT_EQ(without("Meters", "Furlongs").error().code, ErrorCode::unsupported);
  EXPECT_EQ(without(",Name,", ",Label,").error().code, ErrorCode::malformed);
  EXPECT_EQ(without("Frame,Time", "Frame,Clock").error().code, ErrorCode::malformed);
  EXPECT_EQ(without("Rigid Body Marker,Marker,Marker,Marker,Marker,Marker,Marker",
                    "Rigid Body Marker,Bone,Bone,Bone,Bone,Bone,Bone")
                .error()
                .code,
            ErrorCode::malformed);
  EXPECT_EQ(parse_motive_csv("Format Version,1.2,Length Units,Meters\n", "cut").error().code,
            ErrorCode::malformed);
}

}  // namespace
}  // namespace mien::mocap::marker_csv_test
