#include "mien/headset/wearer_calibration.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace mien::headset::wearer_calibration_test {
namespace {

WearerCalibration calibration() {
  WearerCalibration made;
  made.neutral.cameras = {"eye_L", "eye_R"};
  made.neutral.gaze_rad = {0.1F, -0.05F, 0.02F, 0};
  made.neutral.rest.features.assign(model::kViews, 0.25F);
  made.neutral.network = "hash";
  made.neutral.scores = {{.name = "gaze left", .value = 1.5, .unit = "deg", .pass = true, .sentence = "so"}};
  return made;
}
WearerCalibration with_gaze() {
  WearerCalibration made = calibration();
  made.gaze.emplace();
  made.gaze->eyes[0] << 1.25F, 0.1F, -0.02F, -0.05F, 1.1F, 0.03F;
  return made;
}

TEST(WearerCalibration, GoesThroughJsonWithAndWithoutGaze) {
  for (const WearerCalibration& made : {calibration(), with_gaze()}) {
    const auto back = parse_wearer_calibration(write_wearer_calibration(made), "calibration");
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(*back, made);
  }
}

/// Calibrations that were made before targets were asked for.
TEST(WearerCalibration, TakesAPlainNeutral) {
  const auto back = parse_wearer_calibration(write_neutral_face(calibration().neutral), "calibration");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(*back, calibration());
  EXPECT_FALSE(back->gaze);
}

TEST(WearerCalibration, RefusesWhatNoCalibrationMakes) {
  EXPECT_EQ(parse_wearer_calibration("", "calibration").error().code, ErrorCode::malformed);
  EXPECT_EQ(parse_wearer_calibration("[]", "calibration").error().code, ErrorCode::malformed);
  const auto refused = [](const nlohmann::json& gaze, ErrorCode code) {
    nlohmann::json root = nlohmann::json::parse(write_wearer_calibration(calibration()));
    root["gaze"] = gaze;
    const auto back = parse_wearer_calibration(root.dump(), "calibration");
    ASSERT_FALSE(back) << gaze;
    EXPECT_EQ(back.error().code, code) << gaze;
  };
  refused(nullptr, ErrorCode::malformed);
  refused("map", ErrorCode::malformed);
  refused({{1, 0, 0, 0, 1, 0}}, ErrorCode::malformed);
  refused({{1, 0, 0, 0, 1, 0}, {1, 0, 0, 0, 1, nullptr}}, ErrorCode::malformed);
  refused({{1, 0, 0, 0, 1, 0}, {-1, 0, 0, 0, 1, 0}}, ErrorCode::out_of_range);
  refused({{1, 0, 2, 0, 1, 0}, {1, 0, 0, 0, 1, 0}}, ErrorCode::out_of_range);
  // However deep it goes.
  std::string deep = write_wearer_calibration(calibration());
  deep.back() = ',';
  deep += "\"gaze\": " + std::string(20'000, '[') + std::string(20'000, ']') + "}";
  EXPECT_EQ(parse_wearer_calibration(deep, "calibration").error().code, ErrorCode::malformed);
}

}  // namespace
}  // namespace mien::headset::wearer_calibration_test
