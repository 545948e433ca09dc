#include "mien/virtual/eyewear/eyewear_faults.h"

#include <gtest/gtest.h>

#include "mien/sensor/rig.h"
#include "tests/project_path.h"

namespace mien::virt::eyewear_faults_test {
namespace {

TEST(EyewearFaults, TheRigsAreRead) {
  const auto rig = sensor::read_rig(project_path("rigs/eyewear.toml"));
  ASSERT_TRUE(rig) << rig.error().message();
  const auto faults = parse_eyewear_faults(rig->faults_toml, rig->name);
  ASSERT_TRUE(faults) << faults.error().message();
  EXPECT_EQ(faults->focal_peak_mm, 3);
  EXPECT_EQ(faults->mount_shift_mm, 3);
  EXPECT_EQ(faults->mount_tilt_deg, 5);
  EXPECT_EQ(faults->adc_bits, 10);
  EXPECT_LT(faults->ambient[0], faults->ambient[1]);
}

TEST(EyewearFaults, NoneIsAPerfectDevice) {
  const auto faults = parse_eyewear_faults("", "none");
  ASSERT_TRUE(faults);
  EXPECT_EQ(*faults, EyewearFaults{});
}

class WrongFaults : public testing::TestWithParam<const char*> {};

TEST_P(WrongFaults, AreRefused) {
  const auto faults = parse_eyewear_faults(GetParam(), "wrong.toml");
  ASSERT_FALSE(faults) << GetParam();
  EXPECT_EQ(faults.error().message().find('\n'), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(EyewearFaults, WrongFaults,
                         testing::Values("gyro_bias_dps = 1", "cone_deg = true", "cone_deg = nan",
                                         "cone_deg = -1", "cone_deg = 90", "adc_bits = 9.5", "adc_bits = 0",
                                         "adc_bits = 60", "pair_rate_hz = 0", "ambient = 0.1",
                                         "ambient = [0.2, 0.1]", "ambient = [0.1]", "fit_mm = [0, 4]",
                                         "skin_reflectance = [0, 1]", "focal_peak_mm = 0", "tissue_s = 0",
                                         "strobe_ms = 1e9", "pattern = 5", "["));

}  // namespace
}  // namespace mien::virt::eyewear_faults_test
