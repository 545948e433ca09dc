#pragma once

#include <array>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/live/budget.h"
#include "mien/live/byte_ring.h"
#include "mien/live/payload_source.h"
#include "mien/live/serial_port.h"
#include "mien/live/signal.h"
#include "mien/live/udp_arrival.h"
#include "mien/sensor/protocol.h"

namespace mien::live {

/// Something that reached the session, on its way to the tracker's thread.
struct Arrived {
  enum class Kind : std::uint8_t { datagram, command };
  Kind kind = Kind::datagram;
  HostTime arrival;
  sensor::Peer peer = 0;     ///< Of a datagram.
  std::uint64_t client = 0;  ///< Of a command, and its own number, for the reply.
  std::int64_t number = 0;
  std::span<const std::byte> bytes;
  std::span<const std::byte> payload;  ///< Beside a datagram of a source; empty: none.
  /// Of a datagram, its sender's text: "udp://192.168.1.7:5005", "serial:/dev/ttyUSB0"; with "#" and its
  /// number where another had its place before, so that in a log each sender has a name of its own.
  std::string_view source;
};

/// The ports that devices send to: stamps each datagram with its arrival, holds every sender to a rate, and
/// hands over. A serial line is one sender, and its frames are datagrams. What is too much, too long or from
/// too many is dropped and counted. A sender is *bound* once a reading of it was accepted for a sensor of the
/// rig; all that are not share a budget, so that strangers take nothing from devices, and when the table of
/// senders is full, the one of them that was silent longest gives its place to the next. A bound sender gives
/// it only after kForget of silence. Network thread, but where said otherwise.
class Intake {
 public:
  /// Datagrams a second. No device of ours sends more than 300.
  static constexpr double kMaxRatePerPeer = 1000;
  static constexpr double kMaxRatePerPort = 10000;
  /// Of senders that are not bound: of one address, whatever its ports, ...
  static constexpr double kMaxRatePerHost = 1500;
  /// ... and all together: more would delay the devices' own on their way to the tracker.
  static constexpr double kMaxRateUnbound = 3000;
  static constexpr std::size_t kMaxPeers = 256;
  /// A bound sender that was silent for so long gives its place to another where there is no other.
  static constexpr Duration kForget = std::chrono::seconds(10);
  /// Longer datagrams cannot be devices': a network's frame has no more.
  static constexpr std::size_t kMaxDatagram = PayloadSource::kMaxDatagram;

  using Clock = std::function<HostTime()>;
  Intake(boost::asio::io_context& network, Clock clock);
  ~Intake();

  /// Listens on udp://HOST:PORT; port 0 takes any. Broadcasts are heard. Or on serial:DEVICE[?baud=RATE].
  /// `camera`: whose pictures come where the address is a serial line and a camera speaks on it; before the
  /// tracker's thread begins. Returns the address as text with its port or rate. Errors: bad_usage (not an
  /// address, taken), not_found.
  [[nodiscard]] Result<std::string> listen(std::string_view address,
                                           std::optional<LineCamera> camera = std::nullopt);
  /// From now on the ports on every interface (0.0.0.0, [::]) receive only what comes in there: an interface
  /// ("wlan0") or an address of this machine; empty: all again. Nothing is bound anew, so nobody there loses
  /// a datagram. Errors: bad_usage (neither is here; no port listens on every interface, or none of that
  /// family); the entrance is then as before.
  [[nodiscard]] Result<void> listen_only(std::string_view entrance);
  /// Whether something from this address came in within so long, whoever there sent it.
  [[nodiscard]] bool hears(const boost::asio::ip::address& host, Duration within) const;
  /// Where the ports on every interface are narrowed to; empty: they are not.
  [[nodiscard]] std::string entrance() const { return entrance_ ? entrance_->name() : std::string(); }
  /// Interfaces come and go: about once a second.
  void look_up_entrance();
  /// A device inside this program, whose source text in the log is `name` ("camera:left"). Before the
  /// tracker's thread begins; it lives as long as this. Errors: bad_usage (too many, a name that is taken, is
  /// no plain ASCII of at most 100 letters, or means something else in a log).
  [[nodiscard]] Result<PayloadSource*> add_source(std::string name);
  /// As if it had been received; for commands of the page. False: no room.
  bool command(std::uint64_t client, std::int64_t number, std::string_view json_text);
  /// To where a peer's datagrams come from. On serial lines nothing is said.
  void send(sensor::Peer peer, std::span<const std::byte> datagram);
  void close();
  /// How the serial lines are, in the order in which they were asked for.
  [[nodiscard]] std::vector<SerialPort::Status> lines() const;

