#pragma once

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
#include "mien/sensor/protocol.h"
#include "mien/sensor/rig.h"
#include "mien/sensor/ticks.h"
#include "mien/session/command.h"
#include "mien/session/drift_watch.h"
#include "mien/session/guide.h"
#include "mien/session/prompt_watch.h"
#include "mien/session/prompter.h"
#include "mien/session/receiver.h"
#include "mien/session/report.h"
#include "mien/session/tracker_set.h"
#include "mien/shaping/shaper.h"
#include "mien/take/take.h"
#include "mien/tracker/tracker.h"

namespace mien::session {

/// The session: devices, clocks, calibration, trackers, shaping. What goes in are the session log's entries
/// and ticks, in order; what comes out are output frames; nothing else has a say, neither the clock on the
/// wall nor a thread. So a replay of the log gives the same bits. Thread: one at a time. No allocation in
/// receive(), due() and tick() once every device has been received, but where a calibration is made or a
/// prompt is over.
class Session final : private SampleConsumer {
 public:
  struct Parts {
    sensor::Rig rig;
    /// One a modality. None: a session that receives, binds and fires ticks; its frames are neutral.
    std::vector<std::unique_ptr<tracker::Tracker>> trackers;
    std::vector<std::unique_ptr<sensor::Protocol>> protocols;
    std::vector<ProtocolReducer> reducers;  ///< Of their payloads; most protocols have none.
    shaping::ShaperSettings shaping;
  };
  /// Errors: Receiver::create's.
  [[nodiscard]] static Result<std::unique_ptr<Session>> create(Parts parts);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session() override = default;

  /// From now on no sound is taken, whatever the settings come to say. A replay has no use for it: what was
  /// not taken is not in the log.
  void take_no_sound() {
    takes_no_sound_ = true;
    receiver_->listen_to_sound(false);
  }

  using Received = Receiver::Received;
  /// One datagram. Fire all that due() gives before it, and again after it.
  /// `payload`: raw, as its device gave it; empty for none (Receiver::receive).
  Received receive(HostTime arrival, Sender sender, std::span<const std::byte> datagram,
                   std::span<const std::byte> payload = {}) {
    return receiver_->receive(arrival, sender, datagram, payload, *this);
  }
  /// The same of a log's entry in a replay: its payload is handed on as the log has it.
  Received receive_logged(HostTime arrival, Sender sender, std::span<const std::byte> datagram,
                          const sensor::Payload& payload) {
    return receiver_->receive_logged(arrival, sender, datagram, payload, *this);
  }

  /// One command of the page, as it goes into the log. Errors: parse_command's; not_found (no such sensor,
  /// version); what the tracker says.
  [[nodiscard]] Result<void> command(HostTime arrival, std::string_view json);

  /// The next frame that is due; ask until there is none.
  [[nodiscard]] std::optional<sensor::FrameTick> due(HostTime now) { return receiver_->due(now); }
  /// When the next frame fires if nothing more arrives.
  [[nodiscard]] std::optional<HostTime> deadline() const { return receiver_->deadline(); }
  /// The answer at a tick: of due() in a live session, of the log in a replay. Valid until the next call.
  const face::OutputFrame& tick(DeviceTime frame, HostTime fired);
  /// How many sensors stood behind the last answer.
  [[nodiscard]] std::size_t sensors_present() const { return sensors_present_; }

  /// Datagrams that devices are due unasked; about ten times a second.
  void heartbeats(HostTime now, std::vector<sensor::Protocol::Outgoing>& out) {
    receiver_->heartbeats(now, out);
  }

  /// Events since the last call, for the take; then forgotten.
  [[nodiscard]] std::vector<take::Event> take_events();
  /// Calibrations in the order made; ids 1, 2, 3, ...
  [[nodiscard]] const std::vector<CalibrationVersion>& versions() const { return versions_; }

  /// For people. Reuses what `out` holds.
  void report(HostTime now, Report& out) const;

  [[nodiscard]] std::uint64_t frames() const { return frames_; }
  /// Of every frame so far, as face::FrameHash has it. The last call before the session ends.
  [[nodiscard]] std::string hash() { return hash_.hex(); }
  [[nodiscard]] const sensor::Rig& rig() const { return receiver_->rig(); }
  [[nodiscard]] std::string_view modality() const { return trackers_.modality(); }
  /// Every sensor's clock model, and the time line of the output grid.
  [[nodiscard]] const sensor::TimeLines& lines() const { return receiver_->lines(); }
  /// The features from which the last frame was estimated (tracker::Tracker::features()); null for none.
  [[nodiscard]] const model::FeatureFrame* features() const { return trackers_.features(); }

