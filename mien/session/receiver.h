#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/sensor/link_health.h"
#include "mien/sensor/payload.h"
#include "mien/sensor/picture_view.h"
#include "mien/sensor/plausibility.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/rig.h"
#include "mien/sensor/ticks.h"
#include "mien/session/cover_watch.h"
#include "mien/session/report.h"
#include "mien/session/tap_watch.h"

namespace mien::session {

/// Who sent a datagram, as a session knows it.
struct Sender {
  /// `source`: as the log names it, "udp://192.168.1.7:5005"; by it people tell two senders of one id apart,
  /// and choose between them. Valid during the call that it is given to. Empty: cannot be chosen.
  Sender(sensor::Peer its, std::string_view name = {}) : peer(its), source(name) {}
  sensor::Peer peer;
  std::string_view source;
};

/// The senders of a session log, for whoever feeds it to a receiver again: numbered in the order of their
/// first datagrams, as live.
class Peers {
 public:
  /// Its source text stands as long as this does.
  Sender of(const std::string& source) {
    const auto known = peers_.emplace(source, static_cast<sensor::Peer>(peers_.size())).first;
    return {known->second, known->first};
  }

 private:
  std::map<std::string, sensor::Peer> peers_;
};

/// What a Receiver hands on, in the order in which it stood in the log. Of a truth nothing is handed on.
class SampleConsumer {
 public:
  virtual ~SampleConsumer() = default;
  /// A decoded sample of a bound and accepted device; `sample.sensor` is its number in the rig. `payload`:
  /// valid during the call; empty for none.
  virtual void add(HostTime arrival, const sensor::Sample& sample, std::span<const std::byte> payload) = 0;
  /// From here on another device is bound to this sensor: whatever was estimated of the one before is void.
  /// `was_received`: samples of the one before had come.
  virtual void rebound(std::uint16_t sensor, const sensor::DeviceKey& device, bool was_received) = 0;
  /// From here on this camera is seen so. `was_received`: samples of it had come.
  virtual void view_changed(std::uint16_t /*sensor*/, const sensor::PictureView& /*view*/,
                            bool /*was_received*/) {}
  /// Two send as this sensor's device: whose readings are taken, and whose are not. When the other comes, and
  /// when they change places (then after rebound()); not again while both go on. Source texts, valid during
  /// the call.
  virtual void contested(std::uint16_t /*sensor*/, std::string_view /*accepted*/,
                         std::string_view /*other*/) {}
  /// The sender of a datagram asks the session to re-centre. Source text, valid during the call.
  virtual void asked_to_recentre(HostTime /*arrival*/, std::string_view /*source*/) {}
};

/// What became of a sensor's link.
enum class LinkChange : std::uint8_t {
  lost,       ///< Nothing was received for 100 ms (where times are estimated: a second).
  back,       ///< Something is received again.
  face_lost,  ///< It is there, and says that it sees no face.
  face_back,  ///< It sees one again.
};
/// The kind of a session's event that tells it: "sensor_lost", "sensor_back", "face_lost", "face_back".
[[nodiscard]] std::string_view link_change_name(LinkChange change);

/// What reduces the payloads of a protocol's datagrams before they are logged.
struct ProtocolReducer {
  std::string protocol;  ///< As sensor::Protocol::name().
  std::unique_ptr<sensor::Reducer> reducer;
};

/// The one way from a session log's datagrams to samples and frame ticks: protocols, the binding of devices
/// to the rig's sensors, gating of impostors, one set of clock models (TimeLines), the grid's ticks, and the
/// health of every link. Live sessions, replays, solves and virtual performers all receive by it. Knows no
/// modality, socket, thread or clock on the wall: a pure function of the calls. Thread: one at a time. No
/// allocation in receive() and due() once every device has been received.
class Receiver {
 public:
  /// Beyond so many devices and the rig's, whichever is not bound and was silent longest is forgotten.
  static constexpr std::size_t kMaxDevices = 64;

  /// A rig that binds no sensor binds virtual nodes, whose ids name their place (sensor::bindings). Errors:
  /// malformed (a binding of the rig that is no device), bad_usage (two sensors bound to one; a reducer of a
  /// protocol that is not there or has one already, or whose hash is none).
  [[nodiscard]] static Result<std::unique_ptr<Receiver>> create(
      sensor::Rig rig, std::vector<std::unique_ptr<sensor::Protocol>> protocols,
      std::vector<ProtocolReducer> reducers = {});

