#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "mien/core/time.h"
#include "mien/sensor/sample.h"

namespace mien::sensor {

/// What a person is told of one sensor's link, the gravest that holds (docs/reference/links.md).
enum class LinkState : std::uint8_t {
  unbound,    ///< No device belongs to the sensor: reported by the session, never by LinkHealth.
  silent,     ///< Bound, and nothing was ever received.
  good,       ///< Fresh, whole, in time, alive. Never of a link that receives nothing.
  lossy,      ///< More than 5 % of the packets of the last seconds never came.
  late,       ///< More than 5 % came so late that they missed their frame: a slow radio, or bursts.
  lost,       ///< Nothing for 100 ms (where times are estimated: a second).
  frozen,     ///< Packets are valid, and what they carry has not changed at all for half a second.
  saturated,  ///< Some axis stood at the end of its range in the last half second.
  unchanged,  ///< Times are estimated and nothing came for a moment: such boards send only what changes.
  restarted,  ///< The board began anew in the last seconds: its time or its sequence ran back.
  duplicate,  ///< Two devices send with one id.
  no_face,    ///< The device is there, and says that it sees no face.
};
/// As the page's protocol spells it: "good".
[[nodiscard]] std::string_view link_state_name(LinkState state);

/// What the session's clock model knows of the device, handed through to the report.
struct LinkClock {
  Duration offset{};       ///< Host time less device time, now.
  double drift_ppm = 0;    ///< Of the offset; positive: the device's clock loses.
  Duration uncertainty{};  ///< Standard deviation of the offset.
  bool operator==(const LinkClock&) const = default;
};

struct LinkReport {
  LinkState state = LinkState::silent;
  std::optional<Duration> age;  ///< Since the newest sample's arrival, >= 0; none before the first.
  double rate_hz = 0;         ///< Samples a second that arrived, over the last two seconds; 0 while unknown.
  std::uint64_t lost = 0;     ///< Packets missing from the sequence that have not come since.
  std::uint64_t late = 0;     ///< Packets that came more than 25 ms behind the earliest of their kind.
  std::uint64_t doubled = 0;  ///< Packets that came again.
  std::uint64_t reordered = 0;  ///< Packets that came after a later one.
  std::uint64_t malformed = 0;  ///< Datagrams that broke their protocol's rules.
  std::uint64_t restarts = 0;   ///< Times that the device's time line or sequence broke.
  double loss = 0;              ///< Share of the packets of the last five seconds that is missing, 0 to 1.
  std::optional<std::uint8_t> battery_percent;  ///< 0 to 100.
  bool estimated = false;                       ///< The wire carries no device time.
  std::optional<LinkClock> clock;
};

struct LinkSettings {
  /// How long a sensor whose board still sends other packets may be without a sample before it is `lost`;
  /// only where times are estimated. Raising it trusts a board whose sensor may have died; lowering it
  /// reports that sooner, down to a second: below, it changes nothing, as such sensors are `lost` no sooner.
  Duration unchanged_for = std::chrono::seconds(1);
};

/// State and counters of one sensor's link, from sequence numbers, device times, arrivals and data. A pure
/// function of the calls, in the order of arrival. No allocation. Cost: add O(1), report O(20). About 9 KB.
///
/// How it tells apart: a packet continues a *line* when its device time and its sequence number both go on
/// plausibly from the line's newest packet. One that does not begins a line; the last line is remembered. A
/// board that restarted leaves its old line for good; two devices with one id go back and forth, or send one
/// sequence number with two device times.
class LinkHealth {
 public:
  explicit LinkHealth(const LinkSettings& settings = {}) : settings_(settings) {}

  /// One decoded sample. Samples of one packet share sequence and arrival, and their times rise, but for the
  /// parts of one reading (a face's weights, which no sample holds all): their time is one, they come once
  /// each and in one order, and count as one sample. `saturated`: some axis stood at the end of its range.
  void add(HostTime arrival, const Sample& sample, bool saturated);
  /// A datagram of this device that broke its protocol's rules.
  void add_malformed() { ++malformed_; }
  /// The board sent something that is no sample.
  void add_alive(HostTime arrival) { alive_ = arrival; }
  /// The device says that it sees no face. Samples of the same arrival are what it repeats, to be added
  /// after; one of a later arrival takes it back.
  void add_no_face(HostTime arrival);
  /// Whether the device said so within the last second, and nothing else is received: for more than 100 ms it
  /// has said it, or no sample has come, if ever one did.
  [[nodiscard]] bool sees_no_face(HostTime now) const;
  /// 0 to 100; more is taken as 100.
  void set_battery(std::uint8_t percent) { battery_ = percent > 100 ? std::uint8_t{100} : percent; }

