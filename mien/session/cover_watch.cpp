#include "mien/session/cover_watch.h"

#include <algorithm>
#include <utility>

namespace mien::session {
namespace {

/// Of contrast beside brightness so much is left. A virtual headset's four cameras have 2.2 to 3.1, which
/// stays within 3 % over a neutral and a talking face; 1.33 while the lens is covered, whatever the exposure.
constexpr float kLeft = 0.7F;
/// Where nothing brightens a covered lens its noise may be a large share of its level. Levels of a face are
/// 0.3 to 0.9 apart; this is flat, if it is so much flatter than usual.
constexpr float kFlat = 0.12F;
constexpr float kFlatter = 0.4F;
/// What is usual follows so much of each picture: most of a second at 60 Hz, longer than a finger's way.
constexpr float kFollows = 0.02F;
/// A level below is black.
constexpr float kBlack = 1.0F / 255;

}  // namespace

void CoverWatch::arm(std::string sensor) {
  sensor_ = std::move(sensor);
  devices_.fill({});
  first_.reset();
  trouble_ = {};
}

CoverWatch::Device* CoverWatch::find(const sensor::DeviceKey& key) {
  const auto place = std::ranges::find_if(devices_, [&](const Device& d) { return !d.used || d.key == key; });
  return place == devices_.end() ? nullptr : &*place;
}

bool CoverWatch::is_covered(const Device& device, HostTime now, Duration held) {
  return device.covered && now - *device.covered >= held && now - device.received <= kBeside;
}

void CoverWatch::look(Device& device, HostTime arrival, const sensor::PictureLight& light) {
  const float relative = light.contrast / std::max(light.mean, kBlack);
  if (!device.used) {
    device.contrast = light.contrast;
    device.relative = relative;
  }
  device.used = true;
  // What was between two pictures so far apart nobody knows.
  if (device.covered && arrival - device.received > kBeside) device.covered.reset();
  device.received = arrival;
  if (relative < kLeft * device.relative || light.contrast < std::min(kFlat, kFlatter * device.contrast)) {
    if (!device.covered) device.covered = arrival;
    return;
  }
  device.covered.reset();
  device.contrast += kFollows * (light.contrast - device.contrast);
  device.relative += kFollows * (relative - device.relative);
}

void CoverWatch::give_up(std::string_view why) {
  arm({});
  trouble_ = why;
}

std::optional<CoverWatch::Covered> CoverWatch::add(HostTime arrival, const sensor::Reading& reading) {
  if (sensor_.empty()) return std::nullopt;
  if (first_ && arrival - *first_ > kPatience) {
    give_up("no lens was covered in 20 seconds; ask again, and hold a finger on it for a second");
    return std::nullopt;
  }
  const auto light = sensor::picture_light(reading.sample);
  Device* const device = light ? find(reading.from) : nullptr;
  if (device == nullptr) return std::nullopt;
  if (!first_) first_ = arrival;
  device->key = reading.from;
  look(*device, arrival, *light);
  if (!is_covered(*device, arrival, kHeld)) return std::nullopt;
  const auto covered =
      std::ranges::count_if(devices_, [&](const Device& d) { return is_covered(d, arrival, kBeside); });
  if (covered > 1) {
    give_up("two lenses are covered at once; ask again, and cover one alone");
    return std::nullopt;
  }
  Covered found{.sensor = sensor_, .device = device->key};
  arm({});
  return found;
}

}  // namespace mien::session
