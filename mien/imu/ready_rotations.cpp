#include "mien/imu/ready_rotations.h"

#include <algorithm>
#include <cmath>

#include "mien/core/rotation.h"

namespace mien::imu {

ReadyRotations::ReadyRotations(std::span<const std::uint16_t> face, Duration silence) : silence_(silence) {
  for (const std::uint16_t number : face) sensors_.emplace_back().number = number;
}

void ReadyRotations::add(const sensor::Sample& sample) {
  if (sample.kind != sensor::SampleKind::imu_head_relative || sample.count < 3) return;
  if (!std::ranges::all_of(sample.used(), [](float value) { return std::isfinite(value); })) return;
  const auto sensor = std::ranges::find(sensors_, sample.sensor, &Sensor::number);
  if (sensor == sensors_.end()) return;
  sensor->entries[sensor->added++ % sensor->entries.size()] = {
      sample.time, Vec3(sample.values[0], sample.values[1], sample.values[2])};
}

void ReadyRotations::forget(std::uint16_t sensor) {
  for (Sensor& known : sensors_)
    if (known.number == sensor) known.added = 0;
}

void ReadyRotations::put(DeviceTime frame, model::FeatureFrame& out) const {
  const auto distance = [frame](const Entry& entry) {
    return entry.time > frame ? entry.time - frame : frame - entry.time;
  };
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    const std::span entries =
        std::span(sensors_[i].entries)
            .first(std::min<std::size_t>(sensors_[i].added, sensors_[i].entries.size()));
    const auto nearest = std::ranges::min_element(entries, {}, distance);
    if (nearest == entries.end() || distance(*nearest) > silence_) continue;
    out.sensors[i] = {};
    out.sensors[i].rotation = wxyz_of(canonical(exp_rotation(nearest->rotation_vector)));
    out.sensors[i].has_rotation = true;
  }
}

}  // namespace mien::imu
