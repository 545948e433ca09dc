#include "mien/sensor/link_health.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace mien::sensor {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Duration kLostAfter = milliseconds(100);
constexpr Duration kLostAfterEstimated = seconds(1);
/// What a device says of its face holds for so long: how often it says it while it sees none is its own.
constexpr Duration kNoFaceHolds = seconds(1);
/// A frame and what a tick waits for its samples: what is later than that missed its frame.
constexpr Duration kLateBehind = milliseconds(25);
constexpr Duration kFrozenFor = milliseconds(500);
constexpr Duration kSaturatedShown = milliseconds(500);
constexpr Duration kRestartShown = seconds(3);
constexpr double kTooMuch = 0.05;
/// Samples without a change before a sensor is called frozen: a gap alone is none.
constexpr std::uint32_t kFrozenSamples = 8;

/// Device times go on within this of what went by on the host's clock, and so far back at most.
constexpr Duration kBackAtMost = seconds(1);
constexpr Duration kAheadAtMost = seconds(2);
/// No device sends its packets faster, but for a few at once.
constexpr Duration kLeastPeriod = milliseconds(1);
constexpr std::int64_t kPacketsAtOnce = 64;
/// The line that was left is known for so long.
constexpr Duration kLineKept = seconds(5);

constexpr Duration kBucket = milliseconds(250);
constexpr std::int64_t kLossBuckets = 20;   // Five seconds.
constexpr std::int64_t kRateBuckets = 8;    // Two.
constexpr std::int64_t kBreakBuckets = 12;  // Three.
/// A restart is one break of the line, and a straggler from before it makes two more.
constexpr std::int64_t kBreaksOfTwoDevices = 4;
constexpr Duration kLeastWindow = seconds(30);

constexpr std::int64_t bucket_number(HostTime time) {
  const std::int64_t ns = time.time_since_epoch().count();
  return ns / kBucket.count() - (ns % kBucket.count() < 0 ? 1 : 0);
}

/// How many packets may lie within a stretch of device or host time.
constexpr std::int64_t packets_within(Duration d) {
  return kPacketsAtOnce + (d < Duration{} ? -d : d) / kLeastPeriod;
}

/// Sequence numbers wrap: the shorter way round counts.
constexpr std::int64_t steps(std::uint32_t from, std::uint32_t to) {
  return static_cast<std::int32_t>(to - from);
}

/// Equal but for the last bits of a float: the sensors' own steps are much coarser.
bool same(float a, float b) {
  return std::abs(a - b) <= 1e-6f * std::max(1.0f, std::abs(b));
}

/// Place of a part in the order of its packet's parts; 0 of a sample that is none.
std::uint32_t part_of(const Sample& sample) {
  if (sample.kind != SampleKind::weights && sample.kind != SampleKind::weights_confidence &&
      sample.kind != SampleKind::head_pose)
    return 0;
  // Parts of one kind begin with where they belong (mien/phone/told_face.h).
  const float first = sample.kind == SampleKind::head_pose ? 0 : sample.values[2];
  return 1000 * static_cast<std::uint32_t>(sample.kind) +
         static_cast<std::uint32_t>(first > 0 ? std::min(first, 999.0F) : 0);  // Not a number: 0.
}

}  // namespace

std::string_view link_state_name(LinkState state) {
  static constexpr std::array<std::string_view, 12> kNames = {
      "unbound", "silent",    "good",      "lossy",     "late",      "lost",
      "frozen",  "saturated", "unchanged", "restarted", "duplicate", "no_face"};
  static_assert(kNames.size() == static_cast<std::size_t>(LinkState::no_face) + 1);
  return kNames[static_cast<std::size_t>(state)];
}

void LinkHealth::Stillness::add(std::span<const float> now, DeviceTime time) {
  bool changed = now.size() != count;
  for (std::size_t i = 0; i < now.size() && !changed; ++i) changed = !same(now[i], values[i]);
  const bool gap = time - newest > kLostAfter;  // What was not received may have changed and come back.
  newest = time;
  ++samples;
  if (!changed && !gap) return;
  // Against the values of the last change, not of the last sample: a slow creep is a change too.
  std::ranges::copy(now, values.begin());
  count = static_cast<std::uint8_t>(now.size());
  since = time;
  samples = 0;
}

bool LinkHealth::Stillness::frozen() const {
  return count > 0 && samples >= kFrozenSamples && newest - since >= kFrozenFor;
}

bool LinkHealth::continues(const Line& line, const Sample& sample, HostTime arrival) {
  if (!line.begun) return false;
  const std::int64_t ahead = steps(line.newest, sample.sequence);
  const Duration host = std::max(arrival - line.arrival, Duration{});
  if (sample.time_estimated)  // The time is made of arrivals: only the numbers tell.
    return ahead >= -kPacketsAtOnce && ahead <= packets_within(host);
  const Duration device = sample.time - line.time;
  if (device < -kBackAtMost || device > host + kAheadAtMost) return false;
  if (std::abs(ahead) > packets_within(device)) return false;
  // Far back in the sequence and yet later in time: the board counts anew.
  return ahead > -kPacketsAtOnce || device <= Duration{};
}

