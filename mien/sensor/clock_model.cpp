#include "mien/sensor/clock_model.h"

#include <algorithm>
#include <cmath>

namespace mien::sensor {
namespace {

/// A device time this far behind the newest one is a board that began anew.
constexpr double kBackwards_s = 1.0;
/// Nothing arrives this much before the earliest it ever did, unless the clock jumped.
constexpr double kEarly_s = 0.1;
/// Arrivals later than this for so long are a clock that stood still, not a slow radio.
constexpr double kLate_s = 0.5;
constexpr Duration kLateFor = std::chrono::seconds(3);
/// A session without its reference waits this long for it.
constexpr Duration kWaitForReference = std::chrono::milliseconds(500);
/// A crystal of which nothing is known yet.
constexpr double kUnknownRate = 50e-6;

}  // namespace

DeviceTime ClockModel::Line::to_device(HostTime host) const {
  const std::int64_t rough =
      host.time_since_epoch().count() - base_offset_ns;  // Device time, but for the line.
  const double x0 = static_cast<double>(rough - base_device_ns) * 1e-9;
  const double x = (x0 - offset_s) / (1 + rate);
  return DeviceTime(Duration(rough) - from_seconds(offset_s + rate * x));
}

void ClockModel::restart(DeviceTime device, HostTime arrival) {
  size_ = 0;
  first_ = 0;
  pairs_ = 0;
  newest_x_ = 0;
  delay_sum_ = 0;
  late_since_.reset();
  jump_expected_ = false;
  stretch_index_ = 0;
  line_ = {};
  line_.base_device_ns = device.time_since_epoch().count();
  line_.base_offset_ns = arrival.time_since_epoch().count() - line_.base_device_ns;
}

bool ClockModel::add(DeviceTime device, HostTime arrival) {
  bool jumped = false;
  if (pairs_ == 0) restart(device, arrival);
  const auto at = [&] {
    const std::int64_t device_ns = device.time_since_epoch().count();
    const std::int64_t offset_ns = arrival.time_since_epoch().count() - device_ns;
    return Point{static_cast<double>(device_ns - line_.base_device_ns) * 1e-9,
                 static_cast<double>(offset_ns - line_.base_offset_ns) * 1e-9};
  };
  Point p = at();
  if (pairs_ > 0) {
    fit();
    const double over = p.y - (line_.offset_s + line_.rate * p.x);
    if (over < kLate_s)
      late_since_.reset();
    else if (!late_since_)
      late_since_ = arrival;
    if (jump_expected_ || p.x < newest_x_ - kBackwards_s || over < -kEarly_s ||
        (late_since_ && arrival - *late_since_ > kLateFor)) {
      before_jump_ = line_;
      restart(device, arrival);
      p = at();
      jumped = true;
    }
  }
  newest_x_ = std::max(newest_x_, p.x);
  const auto stretch = static_cast<std::int64_t>(std::floor(p.x / to_seconds(settings_.stretch)));
  if (size_ == 0 || stretch > stretch_index_) {
    if (size_ == kStretches) {
      first_ = (first_ + 1) % kStretches;
      --size_;
    }
    earliest_[(first_ + size_) % kStretches] = p;
    ++size_;
    stretch_index_ = stretch;
    fitted_ = false;
  } else if (Point& last = earliest_[(first_ + size_ - 1) % kStretches]; p.y < last.y) {
    last = p;
    fitted_ = false;
  }
  ++pairs_;
  delay_sum_ += p.y;
  return jumped;
}

void ClockModel::fit() const {
  if (fitted_) return;
  fitted_ = true;
  const double span_s = point(size_ - 1).x - point(0).x;
  if (size_ < 3 || span_s < to_seconds(settings_.min_span)) {
    line_.rate = 0;
    line_.offset_s = point(0).y;
    for (std::size_t i = 1; i < size_; ++i) line_.offset_s = std::min(line_.offset_s, point(i).y);
  } else {
    // Lower convex hull (monotone chain); its edge over the mean time is the line of least area under the
    // points.
    std::array<Point, kStretches> hull;
    std::size_t corners = 0;
    double mean_x = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      const Point p = point(i);
      mean_x += p.x;
      while (corners >= 2) {
        const Point& a = hull[corners - 2];
        const Point& b = hull[corners - 1];
        if ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) > 0) break;
        --corners;
      }
      hull[corners++] = p;
    }
    mean_x /= static_cast<double>(size_);
    std::size_t edge = 0;
    while (edge + 2 < corners && hull[edge + 1].x < mean_x) ++edge;
    const Point& a = hull[edge];
    const Point& b = hull[edge + 1];
    line_.rate = std::clamp((b.y - a.y) / std::max(b.x - a.x, 1e-9), -settings_.max_rate, settings_.max_rate);
    line_.offset_s = a.y - line_.rate * a.x;
    for (std::size_t i = 0; i < size_; ++i)
      line_.offset_s = std::min(line_.offset_s, point(i).y - line_.rate * point(i).x);
  }
  if (size_ < 3) {
    scatter_s_ = std::max(0.0, delay_sum_ / static_cast<double>(pairs_) - line_.offset_s) /
                 std::sqrt(static_cast<double>(pairs_));
  } else {
    scatter_s_ = 0;
    for (std::size_t i = 0; i < size_; ++i)
      scatter_s_ += point(i).y - line_.offset_s - line_.rate * point(i).x;
    scatter_s_ /= static_cast<double>(size_);
  }
}

HostTime ClockModel::to_host(DeviceTime device) const {
  fit();
  const std::int64_t device_ns = device.time_since_epoch().count();
  const double x = static_cast<double>(device_ns - line_.base_device_ns) * 1e-9;
  return HostTime(Duration(device_ns + line_.base_offset_ns) + from_seconds(line_.offset_s + line_.rate * x));
}

