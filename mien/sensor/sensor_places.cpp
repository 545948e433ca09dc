#include "mien/sensor/sensor_places.h"

#include <algorithm>

namespace mien::sensor {

std::vector<std::ptrdiff_t> sensor_places(const std::vector<std::string>& model_sensors,
                                          const std::vector<std::string>& rig_sensors) {
  std::vector<std::ptrdiff_t> places;
  for (const std::string& name : model_sensors) {
    const auto found = std::ranges::find(rig_sensors, name);
    places.push_back(found == rig_sensors.end() ? -1 : found - rig_sensors.begin());
  }
  return places;
}

bool none_placed(const std::vector<std::ptrdiff_t>& places) {
  return std::ranges::all_of(places, [](std::ptrdiff_t place) { return place < 0; });
}

}  // namespace mien::sensor
