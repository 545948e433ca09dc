#include "mien/virtual/imu/streamed_session.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "mien/core/time.h"
#include "mien/virtual/node.h"

namespace mien::virt {
namespace {

/// Packets of samples before this are all sent when the skin has been traced: what a packet's samples reach.
constexpr double kReachedS = 0.1;
constexpr double kSecondS = 1;
constexpr auto kSecondPoints = static_cast<std::size_t>(kSecondS * kTrajectoryRateHz);

}  // namespace

StreamedSession::StreamedSession(const sensor::Rig& rig, Reception reception,
                                 std::vector<sensor::DeviceKey> devices, std::vector<SkinSite> sites,
                                 performer::LongMotion motion)
    : rig_(&rig),
      reception_(std::move(reception)),
      devices_(std::move(devices)),
      motion_(std::make_unique<performer::LongMotion>(std::move(motion))),
      sites_(std::make_unique<std::vector<SkinSite>>(std::move(sites))),
      tracer_([motion_at = motion_.get()](double time_s) { return motion_at->at(time_s); }, *sites_,
              -kDeviceMarginS, motion_->duration_s() + kDeviceMarginS) {}

Result<StreamedSession> StreamedSession::create(const sensor::Rig& rig, std::vector<SkinSite> sites,
                                                const DeviceFaults& faults, performer::LongMotion motion,
                                                const Random& random, std::vector<SensorEvent> events) {
  MIEN_TRY_ASSIGN(Reception reception, Reception::create(rig));
  MIEN_TRY_ASSIGN(std::vector<sensor::DeviceKey> devices, virtual_devices(rig));
  StreamedSession out(rig, std::move(reception), std::move(devices), std::move(sites), std::move(motion));
  out.faults_ = faults;
  const double start_s = out.motion_->prologue().motion_start_s;
  DeviceTroubles troubles;
  for (const SensorEvent& event : events) {
    if (event.silent)
      troubles.silences.push_back(
          {.sensor = event.sensor, .from_s = start_s + event.begin_s, .to_s = start_s + event.end_s});
    if (event.restarts)
      troubles.restarts.push_back({.sensor = event.sensor, .at_s = start_s + event.begin_s});
  }
  MIEN_TRY_ASSIGN(out.troubled_, TroubledDevices::create(troubles));
  out.sensor_events_ = std::move(events);
  for (std::size_t s = 0; s < out.sites().size(); ++s)
    out.simulators_.emplace_back(faults, static_cast<std::uint16_t>(s), random.fork("sensor", s));
  out.waiting_.resize(out.simulators_.size());
  return out;
}

const VirtualClock& StreamedSession::reference_clock() const {
  return simulators_[rig_->find(rig_->reference).value_or(0)].clock();
}

std::vector<take::Event> StreamedSession::events() const {
  return prologue_events(motion_->prologue(), reference_clock());
}

void StreamedSession::apply_events() {
  const double start_s = motion_->prologue().motion_start_s;
  const double now_s = simulated_s() + 1 / kTrajectoryRateHz - start_s;
  for (const SensorEvent& event : sensor_events_) {
    const double whole_s = event.end_s - event.begin_s;
    const auto share = [&](double at_s) {
      return whole_s > 0             ? std::clamp((at_s - event.begin_s) / whole_s, 0.0, 1.0)
             : at_s >= event.begin_s ? 1.0
                                     : 0.0;
    };
    const double by = share(now_s) - share(now_s - kSecondS);
    if (by > 0) simulators_[event.sensor].push(by * event.turn_rad);
    if (!event.silent) continue;
    // Before it falls silent it feels what the heading is to be off by, and what it will not feel of the
    // head; half a second earlier, since fusion bridges the gap by the rates at its ends.
    const double felt_s = event.begin_s - 1.5 * kSecondS;
    if (event.heading_rad && now_s <= felt_s && now_s > felt_s - kSecondS) {
      const Quat turned =
          motion_->at(start_s + event.end_s).head * motion_->at(start_s + event.begin_s).head.conjugate();
      simulators_[event.sensor].feel_turn(
          start_s + felt_s, start_s + felt_s + kSecondS,
          *event.heading_rad + log_rotation(twist_about(turned, Vec3::UnitY())).y());
    }
    if (event.site && share(now_s) >= 0.5 && share(now_s - kSecondS) < 0.5)
      (*sites_)[event.sensor] = *event.site;
  }
}

Result<VirtualSession> StreamedSession::next(const StreamConsumer& consumer) {
  apply_events();
  const SkinTrajectory stretch = tracer_.next(kSecondPoints);
  const HostTime reached(from_seconds(simulated_s() + 1 / kTrajectoryRateHz - kReachedS));
  // As play_devices() has them: those of one moment in the order of the sensors.
  std::vector<Datagram> arrived;
  for (std::size_t s = 0; s < simulators_.size(); ++s) {
    for (const VirtualPacket& packet : simulators_[s].play(stretch)) {
      if (packet.lost) continue;
      MIEN_TRY_ASSIGN(std::vector<std::byte> bytes, encode_device_packet(packet, devices_[s], faults_));
      Datagram datagram{packet.arrival, static_cast<std::uint16_t>(s), std::move(bytes)};
      MIEN_TRY_ASSIGN(const bool goes, troubled_.pass(datagram));
      if (goes) waiting_[s].push_back(std::move(datagram));
    }
    std::vector<Datagram> later;
    for (Datagram& datagram : waiting_[s])
      (done() || datagram.time < reached ? arrived : later).push_back(std::move(datagram));
    waiting_[s] = std::move(later);
  }
  sort_by_time(arrived);

  VirtualSession session;
  const double motion_start_s = motion_->prologue().motion_start_s;
  session.motion_start = reference_clock().device(motion_start_s);
  if (!std::exchange(begun_, true)) session.events = events();
  std::size_t next_sample = 0;
  const auto hand_over = [&] {
    for (; consumer.sample && next_sample < session.samples.size(); ++next_sample)
      consumer.sample(session.samples[next_sample].arrival, session.samples[next_sample].sample);
  };
  std::vector<Vec3> creep_rad;
  for (const ImuSimulator& simulator : simulators_) creep_rad.push_back(simulator.creep_rad());
  reception_.log_all(std::move(arrived), session,
                     [&](const take::Tick& tick, const sensor::TimeLines& lines) {
                       hand_over();
                       const double true_s = reference_clock().true_s(tick.frame);
                       session.truth.push_back(
                           truth_of(motion_->at(true_s), true_s, motion_start_s, duration_s(), tick.frame));
                       if (consumer.frame)
                         consumer.frame({.tick = tick,
                                         .motion_s = true_s - motion_start_s,
                                         .weights = session.truth.back().weights,
                                         .creep_rad = creep_rad},
                                        lines);
                     });
  hand_over();
  return session;
}

}  // namespace mien::virt
