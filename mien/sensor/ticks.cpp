#include "mien/sensor/ticks.h"

#include <algorithm>

#include "mien/sensor/rig_part.h"

namespace mien::sensor {
namespace {

/// Packets farther apart than this are not a packet period but a gap.
constexpr Duration kMaxPacketPeriod = std::chrono::milliseconds(100);

/// The first frame of the grid at or after a time.
std::int64_t frame_at_or_after(DeviceTime time) {
  std::int64_t index = time.time_since_epoch().count() / 50'000'000 * 3;
  while (frame_offset(index) >= time.time_since_epoch()) --index;
  while (frame_offset(index) < time.time_since_epoch()) ++index;
  return index;
}

}  // namespace

TickRule::TickRule(const Rig& rig)
    : lines_(rig.sensors.size(), rig.find(rig.reference)),
      hold_(rig.sensors.size()),
      reference_(rig.find(rig.reference)),
      received_(rig.sensors.size()) {
  for (const std::uint16_t truth : truths_of(rig)) received_[truth].waited_for = false;
}

void TickRule::begin() {
  // From the earliest of what is there already, so that a line decided late does not skip what came before.
  std::optional<DeviceTime> first;
  for (std::uint16_t i = 0; i < received_.size(); ++i) {
    if (!received_[i].ever || !lines_.has_samples(i)) continue;
    const DeviceTime time = lines_.to_line(i, received_[i].newest);
    if (!first || time < *first) first = time;
  }
  if (first) next_ = frame_at_or_after(*first);
}

void TickRule::add(HostTime arrival, const Sample& sample) {
  if (sample.sensor >= received_.size()) return;
  if (!received_[sample.sensor].waited_for) {
    lines_.follow(arrival, sample);
    return;
  }
  lines_.add(arrival, sample);
  newest_arrival_ = std::max(newest_arrival_, arrival);
  Received& received = received_[sample.sensor];
  // A board that began anew counts from its new time on.
  const bool anew = received.ever && received.newest - sample.time > std::chrono::seconds(1);
  if (anew) received.packets = {};
  if (!received.ever || sample.time > received.newest || anew) received.newest = sample.time;
  received.arrival = arrival;
  received.ever = true;
  watch_arrival(arrival, sample);
  if (reference_ == sample.sensor && !is_on_frame_time(sample.kind)) follow_reference(sample);
  if (!next_ && lines_.ready()) begin();
}

void TickRule::watch_arrival(HostTime arrival, const Sample& sample) {
  // An estimated time has its arrival's delay in it, and frames' own times have none.
  if (sample.time_estimated || is_on_frame_time(sample.kind)) return;
  if (received_[sample.sensor].packets.add(sample.sequence, sample.time))
    hold_.add(sample.sensor, sample.sequence, arrival,
              arrival - lines_.clock(sample.sensor).to_host(sample.time));
}

void TickRule::follow_reference(const Sample& sample) {
  if (packet_ && *packet_ != sample.sequence) {
    if (*packet_ + 1 == sample.sequence) {
      if (previous_end_) {
        const Duration period = packet_end_ - *previous_end_;
        if (period > Duration::zero() && period <= kMaxPacketPeriod) packet_period_ = period;
      }
      previous_end_ = packet_end_;
    } else {
      previous_end_.reset();
    }
  }
  packet_ = sample.sequence;
  packet_end_ = sample.time;
}

bool TickRule::all_have(DeviceTime frame, HostTime now) const {
  bool any = false;
  for (std::uint16_t i = 0; i < received_.size(); ++i) {
    const Received& received = received_[i];
    if (!received.ever || now - received.arrival > kFresh) continue;
    any = true;
    const bool by_packets = hold_.now() > Duration::zero() && !received.packets.empty();
    const DeviceTime until = by_packets ? received.packets.whole_until() : received.newest;
    if (lines_.to_line(i, until) < frame) return false;
  }
  return any;
}

std::optional<HostTime> TickRule::deadline() const {
  if (!next_) return std::nullopt;
  const DeviceTime frame{frame_offset(*next_)};
  DeviceTime carried_by = frame;
  if (packet_period_ > Duration::zero() && !lines_.on_host_time()) {
    const DeviceTime end = lines_.to_line(*reference_, packet_end_);
    if (frame > end)
      carried_by = end + ((frame - end).count() + packet_period_.count() - 1) / packet_period_.count() *
                             packet_period_;
  }
  return lines_.to_host(carried_by) + kWait + hold_.now();
}

void TickRule::forget(std::uint16_t sensor) {
  lines_.forget(sensor);
  if (sensor >= received_.size()) return;
  received_[sensor] = {.waited_for = received_[sensor].waited_for};
  hold_.forget(sensor);
}

void TickRule::refill(HostTime fired) {
  if (refilled_ && fired > *refilled_) {
    const Duration passed = std::min(fired - *refilled_, kMostAhead);
    credit_ = std::min(kMostAhead, credit_ + passed + from_seconds(kFaster * to_seconds(passed)));
  }
  if (!refilled_ || fired > *refilled_) refilled_ = fired;
}

std::optional<FrameTick> TickRule::due(HostTime now) {
  if (!next_) return std::nullopt;
  const DeviceTime frame{frame_offset(*next_)};
  const HostTime limit = *deadline();
  const bool complete = all_have(frame, now);
  if (!complete && now < limit) return std::nullopt;
  // An arrival may move the deadline before itself; the frame then fires with it, not before.
  const HostTime fired = std::max(std::min(now, limit), newest_arrival_);
  refill(fired);
  const Duration step(frame_offset(*next_ + 1) - frame_offset(*next_));
  if (credit_ < step) {
    // Left out up to what a sample that arrives now is of.
    next_ = std::max(*next_ + 1, frame_at_or_after(lines_.from_host(now)));
    return std::nullopt;
  }
  credit_ -= step;
  // What this frame did not wait for, the next ones do not either.
  for (std::uint16_t i = 0; i < received_.size(); ++i)
    if (!received_[i].packets.empty()) received_[i].packets.give_up(lines_.from_line(i, frame));
  const FrameTick tick{*next_, frame, fired, complete};
  ++*next_;
  return tick;
}

}  // namespace mien::sensor