LinkHealth::Line& LinkHealth::line_of(const Sample& sample, HostTime arrival) {
  Line& present = lines_[current_];
  if (!present.begun || continues(present, sample, arrival)) return present;
  current_ = 1 - current_;
  Line& other = lines_[current_];
  ++bucket(arrival).breaks;
  forget_data();
  if (arrival - other.arrival <= kLineKept && continues(other, sample, arrival)) return other;
  other.begun = false;
  ++restarts_;
  restarted_ = arrival;
  return other;
}

LinkHealth::Bucket& LinkHealth::bucket(HostTime arrival) {
  const std::int64_t number = bucket_number(arrival);
  Bucket& b = buckets_[static_cast<std::size_t>(((number % std::int64_t{kBuckets}) + kBuckets) % kBuckets)];
  if (b.number != number) b = Bucket{.number = number};
  return b;
}

LinkHealth::News LinkHealth::place(Line& line, const Sample& sample, HostTime arrival) {
  Remembered& slot = line.packets[sample.sequence % kRemembered];
  const Remembered packet{.sequence = sample.sequence, .came = true, .time = sample.time};
  if (!line.begun) {
    line.packets.fill({});
    line.begun = true;
    line.newest = sample.sequence;
    line.time = sample.time;
    line.arrival = arrival;
    slot = packet;
    return News::forward;
  }
  const std::int64_t ahead = steps(line.newest, sample.sequence);
  if (ahead > 0) {
    if (!sample.time_estimated) {
      const std::int64_t missing = ahead - 1;
      lost_ += static_cast<std::uint64_t>(missing);
      // Of a long silence only what is lately counts as lost lately.
      const std::int64_t lately = kLossBuckets * kBucket / std::max(packet_period_, kLeastPeriod);
      bucket(arrival).lost += std::min(missing, lately);
      if (missing == 0 && sample.time > line.time)
        packet_period_ += (std::min(sample.time - line.time, Duration(seconds(1))) - packet_period_) / 8;
    }
    // A slot whose number is not `sequence` has not come; so the missing ones need no entry.
    slot = packet;
    line.newest = sample.sequence;
    line.time = std::max(line.time, sample.time);
    line.arrival = arrival;
    return News::forward;
  }
  if (-ahead >= static_cast<std::int64_t>(kRemembered)) return News::reordered;
  if (slot.came && slot.sequence == sample.sequence)
    return sample.time_estimated || slot.time == sample.time ? News::doubled : News::stranger;
  slot = packet;
  if (!sample.time_estimated && lost_ > 0) {
    --lost_;
    --bucket(arrival).lost;
  }
  return News::reordered;
}

void LinkHealth::judge_lateness(HostTime arrival, const Sample& sample) {
  const Duration delay = arrival.time_since_epoch() - sample.time.time_since_epoch();
  const std::int64_t window = arrival.time_since_epoch() / kLeastWindow;
  if (least_ && window != least_begun_) {
    least_before_ = window == least_begun_ + 1 ? least_ : std::nullopt;
    least_.reset();
  }
  least_begun_ = window;
  least_ = std::min(least_.value_or(delay), delay);
  const Duration least = std::min(*least_, least_before_.value_or(*least_));
  if (delay - least <= kLateBehind) return;
  ++late_;
  ++bucket(arrival).late;
}

void LinkHealth::judge_parts() {
  if (!parts_) return;
  const auto mixed = static_cast<float>(*parts_ >> 8U);  // Exact.
  still_[0].add(std::span(&mixed, 1), packet_time_);
  parts_.reset();
}

void LinkHealth::judge_change(const Sample& sample) {
  if (sample.kind == SampleKind::sound) return;  // A quiet room does not vary.
  const std::span<const float> values = sample.used();
  if (part_of(sample) != 0) {
    // FNV-1a by words.
    std::uint32_t mixed = parts_.value_or(2166136261U);
    for (const float value : values) mixed = (mixed ^ std::bit_cast<std::uint32_t>(value)) * 16777619U;
    parts_ = mixed;
    return;
  }
  if (sample.kind == SampleKind::imu_raw && values.size() >= 6) {
    // Either chip may freeze alone, and both always have noise. A magnetometer is slow: it proves nothing.
    still_[0].add(values.subspan(0, 3), sample.time);
    still_[1].add(values.subspan(3, 3), sample.time);
  } else {
    still_[0].add(values, sample.time);
  }
}

void LinkHealth::forget_data() {
  still_ = {};
  parts_.reset();
  least_.reset();
  least_before_.reset();
}

void LinkHealth::begin_packet(HostTime arrival, const Sample& sample) {
  Line& line = line_of(sample, arrival);
  packet_news_ = place(line, sample, arrival);
  packet_sequence_ = sample.sequence;
  packet_arrival_ = arrival;
  Bucket& b = bucket(arrival);
  switch (packet_news_) {
    case News::doubled:
      ++doubled_;
      return;
    case News::stranger:
      ++b.breaks;
      forget_data();  // Two clocks have no common lateness.
      return;
    case News::reordered:
      ++reordered_;
      break;
    case News::forward:
      break;
  }
  ++b.packets;
  judge_lateness(arrival, sample);
}

