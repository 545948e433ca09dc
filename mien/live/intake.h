#pragma once

#include <array>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/live/byte_ring.h"
#include "mien/live/payload_source.h"
#include "mien/live/serial_port.h"
#include "mien/live/signal.h"
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
};

/// The ports that devices send to: stamps each datagram with its arrival, holds every sender to a rate, and
/// hands over. A serial line is one sender, and its frames are datagrams. What is too much, too long or from
/// too many is dropped and counted. When the table of senders is full, the oldest that never said anything
/// that was understood gives its place to the next: addresses that somebody invents keep no device out.
/// Network thread, but where said otherwise.
class Intake {
 public:
  /// No device of ours sends more than 300 a second.
  static constexpr double kMaxRatePerPeer = 1000;
  static constexpr double kMaxRatePerPort = 10000;
  static constexpr std::size_t kMaxPeers = 256;
  /// Longer datagrams cannot be devices': a network's frame has no more.
  static constexpr std::size_t kMaxDatagram = PayloadSource::kMaxDatagram;

  using Clock = std::function<HostTime()>;
  Intake(boost::asio::io_context& network, Clock clock);
  ~Intake();

  /// Listens on udp://HOST:PORT; port 0 takes any. Broadcasts are heard. Or on serial:DEVICE[?baud=RATE].
  /// Returns the address as text with its port or rate. Errors: bad_usage (not an address, taken), not_found.
  [[nodiscard]] Result<std::string> listen(std::string_view address);
  /// A device inside this program, whose source text in the log is `name` ("camera:left"). Before the
  /// tracker's thread begins; it lives as long as this. Errors: bad_usage (too many, a name that is taken).
  [[nodiscard]] Result<PayloadSource*> add_source(std::string name);
  /// As if it had been received; for commands of the page. False: no room.
  bool command(std::uint64_t client, std::int64_t number, std::string_view json);
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
  /// A peer said something that was understood: it is not forgotten. Before release(), of the oldest's.
  void vouch(sensor::Peer peer);
  [[nodiscard]] Signal& signal() { return signal_; }

  /// Source text of a peer: "udp://192.168.1.7:5005", "serial:/dev/ttyUSB0". Any thread, of one that was
  /// vouched for.
  [[nodiscard]] const std::string& peer_name(sensor::Peer peer) const { return peers_[peer].name; }

  struct Counts {
    std::uint64_t received = 0;
    std::uint64_t too_fast = 0;  ///< Beyond a peer's or a port's rate.
    std::uint64_t too_long = 0;
    std::uint64_t too_many = 0;         ///< Of a peer beyond kMaxPeers, when none can be forgotten.
    std::uint64_t evicted = 0;          ///< Peers, not datagrams: forgotten for others.
    std::uint64_t overrun = 0;          ///< The tracker was too far behind.
    std::uint64_t payload_overrun = 0;  ///< The same of datagrams of sources, with their payloads.
  };
  [[nodiscard]] Counts counts() const;

 private:
  struct Port;
  struct Budget {
    double tokens = 0;
    HostTime refilled;
    [[nodiscard]] bool spend(HostTime now, double rate);
  };
  struct PeerState {
    boost::asio::ip::udp::endpoint endpoint;
    Port* port = nullptr;  // None: a serial line.
    std::string name;
    Budget budget;
    std::uint64_t met = 0;                  // Lower: earlier.
    std::uint64_t handed_over = 0;          // Datagrams, ...
    std::atomic<std::uint64_t> judged = 0;  // ... and how many of them the tracker's thread is done with.
    std::atomic<bool> vouched = false;
  };
  std::optional<sensor::Peer> place_for_another();
  void receive(Port& port);
  void take(Port& port, std::size_t size);
  Result<std::string> listen_serial(std::string_view address);
  [[nodiscard]] std::optional<Arrived> front_of_network();
  void take_frame(sensor::Peer peer, std::span<const std::byte> frame);
  void hand_over(sensor::Peer peer, HostTime now, std::span<const std::byte> datagram);

  boost::asio::io_context& network_;
  Clock clock_;
  ByteRing ring_;
  Signal signal_;
  std::vector<std::unique_ptr<Port>> ports_;
  std::vector<std::unique_ptr<SerialPort>> lines_;
  std::vector<std::unique_ptr<PayloadSource>> sources_;
  // Names are written before a peer's first datagram is handed over, and again only for another peer when all
  // of the first's were judged and none was understood: what is in a log has its name for ever.
  std::array<PeerState, kMaxPeers> peers_;
  std::size_t met_ = 0;  // So many of these places were given out.
  // Tracker's thread: what front() gave, and of which source; null: of the network or the page.
  std::optional<Arrived> front_;
  PayloadSource* front_source_ = nullptr;
  /// By where they send from, whatever port they send to: as a replay tells them apart.
  std::map<boost::asio::ip::udp::endpoint, sensor::Peer> known_;
  Counts counts_;
};

}  // namespace mien::live
