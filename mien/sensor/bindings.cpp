#include "mien/sensor/bindings.h"

#include <fmt/format.h>

namespace mien::sensor {

Result<std::vector<std::pair<DeviceKey, std::uint16_t>>> bindings(const Rig& rig) {
  std::vector<std::pair<DeviceKey, std::uint16_t>> bound;
  for (std::uint16_t i = 0; i < rig.sensors.size(); ++i) {
    const Mount& mount = rig.sensors[i];
    if (mount.device.empty()) continue;
    MIEN_TRY_ASSIGN(const DeviceKey key, parse_device(mount.device));
    for (const auto& [other, sensor] : bound)
      if (other == key)
        return fail(ErrorCode::bad_usage,
                    fmt::format("{} and {} are bound to one device, {}", rig.sensors[sensor].name, mount.name,
                                mount.device),
                    "rig " + rig.name, "give each sensor a device of its own");
    bound.emplace_back(key, i);
  }
  if (bound.empty())
    for (std::uint16_t i = 0; i < rig.sensors.size(); ++i)
      bound.emplace_back(DeviceKey{virtual_device(i), 0}, i);
  return bound;
}

Result<Rig> with_bindings(Rig rig) {
  MIEN_TRY_ASSIGN(const auto bound, bindings(rig));
  for (const auto& [key, number] : bound) rig.sensors[number].device = format_device(key);
  return rig;
}

}  // namespace mien::sensor
