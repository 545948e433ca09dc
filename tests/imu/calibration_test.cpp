#include "mien/imu/calibration.h"

#include <gtest/gtest.h>

#include <string>

namespace mien::imu::calibration_test {
namespace {

Calibration example() {
  Calibration c;
  c.complete = true;
  c.q_head_ear = canonical(exp_rotation(Vec3(0.1, -2, 0.3)));
  c.neutral_heading_rad = -1.25;
  SensorCalibration s;
  s.valid = true;
  s.neutral = canonical(exp_rotation(Vec3(1, 0.2, 0.3)));
  s.heading_rad = 0.7;
  s.heading_sigma_rad = 0.01;
  s.neutral_accel_m_s2 = Vec3(0.01, -0.02, 0.03);
  c.sensors = {s, SensorCalibration{}};
  c.wearer = {0.25F, static_cast<float>(-0.123457), 0};
  c.scores = {{"nod", 18.5, "deg", true, "the nod was \"large\" enough"}};
  return c;
}

std::string with(const std::string& from, const std::string& to) {
  std::string text = write_calibration(example());
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Calibration, ComesBackAsItWent) {
  const auto back = parse_calibration(write_calibration(example()), "test");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(*back, example());
  EXPECT_EQ(*parse_calibration(write_calibration(Calibration{}), "test"), Calibration{});
}

TEST(Calibration, RefusesWhatIsNone) {
  for (const std::string& text :
       {std::string(), std::string("[]"), std::string("{}"), std::string("{\"complete\":"), with("true", "1"),
        with("-1.25", "1e999"), with("-1.25", "\"x\""),
        with("\"heading_sigma_rad\":0.01", "\"heading_sigma_rad\":-1"),
        with("\"neutral\":[1.0,0.0,0.0,0.0]", "\"neutral\":[2.0,0.0,0.0,0.0]"),
        with("\"neutral\":[1.0,0.0,0.0,0.0]", "\"neutral\":[1.0,0.0,0.0]"),
        with("\"scores\":[", "\"scores\":[7,"), with("\"wearer\":[", "\"wearer\":7,\"other\":["),
        with("\"wearer\":[0.25", "\"wearer\":[100.5"), with("\"wearer\":[0.25", "\"wearer\":[null")}) {
    const auto parsed = parse_calibration(text, "bad.json");
    ASSERT_FALSE(parsed) << text;
    EXPECT_EQ(parsed.error().where, "bad.json");
  }
}

TEST(Calibration, AnEmptyListOfScoresPassesNothing) {
  EXPECT_FALSE(sensor::all_pass({}));
  EXPECT_TRUE(sensor::all_pass(example().scores));
  auto scores = example().scores;
  scores[0].pass = false;
  EXPECT_FALSE(sensor::all_pass(scores));
}

}  // namespace
}  // namespace mien::imu::calibration_test
