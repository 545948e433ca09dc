#include "mien/study/imu/hours_session.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "mien/core/time.h"
#include "mien/virtual/imu/device_packet.h"
#include "mien/virtual/node.h"
#include "mien/virtual/prologue_record.h"

namespace mien::study {
namespace {

/// Packets of samples before this are all sent when the skin has been traced: what a packet's samples reach.
constexpr double kBehindS = 0.1;
constexpr auto kStretchPoints = static_cast<std::size_t>(virt::kTrajectoryRateHz);

}  // namespace

HoursSession::HoursSession(const sensor::Rig& rig, virt::Reception reception,
                           std::vector<sensor::DeviceKey> devices, HoursMotion motion)
    : rig_(&rig),
      reception_(std::move(reception)),
      devices_(std::move(devices)),
      motion_(std::move(motion)) {}

Result<HoursSession> HoursSession::create(const sensor::Rig& rig, std::vector<virt::SkinSite> sites,
                                          const virt::DeviceFaults& faults, HoursMotion motion,
                                          const Random& random, std::vector<Push> pushes) {
  MIEN_TRY_ASSIGN(virt::Reception reception, virt::Reception::create(rig));
  MIEN_TRY_ASSIGN(std::vector<sensor::DeviceKey> devices, virt::virtual_devices(rig));
  HoursSession out(rig, std::move(reception), std::move(devices), std::move(motion));
  out.sites_ = std::move(sites);
  out.faults_ = faults;
  out.pushes_ = std::move(pushes);
  for (std::size_t s = 0; s < out.sites_.size(); ++s)
    out.simulators_.emplace_back(faults, static_cast<std::uint16_t>(s), random.fork("sensor", s));
  return out;
}

std::vector<take::Event> HoursSession::events() const {
  return virt::prologue_events(motion_.prologue(),
                               simulators_[rig_->find(rig_->reference).value_or(0)].clock());
}

virt::SkinTrajectory HoursSession::trace(std::size_t points) {
  virt::SkinTrajectory out;
  out.begin_s = -virt::kDeviceMarginS;
  out.first = traced_;
  out.points = points;
  out.rotation.resize(sites_.size());
  out.position_m.resize(sites_.size());
  for (std::size_t i = 0; i < points; ++i, ++traced_) {
    const face::MotionFrame frame =
        motion_.at(std::max(0.0, out.begin_s + static_cast<double>(traced_) / virt::kTrajectoryRateHz));
    out.head.push_back(frame.head);
    out.head_position_m.push_back(frame.head_position_m);
    for (std::size_t s = 0; s < sites_.size(); ++s) {
      out.rotation[s].push_back(sites_[s].rotation(frame.weights));
      out.position_m[s].push_back(sites_[s].position(frame.weights));
    }
  }
  return out;
}

void HoursSession::push() {
  constexpr double kStretchS = static_cast<double>(kStretchPoints) / virt::kTrajectoryRateHz;
  const double now_s = static_cast<double>(traced_) / virt::kTrajectoryRateHz - virt::kDeviceMarginS -
                       motion_.prologue().motion_start_s;
  for (const Push& push : pushes_) {
    const double whole_s = push.end_s - push.begin_s;
    const auto share = [&](double at_s) {
      return whole_s > 0            ? std::clamp((at_s - push.begin_s) / whole_s, 0.0, 1.0)
             : at_s >= push.begin_s ? 1.0
                                    : 0.0;
    };
    const double by = share(now_s) - share(now_s - kStretchS);
    if (by > 0) simulators_[push.sensor].push(by * push.turn_rad);
  }
}

Result<void> HoursSession::next(const HoursConsumer& consumer) {
  push();
  const virt::SkinTrajectory stretch = trace(kStretchPoints);
  for (std::size_t s = 0; s < simulators_.size(); ++s)
    for (const virt::VirtualPacket& packet : simulators_[s].play(stretch)) {
      if (packet.lost) continue;
      MIEN_TRY_ASSIGN(std::vector<std::byte> bytes, virt::encode_device_packet(packet, devices_[s], faults_));
      waiting_.push_back({packet.arrival, static_cast<std::uint16_t>(s), std::move(bytes)});
    }
  virt::sort_by_time(waiting_);
  const double traced_s = static_cast<double>(traced_) / virt::kTrajectoryRateHz - virt::kDeviceMarginS;
  const auto end = std::ranges::partition_point(waiting_, [&](const virt::Datagram& datagram) {
    return datagram.time < HostTime(from_seconds(traced_s - kBehindS));
  });
  std::vector<virt::Datagram> arrived(std::make_move_iterator(waiting_.begin()),
                                      std::make_move_iterator(end));
  waiting_.erase(waiting_.begin(), end);

  virt::VirtualSession session;
  std::size_t next_sample = 0;
  const auto hand_over = [&] {
    for (; next_sample < session.samples.size(); ++next_sample)
      consumer.sample(session.samples[next_sample].arrival, session.samples[next_sample].sample);
  };
  std::vector<Vec3> creep_rad;
  for (const virt::ImuSimulator& simulator : simulators_) creep_rad.push_back(simulator.creep_rad());
  const virt::VirtualClock& reference = simulators_[rig_->find(rig_->reference).value_or(0)].clock();
  reception_.log_all(std::move(arrived), session,
                     [&](const take::Tick& tick, const sensor::TimeLines& lines) {
                       hand_over();
                       const double true_s = reference.true_s(tick.frame);
                       HoursFrame frame{.tick = tick,
                                        .motion_s = true_s - motion_.prologue().motion_start_s,
                                        .weights = motion_.at(true_s).weights,
                                        .creep_rad = creep_rad};
                       consumer.frame(frame, lines);
                     });
  hand_over();
  return {};
}

}  // namespace mien::study
