#include "mien/gaze/gaze_tracker.h"

#include <algorithm>
#include <utility>

#include "mien/sensor/rig_part.h"

namespace mien::gaze {
namespace {

using face::Provenance;

/// Where a sensor's time runs back farther than this the sender restarted.
constexpr Duration kRestart = std::chrono::milliseconds(200);
constexpr std::array<std::size_t, 2> kBlinks = {face::shape("eyeBlink_L"), face::shape("eyeBlink_R")};

}  // namespace

Result<std::unique_ptr<GazeTracker>> GazeTracker::create(const sensor::Rig& rig) {
  std::vector<Channel> channels;
  for (const std::uint16_t number : sensor::sensors_of(rig, "gaze")) channels.emplace_back().sensor = number;
  if (channels.empty())
    return fail(ErrorCode::mismatch, "no sensor of this rig is of the kind gaze", "rig " + rig.name);
  return std::unique_ptr<GazeTracker>(new GazeTracker(std::move(channels)));
}

const GazeTracker::Seen* GazeTracker::Channel::at(DeviceTime time) const {
  for (std::size_t back = 0; back < samples.size(); ++back)
    if (const Seen& seen = samples[back]; seen.time <= time)
      return time - seen.time <= kPresent ? &seen : nullptr;
  return nullptr;
}

void GazeTracker::add(HostTime, const sensor::Sample& sample) {
  const auto channel = std::ranges::find(channels_, sample.sensor, &Channel::sensor);
  if (channel == channels_.end()) return;
  const auto eyes = eyes_of(sample);
  if (!eyes) return;
  if (!channel->samples.empty()) {
    const Duration since = sample.time - channel->samples[0].time;
    if (since < -kRestart)
      channel->samples.clear();
    else if (since <= Duration::zero())
      return;  // Doubled, or out of order.
  }
  channel->samples.push({sample.time, *eyes});
}

void GazeTracker::forget(std::uint16_t sensor) {
  const auto channel = std::ranges::find(channels_, sensor, &Channel::sensor);
  if (channel == channels_.end()) return;
  channel->samples.clear();
  last_rad_.reset();
}

tracker::TickResult GazeTracker::tick(DeviceTime frame, const sensor::TimeLines& lines,
                                      face::OutputFrame& out) {
  tracker::TickResult result;
  out = face::neutral_frame(frame);
  Eyes eyes;
  if (lines.ready())
    for (const Channel& channel : channels_) {
      if (!lines.has_samples(channel.sensor)) continue;
      const Seen* const seen = channel.at(lines.from_line(channel.sensor, frame));
      if (seen == nullptr) continue;
      ++result.sensors_present;
      for (std::size_t e = 0; e < eyes.size(); ++e) {
        const Eye& eye = seen->eyes[e];
        const auto openness = eye.openness ? eye.openness : eyes[e].openness;
        if (eye.confidence > eyes[e].confidence) eyes[e] = eye;
        eyes[e].openness = openness;
      }
    }
  if (result.sensors_present > 0) answer(eyes, out);
  return result;
}

void GazeTracker::answer(const Eyes& eyes, face::OutputFrame& out) {
  for (std::size_t e = 0; e < eyes.size(); ++e) {
    if (!eyes[e].openness) continue;
    out.weights[kBlinks[e]] = 1 - *eyes[e].openness;
    out.confidence[kBlinks[e]] = 1;
    out.provenance[kBlinks[e]] = Provenance::measured;
  }
  const bool seen = eyes[0].confidence > 0 || eyes[1].confidence > 0;
  if (seen) {
    last_rad_.emplace();
    for (std::size_t e = 0; e < eyes.size(); ++e) {
      const Eye& eye = eyes[e].confidence > 0 ? eyes[e] : eyes[1 - e];
      (*last_rad_)[e] = {eye.yaw_rad, eye.pitch_rad};
    }
    out.eyes_confidence = (eyes[0].confidence + eyes[1].confidence) / 2;
  }
  if (!last_rad_) return;
  out.eyes_rad = *last_rad_;
  out.eyes_provenance = seen ? Provenance::measured : Provenance::held;
}

}  // namespace mien::gaze