  struct Received {
    sensor::Verdict verdict = sensor::Verdict::ignored;
    std::span<const sensor::Sample> samples;  ///< Bound and accepted, until the next call.
    /// What a log should keep: the datagram, or what was sealed in it; empty: nothing. Until the next call.
    std::span<const std::byte> log;
    /// What it should keep of the payload: the raw bytes, or the reduction and its reducer's hash. Valid
    /// until the next call, and as long as the payload that was given.
    sensor::Payload payload;
    std::span<const std::byte> reply;  ///< For the sender; empty: none. Until the next call.
  };
  /// One datagram. Take all that due() gives before it, and again after it.
  Received receive(HostTime arrival, Sender sender, std::span<const std::byte> datagram,
                   SampleConsumer& consumer) {
    return receive(arrival, sender, datagram, std::span<const std::byte>(), consumer);
  }
  /// One datagram of a device with a raw payload beside it (empty: none), which is reduced where the
  /// datagram's protocol has a reducer. A payload of more than sensor::kMaxPayload bytes, or one that its
  /// reducer does not take, makes the datagram malformed. Skin rotations of the profile "lab" are refused: a
  /// take's log alone may bring them.
  Received receive(HostTime arrival, Sender sender, std::span<const std::byte> datagram,
                   std::span<const std::byte> payload, SampleConsumer& consumer);
  /// One datagram of a log, its payload as the log has it: raw or reduced, by whatever reducer, it is handed
  /// on as it is. So a replay decodes what the live session decoded.
  Received receive_logged(HostTime arrival, Sender sender, std::span<const std::byte> datagram,
                          const sensor::Payload& payload, SampleConsumer& consumer);

  /// The next frame that is due; ask until there is none.
  [[nodiscard]] std::optional<sensor::FrameTick> due(HostTime now) { return ticks_.due(now); }
  /// When the next frame fires if nothing more arrives.
  [[nodiscard]] std::optional<HostTime> deadline() const { return ticks_.deadline(); }
  /// Every sensor's clock model, and the time line of the output grid.
  [[nodiscard]] const sensor::TimeLines& lines() const { return ticks_.lines(); }

  /// Binds a device to a sensor of the rig; nothing where it is bound so already.
  void bind(std::uint16_t sensor, const sensor::DeviceKey& device, SampleConsumer& consumer);
  /// The next device that is tapped is bound to this sensor of the rig; empty: none any more.
  void bind_by_tap(std::string sensor) { tap_.arm(std::move(sensor)); }
  /// The next camera whose lens is covered is bound to this sensor of the rig (CoverWatch); empty: none any
  /// more.
  void bind_by_cover(std::string sensor) { cover_.arm(std::move(sensor)); }
  /// Changes which part of a camera's pictures is seen, from the next one on; nothing where it is so already.
  /// What is reduced, and the hash of what reduces it, follow. Errors: mismatch (a sensor that is no camera),
  /// sensor::changed_view's; nothing has changed then.
  [[nodiscard]] Result<void> change_view(std::uint16_t sensor, const sensor::PictureViewChange& change,
                                         SampleConsumer& consumer);
  /// Of those who send as this sensor's device the one of this source text is accepted from now on, for all
  /// sensors of its board: until nothing of it is received, or another is chosen. False, and nothing changes,
  /// where none of them has it.
  bool hear(std::uint16_t sensor, std::string_view source, SampleConsumer& consumer);
  /// Whether sound is taken, as it is at first. Else what brings some is ignored, and no log should keep it:
  /// a voice that nobody asked for is nobody's to record. So is, always, sound of a device that is bound to
  /// no sensor of the kind "speech".
  void listen_to_sound(bool on) { listens_ = on; }
  /// The sensor's next samples stand on another clock.
  void forget(std::uint16_t sensor) { ticks_.forget(sensor); }

  /// Datagrams that devices are due unasked (heartbeats); about ten times a second.
  void heartbeats(HostTime now, std::vector<sensor::Protocol::Outgoing>& out);

  /// Calls `changed(sensor, what)` for every sensor that dropped out, sees no face any more, or is back since
  /// the last call, in their order in the rig; twice where both have changed. At each tick, with the time at
  /// which it fired.
  void watch_links(HostTime fired, const std::function<void(std::uint16_t, LinkChange)>& changed);
  /// Whether this sensor of the rig was heard and is not any more, at the last watch_links().
  [[nodiscard]] bool is_lost(std::uint16_t sensor) const { return links_[sensor].lost; }
  /// Whether this sensor of the rig is there and says that it sees no face, at the last watch_links().
  [[nodiscard]] bool has_no_face(std::uint16_t sensor) const {
    return links_[sensor].no_face && !links_[sensor].lost;
  }

  /// Writes what it knows of links, unbound devices and refused datagrams. Reuses what `out` holds.
  void report(HostTime now, Report& out) const;

  /// As it was at the beginning, whatever was bound or seen otherwise since. Any thread.
  [[nodiscard]] const sensor::Rig& rig() const { return rig_; }

