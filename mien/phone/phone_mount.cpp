#include "mien/phone/phone_mount.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "mien/sensor/bindings.h"

namespace mien::phone {

Result<std::vector<sensor::DeviceKey>> without_sensor(const sensor::Rig& rig,
                                                      std::span<const sensor::DeviceKey> devices) {
  MIEN_TRY_ASSIGN(const auto bound, sensor::bindings(rig));
  std::vector<sensor::DeviceKey> without;
  for (const sensor::DeviceKey& device : devices)
    if (std::ranges::find(bound, device, &std::pair<sensor::DeviceKey, std::uint16_t>::first) == bound.end())
      without.push_back(device);
  return without;
}

Result<sensor::Rig> with_phones(sensor::Rig rig, std::span<const sensor::DeviceKey> devices, PhoneUse use) {
  MIEN_TRY_ASSIGN(rig, sensor::with_bindings(std::move(rig)));
  for (const sensor::DeviceKey& device : devices) {
    sensor::Mount phone{.name = "phone",
                        .kind = "weights",
                        .role = use == PhoneUse::truth ? "truth" : "face",
                        .device = sensor::format_device(device)};
    while (rig.find(phone.name)) phone.name += "_";
    rig.sensors.push_back(std::move(phone));
  }
  return sensor::parse_rig(sensor::write_rig(rig), "rig " + rig.name);
}

}  // namespace mien::phone
