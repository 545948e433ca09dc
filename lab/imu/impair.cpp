#include "lab/imu/impair.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "mien/imu/packets/packet.h"
#include "mien/sensor/clock_model.h"
#include "mien/virtual/reception.h"

namespace mien::lab {
namespace {

/// The truth of the old session at any time of its line.
class OldTruth {
 public:
  explicit OldTruth(const std::vector<take::TruthFrame>& frames) : frames_(frames), curve_(motion(frames)) {}

  /// At `old` of the old line, for a frame that is `frame` on the new one.
  [[nodiscard]] take::TruthFrame at(DeviceTime old, DeviceTime frame) const {
    const auto after = std::ranges::lower_bound(frames_, old, {}, &take::TruthFrame::time);
    take::TruthFrame truth;
    if (after != frames_.end() && after->time == old) {
      truth = *after;
    } else {
      const face::MotionFrame moment = curve_.at(to_seconds(old - frames_.front().time));
      truth.weights = moment.weights;
      truth.tongue_out = moment.tongue_out;
      truth.has_face = moment.has_face;
      // Both frames around it count, or it does not.
      truth.evaluated = after != frames_.begin() && after != frames_.end() && after->evaluated &&
                        std::prev(after)->evaluated;
    }
    truth.time = frame;
    return truth;
  }

 private:
  static face::Motion motion(const std::vector<take::TruthFrame>& frames) {
    face::Motion motion;
    for (const take::TruthFrame& frame : frames) {
      face::MotionFrame out;
      out.time_s = to_seconds(frame.time - frames.front().time);
      out.weights = frame.weights;
      out.tongue_out = frame.tongue_out;
      out.has_face = frame.has_face;
      motion.frames.push_back(out);
    }
    return motion;
  }
  const std::vector<take::TruthFrame>& frames_;
  face::MotionCurve curve_;
};

/// The old reference's clock against the host's, as it was known at any moment of the old session.
class OldClock {
 public:
  OldClock(const virt::VirtualSession& session, std::uint16_t reference)
      : samples_(session.samples), reference_(reference) {}

  /// `now` never runs back.
  [[nodiscard]] std::optional<DeviceTime> at(HostTime moment, HostTime now) {
    for (; next_ < samples_.size() && samples_[next_].arrival <= now; ++next_)
      if (samples_[next_].sample.sensor == reference_)
        clock_.add(samples_[next_].sample.time, samples_[next_].arrival);
    if (!clock_.ready()) return std::nullopt;
    return clock_.to_device(moment);
  }

 private:
  const std::vector<take::StoredSample>& samples_;
  std::uint16_t reference_;
  std::size_t next_ = 0;
  sensor::ClockModel clock_;
};

/// What the reference's clock showed, and what it shows in trouble.
class TroubledClock {
 public:
  /// Shape: `before` and `after` in the order of sending; what stayed away is missing in `after`.
  TroubledClock(const std::vector<virt::Datagram>& before, const std::vector<virt::Datagram>& after,
                std::uint16_t reference) {
    auto old = before.begin();
    for (const virt::Datagram& datagram : after) {
      if (datagram.source != reference) continue;
      while (old->source != reference || old->time != datagram.time) ++old;
      pairs_.push_back({datagram.time, time_of(*old++), time_of(datagram)});
    }
  }

  /// What it showed when it showed `troubled`, by the packets of the last seconds before `now`: a clock that
  /// began anew shows a time twice.
  [[nodiscard]] std::optional<DeviceTime> before(DeviceTime troubled, HostTime now) const {
    const auto after = std::ranges::upper_bound(pairs_, now, {}, &Pair::sent);
    const Pair* nearest = nullptr;
    for (auto pair = after; pair != pairs_.begin();) {
      --pair;
      if (nearest != nullptr && now - pair->sent > std::chrono::seconds(3)) break;
      if (nearest == nullptr ||
          std::chrono::abs(pair->troubled - troubled) < std::chrono::abs(nearest->troubled - troubled))
        nearest = &*pair;
    }
    if (nearest == nullptr) return std::nullopt;
    return nearest->old + (troubled - nearest->troubled);
  }

