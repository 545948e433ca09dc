#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/face/frame_hash.h"
#include "mien/face/output_frame.h"
#include "mien/sensor/link_health.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/rig.h"
#include "mien/sensor/ticks.h"
#include "mien/session/command.h"
#include "mien/session/guide.h"
#include "mien/session/prompter.h"
#include "mien/session/report.h"
#include "mien/session/tap_watch.h"
#include "mien/shaping/shaper.h"
#include "mien/take/take.h"
#include "mien/tracker/tracker.h"

namespace mien::session {

/// The session: devices, clocks, calibration, tracker, shaping. What goes in are the session log's entries
/// and ticks, in order; what comes out are output frames; nothing else has a say, neither the clock on the
/// wall nor a thread. So a replay of the log gives the same bits. Thread: one at a time. No allocation in
/// receive(), due() and tick() once every device has been heard, but where a calibration is made or a prompt
/// is over.
class Session {
 public:
  struct Parts {
    sensor::Rig rig;
    std::unique_ptr<tracker::Tracker> tracker;
    std::vector<std::unique_ptr<sensor::Protocol>> protocols;
    shaping::ShaperSettings shaping;
    /// Told of every change of these settings: for a tracker that has a use for some. May be empty.
    std::function<void(const shaping::ShaperSettings&)> reshape;
  };
  /// A rig that binds no sensor binds virtual nodes, whose ids name their place. Errors: malformed (a binding
  /// of the rig that is no device), bad_usage (two sensors bound to one).
  [[nodiscard]] static Result<std::unique_ptr<Session>> create(Parts parts);

  /// Devices beyond this many are refused.
  static constexpr std::size_t kMaxDevices = 64;

  struct Received {
    sensor::Verdict verdict = sensor::Verdict::ignored;
    std::span<const sensor::Sample> samples;  ///< Bound and taken, until the next call.
    /// What a log should keep: the datagram, or what was sealed in it. Until the next call.
    std::span<const std::byte> log;
    std::span<const std::byte> reply;  ///< For the sender; empty: none. Until the next call.
  };
  /// One datagram. Fire all that due() gives before it, and again after it.
  Received receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram);

  /// One command of the page, as it goes into the log. Errors: parse_command's; not_found (no such sensor,
  /// version); what the tracker says.
  [[nodiscard]] Result<void> command(HostTime arrival, std::string_view json);

  /// The next frame that is due; ask until there is none.
  [[nodiscard]] std::optional<sensor::FrameTick> due(HostTime now) { return ticks_.due(now); }
  /// When the next frame fires if nothing more arrives.
  [[nodiscard]] std::optional<HostTime> deadline() const { return ticks_.deadline(); }
  /// The answer at a tick: of due() in a live session, of the log in a replay. Valid until the next call.
  const face::OutputFrame& tick(DeviceTime frame, HostTime fired);

  /// What is to be said to devices unasked; about ten times a second.
  void say(HostTime now, std::vector<sensor::Protocol::Outgoing>& out);

  /// Events since the last call, for the take; then forgotten.
  [[nodiscard]] std::vector<take::Event> take_events();
  /// Calibrations in the order made; ids 1, 2, 3, ...
  [[nodiscard]] const std::vector<CalibrationVersion>& versions() const { return versions_; }

  /// For people. Reuses what `out` holds.
  void report(HostTime now, Report& out) const;

  [[nodiscard]] std::uint64_t frames() const { return frames_; }
  /// Of every frame so far, as face::FrameHash has it. The last call before the session ends.
  [[nodiscard]] std::string hash() { return hash_.hex(); }
  [[nodiscard]] const sensor::Rig& rig() const { return rig_; }
  [[nodiscard]] std::string_view modality() const { return tracker_->modality(); }

 private:
  struct Device {
    sensor::DeviceKey key;
    std::optional<std::uint16_t> sensor;
    sensor::Peer peer = 0;
    HostTime heard;
    DeviceTime newest;  // Of what was believed.
    std::size_t protocol = 0;
    std::string announces;
  };
  struct Link {
    sensor::LinkHealth health;
    std::optional<HostTime> heard;
    DeviceTime newest;
    std::optional<float> level;
    bool estimated = false;
    bool lost = false;
  };

  explicit Session(Parts parts);
  [[nodiscard]] Result<void> bind_as_rig_says();
  Device* device(const sensor::DeviceKey& key);
  Device* meet(const sensor::DeviceKey& key, sensor::Peer peer, std::size_t protocol, HostTime arrival);
  void bind(std::uint16_t sensor, const sensor::DeviceKey& key);
  /// Nothing that was learned of the board at this place holds.
  void forget(std::uint16_t sensor);
  /// Ends a guided calibration before its time, and tells why; what was in force stays.
  void leave_guide(std::string_view why);
  /// Whether the readings of a device come from there: nobody else is believed about it.
  [[nodiscard]] bool speaks_from(const sensor::DeviceKey& key, sensor::Peer peer) const;
  [[nodiscard]] Result<void> check_versions() const;
  void take_reading(HostTime arrival, sensor::Peer peer, std::size_t protocol,
                    const sensor::Reading& reading);
  void watch_links(DeviceTime frame, HostTime fired);
  void watch_calibration(DeviceTime frame);
  void add_version(DeviceTime frame, std::string_view origin, std::vector<sensor::Score> scores);
  /// The steps that the tracker found and that no event tells of yet.
  [[nodiscard]] std::vector<tracker::PerformedStep> new_steps() const;
  void add_event(std::string kind, DeviceTime begin, DeviceTime end, std::string json = {});
  Result<void> use_version(std::int64_t id);

  Result<void> obey(const Calibrate& command);
  Result<void> obey(const CancelCalibration& command);
  Result<void> obey(const UseCalibration& command);
  Result<void> obey(const RestoreCalibration& command);
  Result<void> obey(const Recentre& command);
  Result<void> obey(const Bind& command);
  Result<void> obey(const Tap& command);
  Result<void> obey(const Shape& command);
  Result<void> obey(const AddPrompt& command);
  Result<void> obey(const Prompting& command);
  void report_prompts(Report::Prompts& out) const;

  sensor::Rig rig_;
  std::unique_ptr<tracker::Tracker> tracker_;
  std::vector<std::unique_ptr<sensor::Protocol>> protocols_;
  shaping::Shaper shaper_;
  std::function<void(const shaping::ShaperSettings&)> reshape_;
  sensor::TickRule ticks_;
  Guide guide_;
  Prompter prompter_;
  TapWatch tap_;

  std::vector<Device> devices_;
  std::vector<Link> links_;           // One a sensor of the rig.
  std::vector<DeviceTime> bound_at_;  // The frame before its board came; beside.
  std::vector<std::pair<sensor::DeviceKey, std::uint16_t>> bound_;  // Whether heard or not.
  sensor::Inbox inbox_;
  std::vector<sensor::Sample> samples_;

  std::vector<CalibrationVersion> versions_;
  std::int64_t in_force_ = 0;                 // Id; 0: none.
  int calibrations_ = 0;                      // As the tracker counts them.
  std::vector<tracker::PerformedStep> told_;  // Found steps that are events already.
  bool recentring_ = false;
  std::string_view failure_;
  std::vector<take::Event> events_;

  face::OutputFrame frame_;
  DeviceTime newest_frame_;
  std::uint64_t frames_ = 0;
  std::uint64_t malformed_ = 0;
  std::uint64_t refused_ = 0;
  face::FrameHash hash_;
};

}  // namespace mien::session
