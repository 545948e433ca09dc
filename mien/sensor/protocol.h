#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/sensor/payload.h"
#include "mien/sensor/sample.h"

namespace mien::sensor {

/// One sensor of one device, as the wire names it.
struct DeviceKey {
  std::uint64_t device = 0;  ///< A MAC in the low 48 bits, first octet highest.
  std::uint8_t channel = 0;  ///< Which sensor of the board.
  auto operator<=>(const DeviceKey&) const = default;
};

/// "02:4D:49:45:4E:07", and with a channel above 0 "02:4D:49:45:4E:07/1": what rigs bind sensors by.
[[nodiscard]] std::string format_device(const DeviceKey& key);
/// Takes both forms, and a channel 0 written out, in either case. Errors: malformed.
[[nodiscard]] Result<DeviceKey> parse_device(std::string_view text);

/// A decoded sample, before it is known which sensor of the rig its device is.
struct Reading {
  DeviceKey from;
  Sample sample;           ///< `sensor` is not set.
  bool saturated = false;  ///< Some axis stood at the end of its range.
  /// What of the datagram, or of its payload, goes with this sample; stands as long as these do, the call of
  /// Protocol::receive() and what is done with its inbox until the next. Empty: nothing.
  std::span<const std::byte> payload{};
};

/// What a device tells about itself, when it begins.
struct Announcement {
  DeviceKey from;
  std::string site;      ///< The rig's sensor that it sits at, if it knows: "zygomaticus_upper_L".
  std::string firmware;  ///< For people; may be empty.
};

/// What one datagram brought. Reused from datagram to datagram, so that the live path allocates nothing.
struct Inbox {
  struct Battery {
    DeviceKey from;
    std::uint8_t percent = 0;
  };
  /// A pulse on the wire that all nodes share: the same moment on every node's own clock.
  struct Pulse {
    DeviceKey from;
    std::uint32_t index = 0;
    DeviceTime edge;
  };
  std::vector<Reading> readings;
  std::vector<Announcement> announcements;
  std::vector<Battery> batteries;
  std::vector<Pulse> pulses;
  std::optional<DeviceKey> alive;  ///< A device that said nothing but that it is there.
  /// A device that says that it sees no face now, whether it repeats what it told last or tells nothing.
  std::optional<DeviceKey> no_face;
  /// Its sender asks the session to re-centre.
  bool recentre = false;
  std::vector<std::byte> reply;  ///< One datagram for the sender; empty: none.
  /// What a sealed datagram held; empty where it was not sealed. A log keeps this instead of the datagram
  /// (and nothing of refused ones), so that a replay needs no key.
  std::vector<std::byte> opened;

  void clear();
};

/// What became of a datagram.
enum class Verdict : std::uint8_t {
  taken,
  ignored,    ///< Well formed, and nothing that we need (a temperature).
  malformed,  ///< Breaks its protocol's rules.
  refused,    ///< Not authenticated, played again, or of a version that cannot be checked here.
};

/// Where a datagram came from; small numbers that the session gives out. Live and replay may give others, but
/// the same one to the same sender.
using Peer = std::uint32_t;

/// A language that devices speak: datagrams in, readings out, and what must be said back. What receive() puts
/// into the inbox's readings, announcements, batteries, pulses, no_face and recentre is a pure function of
/// the datagrams received so far and their arrivals: live and replay decode alike. What is malformed or
/// refused must leave no trace in it, since no log keeps that. Thread: one at a time.
class Protocol {
 public:
  virtual ~Protocol() = default;
  /// "mien", "slimevr": for people.
  [[nodiscard]] virtual std::string_view name() const = 0;
  /// Whether the content is of this language; says nothing of its being well formed.
  [[nodiscard]] virtual bool recognises(std::span<const std::byte> datagram) const = 0;
  /// The version of a datagram that it recognises, where it is one that it does not know; none for any other.
  /// Of what says its version as our packets do this is done here. A pure function of the bytes.
  [[nodiscard]] virtual std::optional<unsigned> unknown_version(std::span<const std::byte> datagram) const;
  /// Decodes one datagram. Appends to `inbox`. No allocation but for a device's first words. In a protocol
  /// whose datagrams all have payloads one without is malformed.
  virtual Verdict receive([[maybe_unused]] HostTime arrival, [[maybe_unused]] Peer peer,
                          [[maybe_unused]] std::span<const std::byte> datagram,
                          [[maybe_unused]] Inbox& inbox) {
    return Verdict::malformed;
  }
  /// The same of a datagram with a payload beside it: 1 to kMaxPayload bytes, valid during the call and as
  /// Reading::payload. Where the protocol has a Reducer it is the reduction, live and in a replay. In a
  /// protocol without payloads such a datagram is malformed.
  virtual Verdict receive_with_payload([[maybe_unused]] HostTime arrival, [[maybe_unused]] Peer peer,
                                       [[maybe_unused]] std::span<const std::byte> datagram,
                                       [[maybe_unused]] std::span<const std::byte> payload,
                                       [[maybe_unused]] Inbox& inbox) {
    return Verdict::malformed;
  }

  struct Outgoing {
    Peer peer = 0;
    std::vector<std::byte> datagram;
  };
  /// What is due to be said unasked (heartbeats), nothing to devices that only send; to be asked about ten
  /// times a second. Changes nothing that receive() depends on.
  virtual void heartbeats([[maybe_unused]] HostTime now, [[maybe_unused]] std::vector<Outgoing>& out) {}
};

}  // namespace mien::sensor
