#include "mien/eyewear/light_grid.h"

#include <algorithm>
#include <cmath>

namespace mien::eyewear {
namespace {

/// At or above this share of full scale a reading is at the end of the range, for converters of up to 16
/// bits.
constexpr float kFullScale = 1 - 1e-5F;

}  // namespace

std::vector<std::uint16_t> photo_sensors(const sensor::Rig& rig) {
  std::vector<std::uint16_t> numbers;
  for (std::uint16_t i = 0; i < rig.sensors.size(); ++i)
    if (rig.sensors[i].kind == "eyewear") numbers.push_back(i);
  return numbers;
}

std::vector<std::string> photo_sensor_names(const sensor::Rig& rig) {
  std::vector<std::string> names;
  for (const std::uint16_t number : photo_sensors(rig)) names.push_back(rig.sensors[number].name);
  return names;
}

void LightGrid::Track::reset() {
  filter_.reset();
  lights_.clear();
  saturated_ = false;
}

void LightGrid::Track::add(const sensor::Sample& sample) {
  if (!lights_.empty()) {
    const Duration since = sample.time - lights_[0].time;
    if (since < -AmbientFilter::kForget)
      reset();  // The board restarted.
    else if (since <= Duration::zero())
      return;
  }
  saturated_ = sample.values[0] >= kFullScale;
  if (sample.values[1] >= kFullScale) return;
  const double light = std::max(filter_.add(sample), kDimmest);
  lights_.push({sample.time, std::log(light)});
}

std::optional<double> LightGrid::Track::at(DeviceTime time) const {
  if (lights_.empty() || time - lights_[0].time > kSilence) return std::nullopt;
  if (time >= lights_[0].time) return lights_[0].log_light;
  for (std::size_t back = 1; back < lights_.size(); ++back) {
    const Light& before = lights_[back];
    if (before.time > time) continue;
    const Light& after = lights_[back - 1];
    if (after.time - before.time > kSilence) return std::nullopt;  // In the middle of a gap.
    const double share = to_seconds(time - before.time) / to_seconds(after.time - before.time);
    return before.log_light + share * (after.log_light - before.log_light);
  }
  // Before the buffer: the first samples have just come, or the frame is very late.
  const Light& oldest = lights_[lights_.size() - 1];
  return oldest.time - time > kSilence ? std::nullopt : std::optional(oldest.log_light);
}

LightGrid::LightGrid(const sensor::Rig& rig)
    : sensors_(photo_sensors(rig)), tracks_(sensors_.size()), track_of_(rig.sensors.size(), sensors_.size()) {
  for (std::size_t i = 0; i < sensors_.size(); ++i) track_of_[sensors_[i]] = i;
}

void LightGrid::add(const sensor::Sample& sample) {
  if (sample.sensor >= track_of_.size()) return;
  const std::size_t track = track_of_[sample.sensor];
  if (track < tracks_.size() && sample.kind == sensor::SampleKind::eyewear_light && sample.count >= 2)
    tracks_[track].add(sample);
}

void LightGrid::forget(std::uint16_t sensor) {
  if (sensor < track_of_.size() && track_of_[sensor] < tracks_.size()) tracks_[track_of_[sensor]].reset();
}

void LightGrid::tick(DeviceTime frame, const sensor::TimeLines& lines, GridLight& out) const {
  out.log_light.assign(tracks_.size(), 0.0);
  out.present.assign(tracks_.size(), 0);
  out.saturated.assign(tracks_.size(), 0);
  if (!lines.ready()) return;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (!lines.has_samples(sensors_[i])) continue;
    out.saturated[i] = tracks_[i].saturated() ? 1 : 0;
    const auto light = tracks_[i].at(lines.from_line(sensors_[i], frame));
    if (!light) continue;
    out.log_light[i] = *light;
    out.present[i] = 1;
  }
}

}  // namespace mien::eyewear