DeviceTime ClockModel::to_device(HostTime host) const {
  fit();
  return line_.to_device(host);
}

DeviceTime ClockModel::to_device_before_jump(HostTime host) const {
  return before_jump_.to_device(host);
}

double ClockModel::rate() const {
  fit();
  return line_.rate;
}

Duration ClockModel::uncertainty(DeviceTime device) const {
  fit();
  const double x = static_cast<double>(device.time_since_epoch().count() - line_.base_device_ns) * 1e-9;
  const double span_s = point(size_ - 1).x - point(0).x;
  const bool rate_known = size_ >= 3 && span_s >= to_seconds(settings_.min_span);
  const double rate_sigma = rate_known ? scatter_s_ / span_s : kUnknownRate;
  const double middle = rate_known ? 0.5 * (point(0).x + point(size_ - 1).x) : newest_x_;
  return from_seconds(1e-6 + scatter_s_ + rate_sigma * std::abs(x - middle));
}

TimeLines::TimeLines(std::size_t sensor_count, std::optional<std::uint16_t> reference)
    : clocks_(sensor_count), reference_(reference) {}

bool TimeLines::has_samples(std::uint16_t sensor) const {
  return sensor < clocks_.size() && (clocks_[sensor].on_line || clocks_[sensor].model.ready());
}

bool TimeLines::follow(HostTime arrival, const Sample& sample) {
  if (sample.sensor >= clocks_.size()) return false;
  Clock& clock = clocks_[sample.sensor];
  const bool jumped = clock.model.add(sample.time, arrival);
  clock.newest = sample.time;
  if (jumped) {
    // What pulses told was of the clock before.
    for (Clock& other : clocks_) {
      if (&other != &clock && reference_ != sample.sensor) continue;
      other.wire = ClockModel();
      other.pairs = 0;
    }
    clock.pulses.fill(std::nullopt);
  }
  return jumped;
}

void TimeLines::add(HostTime arrival, const Sample& sample) {
  if (sample.sensor >= clocks_.size()) return;
  if (!begin_) begin_ = arrival;
  if (is_on_frame_time(sample.kind)) {
    clocks_[sample.sensor].on_line = true;
    if (basis_ == Basis::open) basis_ = Basis::host;
    return;
  }
  const bool jumped = follow(arrival, sample);
  const ClockModel& clock = clocks_[sample.sensor].model;
  const bool is_reference = reference_ == sample.sensor;
  if (basis_ == Basis::open) {
    if (is_reference)
      basis_ = Basis::reference;
    else if (!reference_ || arrival - *begin_ > kWaitForReference)
      basis_ = Basis::host;
  } else if (jumped && is_reference && basis_ == Basis::reference) {
    // The new clock goes on where the old one would stand now.
    shift_ += clock.to_device_before_jump(arrival) - clock.to_device(arrival);
  }
}

void TimeLines::pulse(std::uint16_t sensor, std::uint32_t index, DeviceTime edge) {
  if (sensor >= clocks_.size() || !reference_) return;
  const Pulse told{index, edge};
  Clock& clock = clocks_[sensor];
  clock.pulses[index % kPulses] = told;
  if (sensor != *reference_) {
    const std::optional<Pulse>& same = clocks_[*reference_].pulses[index % kPulses];
    if (same && same->index == index) pair(clock, told, *same);
    return;
  }
  for (std::size_t i = 0; i < clocks_.size(); ++i) {
    if (i == *reference_) continue;
    const std::optional<Pulse>& same = clocks_[i].pulses[index % kPulses];
    if (same && same->index == index) pair(clocks_[i], *same, told);
  }
}

void TimeLines::forget(std::uint16_t sensor) {
  if (sensor >= clocks_.size()) return;
  if (reference_ == sensor && basis_ == Basis::reference)
    clocks_[sensor].model.expect_jump();
  else
    clocks_[sensor] = Clock();
}

void TimeLines::pair(Clock& clock, const Pulse& own, const Pulse& reference) {
  // The reference's clock in the place of the host's: a pulse "arrives" exactly when it stands there.
  if (clock.wire.add(own.edge, HostTime(reference.edge.time_since_epoch()))) clock.pairs = 0;
  ++clock.pairs;
  clock.last_edge = own.edge;
}

HostTime TimeLines::to_host(DeviceTime line) const {
  if (basis_ == Basis::reference) return clocks_[*reference_].model.to_host(line - shift_);
  return HostTime(line.time_since_epoch());
}

DeviceTime TimeLines::from_host(HostTime host) const {
  if (basis_ == Basis::reference) return clocks_[*reference_].model.to_device(host) + shift_;
  return DeviceTime(host.time_since_epoch());
}

DeviceTime TimeLines::to_line(std::uint16_t sensor, DeviceTime device) const {
  const Clock& clock = clocks_[sensor];
  if (clock.on_line) return device;
  if (basis_ == Basis::reference && reference_ == sensor) return device + shift_;
  if (by_wire(clock)) return DeviceTime(clock.wire.to_host(device).time_since_epoch()) + shift_;
  return from_host(clock.model.to_host(device));
}

DeviceTime TimeLines::from_line(std::uint16_t sensor, DeviceTime line) const {
  const Clock& clock = clocks_[sensor];
  if (clock.on_line) return line;
  if (basis_ == Basis::reference && reference_ == sensor) return line - shift_;
  if (by_wire(clock)) return clock.wire.to_device(HostTime((line - shift_).time_since_epoch()));
  return clock.model.to_device(to_host(line));
}

}  // namespace mien::sensor
