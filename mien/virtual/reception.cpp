#include "mien/virtual/reception.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "mien/modalities/modalities.h"
#include "mien/sensor/bindings.h"
#include "mien/session/prompt.h"

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

std::vector<take::Event> prologue_events(const performer::PrologueTimes& times,
                                         const VirtualClock& reference) {
  std::vector<take::Event> events;
  const auto add = [&](const char* kind, double begin_s, double end_s, std::string json = {}) {
    if (end_s > begin_s)
      events.push_back({kind, reference.device(begin_s), reference.device(end_s), std::move(json)});
  };
  add("neutral", times.neutral.begin_s, times.neutral.end_s);
  add("nod", times.nod.begin_s, times.nod.end_s);
  add("shake", times.shake.begin_s, times.shake.end_s);
  if (!times.prompts.empty()) add("range", times.prompts.front().begin_s, times.range_of_motion.end_s);
  for (const performer::Prompt& prompt : times.prompts) {
    std::string target;
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      if (prompt.target[k] != 0)
        target +=
            fmt::format("{}\"{}\": {}", target.empty() ? "" : ", ", face::kShapeNames[k], prompt.target[k]);
    add("prompt", prompt.begin_s, prompt.end_s,
        fmt::format(R"({{"name": "{}", "anchor": {}, "rise_s": {}, "target": {{{}}}}})", prompt.name,
                    prompt.anchor, prompt.rise_s, target));
  }
  // As a session asks for them (session::Guide): the eyes have turned there.
  constexpr double kTurns_s = 0.9;
  double looks_s = times.gaze.begin_s;
  for (const face::GazeTarget& target : face::gaze_targets()) {
    const double end_s = looks_s + performer::kGazeTarget_s;
    if (times.gaze.end_s > times.gaze.begin_s)
      add("gaze", looks_s + kTurns_s, end_s, session::gaze_event_json(target));
    looks_s = end_s;
  }
  add("ease", times.ease.begin_s, times.ease.end_s);
  return events;
}

take::TruthFrame truth_of(const face::MotionFrame& moment, double true_s, double motion_start_s,
                          double duration_s, DeviceTime frame) {
  take::TruthFrame truth;
  truth.time = frame;
  truth.weights = moment.weights;
  truth.tongue_out = moment.tongue_out;
  truth.has_face = moment.has_face;
  truth.evaluated = true_s >= motion_start_s - kSameMomentS && true_s <= duration_s + kSameMomentS;
  return truth;
}

Result<face::MotionCurve> curve_of(const performer::PrologueMotion& motion) {
  if (motion.motion.frames.empty())
    return fail(ErrorCode::bad_usage, "the motion has no frames", motion.motion.name);
  return face::MotionCurve(motion.motion);
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
