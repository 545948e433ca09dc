#include "mien/sensor/rig_part.h"

#include <gtest/gtest.h>

namespace mien::sensor::rig_part_test {
namespace {

Rig mixed() {
  Rig rig;
  rig.name = "mixed";
  rig.reference = "light";
  rig.sensors = {{.name = "chin", .kind = "imu", .role = "face"},
                 {.name = "light", .kind = "eyewear", .role = "face"},
                 {.name = "ear", .kind = "imu", .role = "head"},
                 {.name = "hook", .kind = "eyewear", .role = "face"}};
  return rig;
}

TEST(RigPart, KeepsNumbersAndTheReferenceAndTakesOthersRoles) {
  EXPECT_EQ(kinds_of(mixed()), (std::vector<std::string>{"imu", "eyewear"}));
  EXPECT_EQ(sensors_of(mixed(), "eyewear"), (std::vector<std::uint16_t>{1, 3}));
  EXPECT_TRUE(sensors_of(mixed(), "camera").empty());

  const Rig imus = part_of(mixed(), "imu");
  EXPECT_EQ(imus.sensors.size(), 4u);
  EXPECT_EQ(imus.face_sensors(), (std::vector<std::uint16_t>{0}));
  EXPECT_EQ(imus.face_sensor_names(), (std::vector<std::string>{"chin"}));
  EXPECT_EQ(imus.head_sensor(), 2);
  EXPECT_EQ(imus.find(imus.reference), 1);

  const Rig lights = part_of(mixed(), "eyewear");
  EXPECT_EQ(lights.face_sensors(), (std::vector<std::uint16_t>{1, 3}));
  EXPECT_EQ(lights.head_sensor(), std::nullopt);
}

}  // namespace
}  // namespace mien::sensor::rig_part_test