  /// `now` is not before the newest arrival (if it is, it counts as that). `clock`: none while unknown.
  [[nodiscard]] LinkReport report(HostTime now, const std::optional<LinkClock>& clock) const;

 private:
  /// Packets that are remembered one by one: more than a second of one-sample packets at 240 Hz.
  static constexpr std::size_t kRemembered = 256;
  static constexpr std::size_t kBuckets = 24;

  struct Remembered {
    std::uint32_t sequence = 0;
    bool came = false;
    DeviceTime time;  // Of the packet's first sample.
  };
  struct Line {
    bool begun = false;
    std::uint32_t newest = 0;
    DeviceTime time;  // Of the newest packet's first sample.
    HostTime arrival;
    std::array<Remembered, kRemembered> packets{};
  };
  struct Bucket {
    std::int64_t number = INT64_MIN;  // Quarters of a second of host time.
    std::int64_t packets = 0;
    std::int64_t samples = 0;
    std::int64_t lost = 0;  // May fall below 0, where a packet of an earlier bucket came after all.
    std::int64_t late = 0;
    std::int64_t breaks = 0;  // A line was changed, or one number came with two times.
  };
  enum class News : std::uint8_t { forward, reordered, doubled, stranger };

  [[nodiscard]] static bool continues(const Line& line, const Sample& sample, HostTime arrival);
  [[nodiscard]] Line& line_of(const Sample& sample, HostTime arrival);
  void begin_packet(HostTime arrival, const Sample& sample);
  [[nodiscard]] News place(Line& line, const Sample& sample, HostTime arrival);
  void judge_lateness(HostTime arrival, const Sample& sample);
  void judge_change(const Sample& sample);
  /// The same of the reading in parts that is complete, if there is one.
  void judge_parts();
  void forget_data();
  Bucket& bucket(HostTime arrival);
  [[nodiscard]] LinkState state(HostTime now, double loss, double late_share, std::int64_t breaks) const;

  LinkSettings settings_;
  std::array<Line, 2> lines_;
  std::size_t current_ = 0;
  std::array<Bucket, kBuckets> buckets_{};

  // The packet that is being added.
  std::uint32_t packet_sequence_ = 0;
  HostTime packet_arrival_;
  DeviceTime packet_time_;  // Of its newest sample.
  std::uint32_t packet_part_ = 0;
  std::optional<std::uint32_t> parts_;  // What its parts hold, mixed.
  News packet_news_ = News::forward;

  bool received_ = false;
  bool estimated_ = false;
  HostTime first_arrival_;
  HostTime newest_arrival_;
  std::optional<HostTime> alive_;
  std::optional<HostTime> no_face_;  // The newest saying, ...
  HostTime no_face_since_;           // ... and the first since a sample showed a face.
  std::optional<HostTime> saturated_;
  std::optional<HostTime> restarted_;
  std::optional<std::uint8_t> battery_;

  // Arrival less device time of the earliest packet: of the present half minute and of the one before.
  std::int64_t least_begun_ = 0;
  std::optional<Duration> least_;
  std::optional<Duration> least_before_;
  Duration packet_period_ = std::chrono::milliseconds(16);  // Smoothed, from the sequence and device times.

  // When each half of the values last changed (raw axes: gyroscope, accelerometer), and samples since.
  struct Stillness {
    std::array<float, kMaxSampleValues> values{};
    std::uint8_t count = 0;
    DeviceTime since;
    DeviceTime newest;
    std::uint32_t samples = 0;
    void add(std::span<const float> now, DeviceTime time);
    [[nodiscard]] bool frozen() const;
  };
  std::array<Stillness, 2> still_;

  std::uint64_t lost_ = 0;
  std::uint64_t late_ = 0;
  std::uint64_t doubled_ = 0;
  std::uint64_t reordered_ = 0;
  std::uint64_t malformed_ = 0;
  std::uint64_t restarts_ = 0;
};

}  // namespace mien::sensor
