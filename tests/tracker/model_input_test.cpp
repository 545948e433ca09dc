#include "mien/tracker/model_input.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/tracker/tiny_model.h"
#include "tests/tracker/turning_sensors.h"

namespace mien::tracker::model_input_test {
namespace {

const std::vector<std::string> kSensors = {"mentalis", "buccinator_L"};

std::vector<float> encoded(const model::FeatureFrame& frame, const std::vector<std::string>& rig) {
  const model::ModelFile file = test::tiny_model(kSensors);
  ModelInput input(file, rig);
  std::vector<float> out(file.features.width());
  input.encode(frame, out);
  return out;
}

TEST(ModelInput, FindsSensorsByNameNotByPlace) {
  const auto frame = test::turning(5)[4];
  model::FeatureFrame other = frame;
  other.sensors = {frame.sensors[1], {}, frame.sensors[0]};
  EXPECT_EQ(encoded(frame, kSensors), encoded(other, {"buccinator_L", "frontalis_R", "mentalis"}));
}

TEST(ModelInput, WhatTheRigLacksIsMissing) {
  const model::ModelFile file = test::tiny_model(kSensors);
  auto frame = test::turning(5)[4];
  auto lacking = frame;
  frame.sensors[1] = {};
  lacking.sensors.resize(1);
  EXPECT_EQ(encoded(frame, kSensors), encoded(lacking, {"mentalis"}));
  EXPECT_FALSE(ModelInput(file, {"mentalis"}).empty());
  EXPECT_TRUE(ModelInput(file, {"frontalis_R"}).empty());
}

TEST(ModelInput, WhatIsNotFiniteIsMissing) {
  const model::ModelFile file = test::tiny_model(kSensors);
  auto frame = test::turning(5)[4];
  auto broken = frame;
  frame.sensors[1] = {};
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    broken.sensors[1].rotation[2] = bad;
    EXPECT_EQ(encoded(frame, kSensors), encoded(broken, kSensors));
  }
  broken.sensors[1].rotation[2] = 0;
  broken.sensors[1].accel_m_s2.x() = std::numeric_limits<float>::quiet_NaN();
  ModelInput input(file, kSensors);
  std::vector<float> out(file.features.width());
  input.encode(broken, out);
  EXPECT_TRUE(input.present(0));
  EXPECT_FALSE(input.present(1));
  EXPECT_EQ(input.present_count(), 1U);
  EXPECT_EQ(input.sensor_count(), 2U);
}

TEST(SolveRidge, IsThatOfTheProfile) {
  const model::ModelFile file = test::tiny_model(kSensors);
  const auto features = test::turning(10);
  const auto lab = solve_ridge(file, features, kSensors, "lab");
  const auto device = solve_ridge(file, features, kSensors, "device");
  ASSERT_EQ(lab.size(), 10U);
  ASSERT_EQ(device.size(), 10U);
  for (std::size_t f = 0; f < 10; ++f) {
    // tiny_model(): half of the first sensor's x, which is normalised by 0.5, and the profile's constant.
    const float x = features[f].sensors[0].rotation[1];
    EXPECT_NEAR(lab[f][7], std::max(0.0F, 0.25F + x), 1e-6);
    EXPECT_NEAR(device[f][7], 0.5F + x, 1e-6);
  }
  EXPECT_TRUE(solve_ridge(file, features, kSensors, "cinema").empty());
}

}  // namespace
}  // namespace mien::tracker::model_input_test