  // Tracker's thread.
  /// The oldest of ports, lines, commands and sources, valid until release() and the same until then; none
  /// when all is taken.
  [[nodiscard]] std::optional<Arrived> front();
  void release();
  /// A reading of the datagram that front() gave was accepted for a sensor of the rig: its sender is bound,
  /// and stays so. Before release().
  void judge_bound();
  [[nodiscard]] Signal& signal() { return signal_; }

  struct Counts {
    std::uint64_t received = 0;
    std::uint64_t too_fast = 0;  ///< Beyond a peer's, a host's, the strangers' or a port's rate.
    std::uint64_t too_long = 0;
    std::uint64_t elsewhere = 0;        ///< Came in where listen_only() does not let them.
    std::uint64_t too_many = 0;         ///< Of a peer beyond kMaxPeers, when none can be forgotten.
    std::uint64_t evicted = 0;          ///< Peers, not datagrams: forgotten for others.
    std::uint64_t kernel_dropped = 0;   ///< Before they came here: this thread was too far behind.
    std::uint64_t overrun = 0;          ///< The tracker was too far behind.
    std::uint64_t payload_overrun = 0;  ///< The same of datagrams of sources, with their payloads.
  };
  [[nodiscard]] Counts counts() const;

  /// One who sent more than kMaxRatePerPeer, of which the rest was dropped.
  struct FastSender {
    sensor::Peer peer = 0;      ///< Nobody else's, ever.
    std::string_view source;    ///< As Arrived has it, until the network goes on.
    std::uint64_t sent = 0;     ///< Datagrams of this sender that came, ...
    std::uint64_t dropped = 0;  ///< ... and those beyond its rate.
  };
  /// All who ever did and still have their place. Reuses what `out` holds.
  void fast_senders(std::vector<FastSender>& out) const;

 private:
  struct Port;
  /// A place in the table of senders, and who has it.
  struct PeerState {
    sensor::Peer id = kNobody;  // Never given to another.
    boost::asio::ip::udp::endpoint endpoint;
    Port* port = nullptr;  // None: a serial line.
    std::string name;
    Budget budget;
    HostTime newest;                        // Arrival.
    std::uint64_t sent = 0;                 // As FastSender has it, ...
    std::uint64_t dropped = 0;              // ... and this.
    std::uint64_t handed_over = 0;          // Datagrams, ...
    std::atomic<std::uint64_t> judged = 0;  // ... and how many of them the tracker's thread is done with.
    bool asked_for = false;                 // A line, a source: it keeps its place.
    std::atomic<bool> bound = false;
  };
  static constexpr sensor::Peer kNobody = ~sensor::Peer{0};
  /// Budgets of addresses, by their hash: those that share one are few.
  static constexpr std::size_t kHosts = 4096;
  /// A place for a new sender of this name, which is numbered where the place was another's; null: none.
  PeerState* place_for_another(std::string name);
  /// Counts a datagram of this sender, and whether its own rate lets it in.
  [[nodiscard]] static bool admit(PeerState& peer, HostTime now);
  [[nodiscard]] bool spend_as_stranger(const boost::asio::ip::address& host, HostTime now);
  void receive(Port& port);
  void take(Port& port, const UdpArrival& arrival);
  Result<std::string> listen_serial(std::string_view address, std::optional<LineCamera> camera);
  [[nodiscard]] std::optional<Arrived> front_of_network();
  void take_frame(PeerState& peer, std::span<const std::byte> frame);
  void hand_over(PeerState& peer, HostTime now, std::span<const std::byte> datagram);

  boost::asio::io_context& network_;
  Clock clock_;
  ByteRing ring_;
  Signal signal_;
  std::vector<std::unique_ptr<Port>> ports_;
  std::optional<UdpEntrance> entrance_;
  std::vector<std::unique_ptr<SerialPort>> lines_;
  struct Source {
    std::unique_ptr<PayloadSource> queue;
    const std::string& name;  // Of its place in the table, which it keeps.
  };
  std::vector<Source> sources_;
  // A place is given to another only when all datagrams of the one before were judged.
  std::array<PeerState, kMaxPeers> peers_;
  sensor::Peer met_ = 0;  // Senders so far.
  Budget strangers_{.tokens = kMaxRateUnbound};
  std::vector<Budget> hosts_{kHosts, Budget{.tokens = kMaxRatePerHost}};
  // Tracker's thread: what front() gave, the place of its sender, and of which source; null: of the network
  // or the page.
  std::optional<Arrived> front_;
  PeerState* front_peer_ = nullptr;
  PayloadSource* front_source_ = nullptr;
  /// By where they send from, whatever port they send to: as a replay tells them apart.
  std::map<boost::asio::ip::udp::endpoint, PeerState*> known_;
  Counts counts_;
};

}  // namespace mien::live