 private:
  /// Somebody else who sends a device's readings, and is not accepted as it.
  struct Rival {
    sensor::Peer peer = 0;
    std::string source;
    std::optional<HostTime> received;  // None: nobody.
    sensor::Plausibility plausibility;
  };
  /// Who was accepted as a device before the one that is now, which followed when it was silent.
  struct Former {
    sensor::Peer peer = 0;
    std::string source;
    sensor::Plausibility plausibility;
    HostTime received;
    DeviceTime newest;
    Duration accepted_for{};
  };
  struct Device {
    sensor::DeviceKey key;
    std::optional<std::uint16_t> sensor;
    sensor::Peer peer = 0;  // Whose readings are accepted.
    std::string source;
    sensor::Plausibility plausibility;
    std::array<Rival, 4> rivals;
    bool chosen = false;                       // By a person: nobody else prevails.
    std::optional<HostTime> contested;         // The newest reading of a rival, ...
    std::optional<HostTime> contested_beside;  // ... and of those before the device's own newest.
    std::optional<Former> former;
    HostTime accepted_since;  // The first reading from there, without a pause that lost the place.
    HostTime received;        // The newest accepted reading, ...
    HostTime alive;           // ... and the newest datagram of its board from there.
    bool estimated = false;
    DeviceTime newest;  // Of accepted samples.
    std::size_t protocol = 0;
    std::string announces;
  };
  struct Link {
    sensor::LinkHealth health;
    std::optional<HostTime> received;
    DeviceTime newest;
    std::optional<float> level;
    bool estimated = false;
    bool said_no_face = false;  // Once.
    bool lost = false;
    bool no_face = false;  // Of one that is lost: when it was heard last.
  };

  Receiver(sensor::Rig rig, std::vector<std::unique_ptr<sensor::Protocol>> protocols,
           std::vector<std::unique_ptr<sensor::Reducer>> reducers,
           std::vector<std::pair<sensor::DeviceKey, std::uint16_t>> bound);
  /// The place of the protocol that the datagram is of; that after the last for none.
  [[nodiscard]] std::size_t protocol_of(std::span<const std::byte> datagram) const;
  enum class Origin : std::uint8_t { device, log };
  Received decode(HostTime arrival, Sender sender, std::size_t protocol, std::span<const std::byte> datagram,
                  const sensor::Payload& payload, Origin origin, SampleConsumer& consumer);
  Received reject_malformed(sensor::Peer peer);
  /// Sound that nobody asked for, or of a device that is none of the rig's microphones.
  [[nodiscard]] bool brings_unwanted_sound(const sensor::Inbox& inbox) const;
  [[nodiscard]] const Device* find(const sensor::DeviceKey& key) const;
  [[nodiscard]] Device* find(const sensor::DeviceKey& key);
  /// The device of this key, from now on if it is new.
  Device& meet(const sensor::DeviceKey& key, Sender sender, std::size_t protocol, HostTime arrival);
  /// Whether the readings of a device come from there: nobody else is accepted as it.
  [[nodiscard]] bool speaks_from(const sensor::DeviceKey& key, sensor::Peer peer) const;
  /// Whether who is accepted as this device is still there, so that nobody takes its place.
  [[nodiscard]] static bool is_received(const Device& device, HostTime arrival);
  /// The place of one more who sends as this device; null: none is free.
  [[nodiscard]] static Rival* rival_of(Device& device, HostTime arrival, Sender sender);
  /// What a rival's reading tells. Whether it is accepted from now on: who was so far does not behave as a
  /// sensor does, the rival does, and nobody has chosen.
  bool judge_rival(Device& device, HostTime arrival, Sender sender, const sensor::Sample& sample,
                   SampleConsumer& consumer);
  /// The rival is accepted from now on, and who was so far is its rival.
  void change_places(Device& device, Rival& rival, SampleConsumer& consumer);
  /// Another sender has come to a device whose own was silent.
  static void follow(Device& device, HostTime arrival, Sender sender);
  /// Whether this is who was accepted before, back with its own clock, and trusted for longer.
  [[nodiscard]] static bool returns(const Device& device, HostTime arrival, Sender sender, DeviceTime time);
  void give_back(Device& device, HostTime arrival, SampleConsumer& consumer);
  void take_reading(HostTime arrival, Sender sender, std::size_t protocol, const sensor::Reading& reading,
                    SampleConsumer& consumer);
  /// Counts a datagram that was not taken, where that is for its version.
  void note_version(std::size_t protocol, Sender sender, std::span<const std::byte> datagram);
  void report_senders(HostTime now, const sensor::DeviceKey& key, Report::Link& out) const;

  sensor::Rig rig_;
  std::vector<std::unique_ptr<sensor::Protocol>> protocols_;
  sensor::TickRule ticks_;
  TapWatch tap_;
  CoverWatch cover_;
  std::vector<Device> devices_;
  std::vector<Link> links_;                                         // One a sensor of the rig.
  std::vector<std::optional<sensor::PictureView>> views_;           // One a sensor: of cameras.
  std::vector<std::pair<sensor::DeviceKey, std::uint16_t>> bound_;  // Whether received or not.
  std::vector<std::unique_ptr<sensor::Reducer>> reducers_;          // One a protocol, or null.
  std::vector<std::byte> reduction_;                                // Empty without reducers.
  std::string reduced_by_;  // Its reducer's hash, which a binding that it leads to changes.
  sensor::Inbox inbox_;
  std::vector<sensor::Sample> samples_;
  bool listens_ = true;
  std::vector<Report::UnknownVersion> unknown_versions_;
  std::uint64_t malformed_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace mien::session