 private:
  struct Pair {
    HostTime sent;
    DeviceTime old;
    DeviceTime troubled;
  };
  static DeviceTime time_of(const virt::Datagram& datagram) {
    const auto packet = imu::parse_packet(datagram.bytes);
    return packet ? packet->time : DeviceTime();
  }
  std::vector<Pair> pairs_;
};

/// Where moments of the old line stand on the new one: what the ticks know of it.
class NewLine {
 public:
  void add(DeviceTime old, DeviceTime frame) { known_.emplace_back(old, frame - old); }

  [[nodiscard]] DeviceTime at(DeviceTime old) const {
    if (known_.empty()) return old;
    const auto after =
        std::ranges::lower_bound(known_, old, {}, [](const auto& known) { return known.first; });
    return old + (after == known_.end() ? known_.back() : *after).second;
  }

 private:
  std::vector<std::pair<DeviceTime, Duration>> known_;
};

bool clock_in_trouble(const virt::DeviceTroubles& troubles, std::uint16_t sensor) {
  const auto hits = [&](const auto& list) {
    return std::ranges::any_of(list, [&](const auto& trouble) { return trouble.sensor == sensor; });
  };
  return hits(troubles.clocks) || hits(troubles.restarts);
}

}  // namespace

Result<virt::VirtualSession> impair(const virt::VirtualSession& session, const sensor::Rig& rig,
                                    const virt::NetworkSettings& settings, const Random& random,
                                    const virt::DeviceTroubles& troubles) {
  if (session.truth.empty()) return fail(ErrorCode::bad_usage, "the session has no truth", rig.name);
  MIEN_TRY_ASSIGN(const std::vector<sensor::DeviceKey> devices, virt::virtual_devices(rig));
  MIEN_TRY_ASSIGN(virt::Reception reception, virt::Reception::create(rig));
  std::vector<virt::Datagram> sent;
  sent.reserve(session.entries.size());
  for (const take::LogEntry& entry : session.entries) {
    const auto packet = imu::parse_packet(entry.bytes);
    if (!packet) return fail(ErrorCode::bad_usage, "the session has packets that are none", rig.name);
    const auto sensor = std::ranges::find(devices, sensor::DeviceKey{packet->device, packet->channel});
    if (sensor == devices.end())
      return fail(ErrorCode::bad_usage, "the session has packets of another rig's devices", rig.name);
    sent.push_back({entry.arrival, static_cast<std::uint16_t>(sensor - devices.begin()), entry.bytes});
  }
  const std::uint16_t reference = rig.find(rig.reference).value_or(0);
  const bool in_trouble = clock_in_trouble(troubles, reference);
  MIEN_TRY_ASSIGN(const std::vector<virt::Datagram> troubled, virt::trouble_devices(sent, troubles));
  const TroubledClock reference_clock(in_trouble ? sent : std::vector<virt::Datagram>(),
                                      in_trouble ? troubled : std::vector<virt::Datagram>(), reference);
  MIEN_TRY_ASSIGN(std::vector<virt::Datagram> arrived, virt::deliver(troubled, settings, random));

  const Duration lag = from_seconds(1e-3 * settings.lag_ms);
  const OldTruth truth(session.truth);
  OldClock host_clock(session, reference);
  NewLine line;
  virt::VirtualSession out;
  reception.log_all(std::move(arrived), out, [&](const take::Tick& tick, const sensor::TimeLines& lines) {
    DeviceTime old = tick.frame;
    if (lines.on_host_time())
      old = host_clock.at(lines.to_host(tick.frame) - lag, tick.fired).value_or(tick.frame);
    else if (in_trouble)
      old = reference_clock.before(lines.from_line(reference, tick.frame), tick.fired).value_or(tick.frame);
    line.add(old, tick.frame);
    out.truth.push_back(truth.at(old, tick.frame));
  });
  out.motion_start = line.at(session.motion_start);
  for (const take::Event& event : session.events)
    out.events.push_back({event.kind, line.at(event.begin), line.at(event.end), event.json});
  return out;
}

}  // namespace mien::lab
