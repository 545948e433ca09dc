#include "mien/phone/phone_mount.h"

#include <gmock/gmock.h>

#include <array>

#include "mien/phone/live_link.h"
#include "mien/sensor/bindings.h"

namespace mien::phone::test::phone_mount_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::array kPhones = {sensor::DeviceKey{kLiveLinkDevice, 0},
                                sensor::DeviceKey{kLiveLinkDevice + 1, 0}};

sensor::Rig rig(const std::string& more = {}) {
  return sensor::parse_rig(
             "name = \"one\"\nreference = \"phone\"\n[[sensor]]\nname = \"phone\"\nkind = \"imu\"\n"
             "site = \"mastoid\"\nside = \"L\"\nrole = \"head\"\n" +
                 more,
             "rig")
      .value();
}

TEST(PhoneMount, IsASensorOfItsDeviceBesideTheOthers) {
  EXPECT_THAT(without_sensor(rig(), kPhones).value(), ElementsAre(kPhones[0], kPhones[1]));
  const sensor::Rig both = with_phones(rig(), kPhones, PhoneUse::truth).value();
  ASSERT_EQ(both.sensors.size(), 3U);
  EXPECT_EQ(both.sensors[0].device, sensor::format_device({sensor::virtual_device(0), 0}))
      << "as it was bound";
  EXPECT_EQ(both.sensors[1].name, "phone_");
  EXPECT_EQ(both.sensors[2].name, "phone__");
  for (std::size_t p = 0; p < 2; ++p) {
    const sensor::Mount& phone = both.sensors[1 + p];
    EXPECT_EQ(phone.kind, "weights");
    EXPECT_TRUE(phone.is_truth());
    EXPECT_EQ(phone.device, sensor::format_device(kPhones[p]));
  }
  EXPECT_THAT(without_sensor(both, kPhones).value(), IsEmpty());
  EXPECT_EQ(sensor::write_rig(sensor::parse_rig(sensor::write_rig(both), "again").value()),
            sensor::write_rig(both));
}

TEST(PhoneMount, ASourceIsASensorOfTheFace) {
  const sensor::Rig one = with_phones(rig(), std::span(kPhones).first(1), PhoneUse::source).value();
  EXPECT_EQ(one.sensors[1].role, "face");
  EXPECT_THAT(without_sensor(one, kPhones).value(), ElementsAre(kPhones[1]));
}

TEST(PhoneMount, SaysWhatIsWrongWithBindings) {
  const auto refused = without_sensor(rig("device = \"a phone\"\n"), kPhones);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::malformed);
}

}  // namespace
}  // namespace mien::phone::test::phone_mount_test
