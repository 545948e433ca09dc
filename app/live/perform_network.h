#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "mien/core/error.h"
#include "mien/sensor/seal.h"
#include "mien/virtual/node_group.h"
#include "mien/virtual/stage.h"

namespace mien::app {

/// Whom a performance is for: "udp://HOST:PORT" (our own packets) or "slimevr://HOST:PORT".
struct NetworkTarget {
  virt::NodeLanguage language = virt::NodeLanguage::mien;
  std::string host;  ///< A name or an address; an IPv6 one without its brackets.
  std::uint16_t port = 0;
};
/// Errors: bad_usage.
[[nodiscard]] Result<NetworkTarget> parse_target(const std::string& text);
/// To whom a phone sends: "HOST[:PORT]", Live Link's port where it names none. Errors: bad_usage.
[[nodiscard]] Result<NetworkTarget> parse_phone_target(const std::string& text);

/// Whether the rig has sensors that send of themselves: any but cameras, which are asked.
[[nodiscard]] bool has_senders(const sensor::Rig& rig);

/// When a performance begins that goes out in two ways, each on a thread of its own: boards that send, and
/// cameras that are asked. The cameras say when, once the boards are ready.
struct SharedStart {
  using Clock = std::chrono::steady_clock;
  std::atomic<bool> cameras_on = false;    ///< Pictures can be asked for: what was rendered first is over.
  std::atomic<bool> boards_ready = false;  ///< Their receiver has answered, or is not waited for any longer.
  std::atomic<bool> stopped = false;       ///< One of the two has failed or was stopped: the other ends, too.
  /// Time 0 of the performance, which lies ahead; the clock's epoch until it is known.
  std::atomic<Clock::time_point> begin = Clock::time_point();
};

struct NetworkOptions {
  std::string to;                 ///< As parse_target() takes it.
  std::string phone;              ///< As parse_phone_target() takes it, where the performer has a phone.
  double wait_s = 10;             ///< The performance begins unanswered after this.
  bool loop = false;              ///< Again and again, until it is stopped.
  std::string title = "perform";  ///< Stands before the progress; empty: it shows none, and says nothing.
  /// Asked often, where there is one: true ends the performance, and that is no stop by its user.
  std::function<bool(std::size_t round)> enough;
  /// Where the performer wears cameras, too, which somebody else offers and whose progress is shown: they say
  /// when it begins.
  SharedStart* start = nullptr;
  std::optional<sensor::SealKey> key;  ///< The nodes are paired by it; for our own packets.
  /// Told of each datagram as it leaves, where there is one.
  std::function<void(std::span<const std::byte>)> sent;
};

/// What went out.
struct NetworkSummary {
  std::size_t nodes = 0;
  std::size_t listening = 0;  ///< Nodes that wait for answers; others only speak.
  std::size_t answered = 0;   ///< Nodes that the receiver knew of at the end.
  double performed_s = 0;
  std::size_t rounds = 0;  ///< Times that the motion was begun.
  std::uint64_t packets = 0;
  std::uint64_t refused = 0;  ///< Packets of which the receiver's machine said that nobody listens.
  double latest_ms = 0;       ///< How late the latest packet went out.
  bool stopped = false;       ///< By its user, before the end.

  /// Whether every packet was refused. The system tells it of a packet when the next one is sent, so it says
  /// nothing of each node's last.
  [[nodiscard]] bool nobody_listened() const {
    return answered == 0 && refused > 0 && refused + nodes >= packets;
  }
};

/// Performs in real time, each node through a socket of its own. A receiver that is not there yet is waited
/// for, and told of once; neither that nobody listened nor a stop by Ctrl-C is an error. Errors: those of the
/// stage and the simulation; bad_usage (a target that is none, the profile *lab*, cameras that nobody
/// offers, a phone that was not told to whom it sends, or that a key should seal); not_found (no such host);
/// io.
[[nodiscard]] Result<NetworkSummary> perform_to_network(const virt::StageRequest& request,
                                                        const NetworkOptions& options);
/// The same of a stage that is set.
[[nodiscard]] Result<NetworkSummary> perform_to_network(virt::Stage stage, const NetworkOptions& options);

}  // namespace mien::app
