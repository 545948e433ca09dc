#include "mien/sensor/rig_part.h"

#include <algorithm>

namespace mien::sensor {

std::vector<std::string> kinds_of(const Rig& rig) {
  std::vector<std::string> kinds;
  for (const Mount& mount : rig.sensors)
    if (!mount.is_truth() && std::ranges::find(kinds, mount.kind) == kinds.end()) kinds.push_back(mount.kind);
  return kinds;
}

std::vector<std::uint16_t> sensors_of(const Rig& rig, std::string_view kind) {
  std::vector<std::uint16_t> sensors;
  for (std::size_t i = 0; i < rig.sensors.size(); ++i)
    if (rig.sensors[i].kind == kind && !rig.sensors[i].is_truth())
      sensors.push_back(static_cast<std::uint16_t>(i));
  return sensors;
}

std::vector<std::uint16_t> truths_of(const Rig& rig) {
  std::vector<std::uint16_t> sensors;
  for (std::size_t i = 0; i < rig.sensors.size(); ++i)
    if (rig.sensors[i].is_truth()) sensors.push_back(static_cast<std::uint16_t>(i));
  return sensors;
}

Rig part_of(const Rig& rig, std::string_view kind) {
  Rig part = rig;
  for (Mount& mount : part.sensors)
    if (mount.kind != kind) mount.role.clear();
  return part;
}

}  // namespace mien::sensor
