#include "mien/virtual/reception.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "mien/modalities/modalities.h"
#include "mien/sensor/bindings.h"
#include "mien/virtual/prologue_record.h"

namespace mien::virt {

Result<Reception> Reception::create(const sensor::Rig& rig) {
  MIEN_TRY_ASSIGN(auto receiving, modalities::make_receiving_session(rig));
  return Reception(std::move(receiving));
}

void Reception::log(Datagram datagram, VirtualSession& session) {
  const std::int64_t id = ++entries_;
  constexpr sensor::Peer kOneMachine = 0;  // All stand in the log with one source.
  for (const sensor::Sample& sample :
       session_->receive_logged(datagram.time, kOneMachine, datagram.bytes, {datagram.payload, {}}).samples)
    session.samples.push_back({id, datagram.time, sample});
  session.entries.push_back({id, datagram.time, "virtual", std::move(datagram.bytes)});
  if (!datagram.payload.empty()) session.payloads.emplace(id, std::move(datagram.payload));
}

void Reception::log_all(std::vector<Datagram> arrived, VirtualSession& session,
                        const std::function<void(const take::Tick&, const sensor::TimeLines&)>& on_tick) {
  const auto fire = [&](HostTime now) {
    while (const auto due = session_->due(now)) {
      const take::Tick tick{due->index, entries_, due->fired, due->frame};
      session.ticks.push_back(tick);
      on_tick(tick, session_->lines());
    }
  };
  for (Datagram& datagram : arrived) {
    const HostTime arrival = datagram.time;
    fire(arrival);
    log(std::move(datagram), session);
    fire(arrival);
  }
}

Result<VirtualSession> receive_all(Sent sent, const performer::PrologueMotion& motion,
                                   const sensor::Rig& rig) {
  MIEN_TRY_ASSIGN(Reception reception, Reception::create(rig));
  const face::MotionCurve curve(motion.motion);
  const double motion_start_s = motion.times.motion_start_s;
  sort_by_time(sent.datagrams);
  const auto truth = [&](double true_s, DeviceTime frame) {
    return truth_of(curve.at(true_s), true_s, motion_start_s, curve.duration_s(), frame);
  };
  VirtualSession session;
  session.events = prologue_events(motion.times, sent.reference);
  std::ranges::move(sent.events, std::back_inserter(session.events));
  session.motion_start = sent.reference.device(motion_start_s);
  if (!sent.frames) {
    reception.log_all(std::move(sent.datagrams), session,
                      [&](const take::Tick& tick, const sensor::TimeLines&) {
                        session.truth.push_back(truth(sent.reference.true_s(tick.frame), tick.frame));
                      });
    return session;
  }
  auto next = sent.datagrams.begin();
  for (std::int64_t f = 0; f < *sent.frames; ++f) {
    const Duration at = frame_offset(f);
    for (; next != sent.datagrams.end() && next->time <= HostTime(at); ++next)
      reception.log(std::move(*next), session);
    session.ticks.push_back(
        {f, static_cast<std::int64_t>(session.entries.size()), HostTime(at), DeviceTime(at)});
    session.truth.push_back(truth(to_seconds(at), DeviceTime(at)));
  }
  return session;
}

Result<std::vector<sensor::DeviceKey>> virtual_devices(const sensor::Rig& rig) {
  MIEN_TRY_ASSIGN(const auto bound, sensor::bindings(rig));
  if (bound.size() != rig.sensors.size())
    return fail(ErrorCode::bad_usage,
                fmt::format("{} of {} sensors are bound to a device", bound.size(), rig.sensors.size()),
                "rig " + rig.name, "give every sensor a device, or none");
  std::vector<sensor::DeviceKey> devices(bound.size());
  for (const auto& [key, sensor] : bound) devices[sensor] = key;
  return devices;
}

}  // namespace mien::virt