void LinkHealth::add(HostTime arrival, const Sample& sample, bool saturated) {
  if (!received_) first_arrival_ = arrival;
  const std::uint32_t part = part_of(sample);
  const bool further_part = sample.time == packet_time_ && part > packet_part_ && packet_part_ > 0;
  const bool goes_on = received_ && sample.sequence == packet_sequence_ && arrival == packet_arrival_ &&
                       (sample.time > packet_time_ || further_part);
  received_ = true;
  estimated_ = sample.time_estimated;
  newest_arrival_ = arrival;
  if (no_face_ && arrival > *no_face_) no_face_.reset();
  if (!goes_on) {
    judge_parts();
    begin_packet(arrival, sample);
  }
  packet_time_ = sample.time;
  packet_part_ = part;
  if (packet_news_ == News::doubled) return;
  if (!(goes_on && further_part)) ++bucket(arrival).samples;
  if (saturated) saturated_ = arrival;
  if (packet_news_ == News::forward) judge_change(sample);
}

void LinkHealth::add_no_face(HostTime arrival) {
  if (!no_face_) no_face_since_ = arrival;
  no_face_ = arrival;
}

bool LinkHealth::sees_no_face(HostTime now) const {
  if (!no_face_ || now - *no_face_ > kNoFaceHolds) return false;
  return !received_ || now - no_face_since_ > kLostAfter || now - newest_arrival_ > kLostAfter;
}

LinkState LinkHealth::state(HostTime now, double loss, double late_share, std::int64_t breaks) const {
  const bool no_face = sees_no_face(now);
  if (!received_) return no_face ? LinkState::no_face : no_face_ ? LinkState::lost : LinkState::silent;
  const Duration age = now - newest_arrival_;
  if (no_face) {
    // It is there: that no samples come is its answer.
  } else if (estimated_) {
    const bool answers = alive_ && now - *alive_ <= kLostAfterEstimated;
    if (age > (answers ? std::max(settings_.unchanged_for, kLostAfterEstimated) : kLostAfterEstimated))
      return LinkState::lost;
  } else if (age > kLostAfter) {
    return LinkState::lost;
  }
  if (breaks >= kBreaksOfTwoDevices) return LinkState::duplicate;
  if (no_face) return LinkState::no_face;
  if (age > kLostAfter) return LinkState::unchanged;
  if (restarted_ && now - *restarted_ <= kRestartShown) return LinkState::restarted;
  if (still_[0].frozen() || still_[1].frozen()) return LinkState::frozen;
  if (saturated_ && now - *saturated_ <= kSaturatedShown) return LinkState::saturated;
  if (loss > kTooMuch) return LinkState::lossy;
  if (late_share > kTooMuch) return LinkState::late;
  return LinkState::good;
}

LinkReport LinkHealth::report(HostTime now, const std::optional<LinkClock>& clock) const {
  LinkReport report{.lost = lost_,
                    .late = late_,
                    .doubled = doubled_,
                    .reordered = reordered_,
                    .malformed = malformed_,
                    .restarts = restarts_,
                    .battery_percent = battery_,
                    .estimated = estimated_,
                    .clock = clock};
  if (!received_) {
    report.state = state(now, 0, 0, 0);
    return report;
  }
  now = std::max(now, newest_arrival_);
  const std::int64_t present = bucket_number(now);
  std::int64_t packets = 0;
  std::int64_t lost = 0;
  std::int64_t late = 0;
  std::int64_t samples = 0;
  std::int64_t breaks = 0;
  for (const Bucket& b : buckets_) {
    if (b.number > present) continue;
    const std::int64_t back =
        b.number == std::numeric_limits<std::int64_t>::min() ? kLossBuckets : present - b.number;
    if (back < kLossBuckets) {
      packets += b.packets;
      lost += b.lost;
      late += b.late;
    }
    if (back < kBreakBuckets) breaks += b.breaks;
    if (back >= 1 && back <= kRateBuckets) samples += b.samples;
  }
  report.age = now - newest_arrival_;
  // Packets that a link which is silent owes are missing too, though no later one has shown it yet. Who sees
  // no face, and says so, owes none.
  const Duration silent = now - std::max(newest_arrival_, no_face_.value_or(newest_arrival_));
  if (!estimated_ && silent > kLostAfter)
    lost += std::min<Duration>(silent, kLossBuckets * kBucket) / std::max(packet_period_, kLeastPeriod);
  lost = std::max<std::int64_t>(lost, 0);
  report.loss = packets + lost > 0 ? static_cast<double>(lost) / static_cast<double>(packets + lost) : 0;
  const double late_share = packets > 0 ? static_cast<double>(late) / static_cast<double>(packets) : 0;
  const HostTime end(kBucket * present);
  const HostTime begin = std::max(end - kRateBuckets * kBucket, first_arrival_);
  if (end - begin >= kBucket) report.rate_hz = static_cast<double>(samples) / to_seconds(end - begin);
  report.state = state(now, report.loss, late_share, breaks);
  return report;
}

}  // namespace mien::sensor
