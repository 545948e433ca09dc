#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace mien::sensor {

/// For each of a model's sensors, by name, its place among the rig's; -1 where the rig lacks it.
[[nodiscard]] std::vector<std::ptrdiff_t> sensor_places(const std::vector<std::string>& model_sensors,
                                                        const std::vector<std::string>& rig_sensors);

/// Whether there is none of them: rig and model have no sensor in common.
[[nodiscard]] bool none_placed(const std::vector<std::ptrdiff_t>& places);

}  // namespace mien::sensor