 private:
  Session(Parts parts, std::unique_ptr<Receiver> receiver);
  void add(HostTime arrival, const sensor::Sample& sample, std::span<const std::byte> payload) override {
    trackers_.add(arrival, sample, payload);
  }
  void rebound(std::uint16_t sensor, const sensor::DeviceKey& device, bool was_received) override;
  void view_changed(std::uint16_t sensor, const sensor::PictureView& view, bool was_received) override;
  void contested(std::uint16_t sensor, std::string_view accepted, std::string_view other) override;
  void asked_to_recentre(HostTime arrival, std::string_view source) override;
  /// Re-centres from the next frame on.
  void recentre();
  /// What was estimated of the board at this sensor is void.
  void forget(std::uint16_t sensor);
  /// Ends a guided calibration before its time, and tells why; what was in force stays.
  void leave_guide(std::string_view why);
  [[nodiscard]] Result<void> check_versions() const;
  /// The trackers' estimates become the frame.
  void shape(DeviceTime frame);
  void watch_links(DeviceTime frame, HostTime fired);
  /// Of what trackers found of their own accord.
  void follow_calibration(DeviceTime frame, std::span<tracker::CalibrationEvent> events);
  /// Of what the guided calibration that runs has come to.
  void follow_guided(std::span<const tracker::CalibrationEvent> events);
  /// Begins the rest that re-centring asks for; before the tracker's tick.
  void begin_rest(DeviceTime frame);
  /// Re-centres when the rest is over; after the tracker's tick, before shaping.
  void follow_rest(DeviceTime frame, const std::optional<tracker::RestOutcome>& rested);
  /// What Recentre asked for is not done any more: it was of the calibration before.
  void drop_recentring();
  /// Errors: not_found.
  [[nodiscard]] Result<std::uint16_t> sensor_named(std::string_view name) const;
  void follow_recentring(DeviceTime frame);
  /// How certain rotations are, once a second.
  void watch_drift(DeviceTime frame);
  void add_version(DeviceTime frame, std::string_view origin, std::vector<sensor::Score> scores);
  void add_event(std::string kind, DeviceTime begin, DeviceTime end, std::string json = {});

  Result<void> execute(const Calibrate& command);
  Result<void> execute(const CancelCalibration& command);
  Result<void> execute(const UseCalibration& command);
  Result<void> execute(const RestoreCalibration& command);
  Result<void> execute(const Recentre& command);
  Result<void> execute(const Bind& command);
  Result<void> execute(const Hear& command);
  Result<void> execute(const Tap& command);
  Result<void> execute(const Cover& command);
  Result<void> execute(const View& command);
  Result<void> execute(const Shape& command);
  Result<void> execute(const AddPrompt& command);
  Result<void> execute(const Prompting& command);
  Result<void> execute(const GiveConsent& command);
  Result<void> execute(const EndConsent& command);
  Result<void> execute(const Correct& command);
  void follow_prompts(DeviceTime frame);
  void report_prompts(Report::Prompts& out) const;
  void report_certainty(Report::Calibration& out) const;

  std::unique_ptr<Receiver> receiver_;
  TrackerSet trackers_;
  shaping::Shaper shaper_;
  Guide guide_;
  Prompter prompter_;
  PromptWatch prompt_watch_;
  std::vector<std::string> poor_;           // Of the line that was over last.
  bool consented_ = false;                  // Somebody has, and it is not over, ...
  std::optional<Consent> consent_to_tell_;  // ... which the next tick's time is written beside.
  std::vector<DeviceTime> bound_at_;  // By sensor of the rig: the frame before its board, or its view, came.

  std::vector<CalibrationVersion> versions_;
  std::int64_t in_force_ = 0;              // Id; 0: none.
  std::vector<std::string_view> renewed_;  // Whose calibration the guided one that runs has changed.
  bool recentring_ = false;
  std::optional<HostTime> asked_at_;  // The newest re-centring that a datagram asked for, and how many did.
  std::size_t asked_ = 0;
  Duration rest_{};                     // What re-centring waits for first; zero: nothing.
  std::optional<DeviceTime> rest_end_;  // None until it has begun.
  DriftWatch drift_watch_;
  std::vector<std::optional<tracker::SensorCertainty>> certainties_;  // By sensor of the rig.
  std::uint64_t faults_ = 0;                                          // Told.
  std::string_view failure_;
  std::vector<take::Event> events_;

  face::OutputFrame frame_;
  DeviceTime newest_frame_;
  std::uint64_t frames_ = 0;
  std::uint64_t audio_frames_ = 0;  // Of which a shape is from sound.
  bool has_microphone_ = false;     // The rig has a microphone.
  bool takes_no_sound_ = false;     // take_no_sound().
  tracker::TickResult::Hearing hearing_;
  std::size_t sensors_present_ = 0;
  face::FrameHash hash_;
};

}  // namespace mien::session
