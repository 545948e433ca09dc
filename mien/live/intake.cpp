#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/intake.h"

#include <fmt/format.h>
#include <linux/sock_diag.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>

#include "mien/core/bytes.h"
#include "mien/core/host_port.h"
#include "mien/session/command.h"

namespace mien::live {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;

/// Two seconds of sixty sensors.
constexpr std::size_t kIntakeRingBytes = std::size_t{1} << 21U;
constexpr std::size_t kMaxSourceName = 100;
/// What the system may keep while this thread is busy.
constexpr int kSocketBytes = 1 << 20;

/// Datagrams that a socket had no room for; 0 where the system does not tell.
std::uint64_t dropped_by_kernel(udp::socket& socket) {
  std::array<std::uint32_t, SK_MEMINFO_VARS> memory{};
  socklen_t size = sizeof(memory);
  if (!socket.is_open() ||
      ::getsockopt(socket.native_handle(), SOL_SOCKET, SO_MEMINFO, memory.data(), &size) != 0)
    return 0;
  return memory[SK_MEMINFO_DROPS];
}

struct Head {
  Arrived::Kind kind;
  sensor::Peer peer;
  std::size_t place;  // Of the peer, in the table.
  HostTime arrival;
  std::uint64_t client;
  std::int64_t number;
};

}  // namespace

struct Intake::Port {
  explicit Port(asio::io_context& network) : socket(network) {}
  udp::socket socket;
  udp::endpoint from;
  bool on_every_interface = false;
  Budget budget;
  std::array<std::byte, kMaxDatagram + 1> bytes;
};

Intake::Intake(asio::io_context& network, Clock clock)
    : network_(network), clock_(std::move(clock)), ring_(kIntakeRingBytes) {}

Intake::~Intake() = default;

Result<std::string> Intake::listen(std::string_view address, std::optional<LineCamera> camera) {
  if (address.starts_with("serial:")) return listen_serial(address, std::move(camera));
  const auto bad = [&](std::string what) {
    return fail(ErrorCode::bad_usage, std::move(what), std::string(address),
                "write it as udp://127.0.0.1:5005, udp://0.0.0.0:5005 for the whole network, or "
                "serial:/dev/ttyUSB0");
  };
  std::string_view rest = address;
  if (rest.starts_with("udp://")) rest.remove_prefix(6);
  if (rest.find("://") != std::string_view::npos) return bad("not an address to listen on");
  const auto parsed = parse_host_port(rest);
  if (!parsed) return bad(parsed.error().what);
  if (!parsed->port) return bad("not an address to listen on");
  std::string host(parsed->host);
  if (host.empty() || host == "*") host = "0.0.0.0";
  if (host == "localhost") host = "127.0.0.1";
  boost::system::error_code code;
  const asio::ip::address ip = asio::ip::make_address(host, code);
  if (code) return bad("the host is no IP address of this machine");

  auto port = std::make_unique<Port>(network_);
  const udp::endpoint endpoint(ip, *parsed->port);
  port->socket.open(endpoint.protocol(), code);
  if (!code) port->socket.bind(endpoint, code);
  if (code)
    return fail(ErrorCode::bad_usage, "cannot listen there: " + code.message(), std::string(address),
                code == asio::error::address_in_use
                    ? "another program has that port, another mien live perhaps; give another with --listen"
                    : "name an address of this machine, or 0.0.0.0 for all of them");
  boost::system::error_code ignored;
  port->socket.set_option(asio::socket_base::receive_buffer_size(kSocketBytes), ignored);
  port->socket.non_blocking(true, ignored);
  port->on_every_interface = ip.is_unspecified();
  if (port->on_every_interface) tell_arrivals(port->socket);
  port->budget = {kMaxRatePerPort, clock_()};
  const std::uint16_t bound = port->socket.local_endpoint().port();
  receive(*port);
  ports_.push_back(std::move(port));
  return fmt::format("udp://{}:{}", ip.is_v6() ? "[" + host + "]" : host, bound);
}

Result<void> Intake::listen_only(std::string_view entrance) {
  if (entrance.empty()) {
    entrance_.reset();
    return {};
  }
  const auto refuse = [&](std::string why) {
    return fail(ErrorCode::bad_usage, std::move(why), std::string(entrance.substr(0, 40)),
                "start mien live with --listen for it");
  };
  if (std::ranges::none_of(ports_, &Port::on_every_interface))
    return refuse("no port listens on every interface");
  MIEN_TRY_ASSIGN(UdpEntrance found, UdpEntrance::find(entrance));
  // A port of [::] has both families.
  const auto reaches = [&](const std::unique_ptr<Port>& port) {
    boost::system::error_code code;
    const bool v6 = port->socket.local_endpoint(code).address().is_v6();
    return port->on_every_interface && (v6 || !found.address() || found.address()->is_v4());
  };
  if (std::ranges::none_of(ports_, reaches))
    return refuse("no port of that family listens on every interface");
  entrance_ = std::move(found);
  return {};
}

void Intake::look_up_entrance() {
  if (entrance_) entrance_->look_up();
}

void Intake::receive(Port& port) {
  port.socket.async_wait(udp::socket::wait_read, [this, &port](boost::system::error_code code) {
    if (code == asio::error::operation_aborted) return;
    // All that is there, before the loop looks at anything else.
    for (int more = 0; !code && more < 64; ++more) {
      const auto arrival = receive_datagram(port.socket, port.bytes, port.from);
      if (!arrival) break;
      take(port, *arrival);
    }
    receive(port);
  });
}

void Intake::take(Port& port, const UdpArrival& arrival) {
  const HostTime now = clock_();
  const std::size_t size = arrival.size;
  ++counts_.received;
  if (port.on_every_interface && entrance_ && !entrance_->admits(arrival)) {
    ++counts_.elsewhere;
    return;
  }
  if (size > kMaxDatagram) {
    ++counts_.too_long;
    return;
  }
  auto known = known_.find(port.from);
  const bool is_new = known == known_.end();
  const bool bound = !is_new && known->second->bound.load(std::memory_order_relaxed);
  if ((!is_new && !admit(*known->second, now)) || (!bound && !spend_as_stranger(port.from.address(), now)) ||
      !port.budget.spend(now, kMaxRatePerPort)) {
    ++counts_.too_fast;
    return;
  }
  if (is_new) {
    const std::string host = port.from.address().to_string();
    PeerState* const peer = place_for_another(
        fmt::format("udp://{}:{}", port.from.address().is_v6() ? "[" + host + "]" : host, port.from.port()));
    if (peer == nullptr) {
      ++counts_.too_many;
      return;
    }
    peer->endpoint = port.from;
    peer->budget = {kMaxRatePerPeer - 1, now};
    peer->sent = 1;
    known = known_.emplace(port.from, peer).first;
  }
  PeerState& peer = *known->second;
  peer.port = &port;  // Answers go out where it last came in.
  hand_over(peer, now, std::span(port.bytes).first(size));
}

bool Intake::admit(PeerState& peer, HostTime now) {
  ++peer.sent;
  if (peer.budget.spend(now, kMaxRatePerPeer)) return true;
  ++peer.dropped;
  return false;
}

bool Intake::spend_as_stranger(const asio::ip::address& host, HostTime now) {
  // By its bytes: a text of it would be made anew for every datagram of a flood.
  const auto place = [](const auto& bytes) {
    return std::hash<std::string_view>()(as_text(std::as_bytes(std::span(bytes)))) % kHosts;
  };
  Budget& its = hosts_[host.is_v6() ? place(host.to_v6().to_bytes()) : place(host.to_v4().to_bytes())];
  return its.spend(now, kMaxRatePerHost) && strangers_.spend(now, kMaxRateUnbound);
}

Result<std::string> Intake::listen_serial(std::string_view address, std::optional<LineCamera> camera) {
  MIEN_TRY_ASSIGN(const SerialAddress line, parse_serial_address(address));
  if (std::ranges::any_of(lines_, [&](const auto& l) { return l->status().address == line.source(); }))
    return fail(ErrorCode::bad_usage, "given twice", line.source(), "leave one out");
  PeerState* const peer = place_for_another(line.source());
  if (peer == nullptr) return fail(ErrorCode::bad_usage, "too many lines", line.source());
  const auto on_frame = [this, peer](std::span<const std::byte> frame) { take_frame(*peer, frame); };
  auto queue = camera ? std::make_unique<PayloadSource>(peer->id, clock_, signal_) : nullptr;
  // On an error its place is a stranger's, and the first to go.
  MIEN_TRY_ASSIGN(lines_.emplace_back(), SerialPort::open(
                                             network_, line, on_frame, std::move(camera),
                                             [queue = queue.get()](auto datagram, auto payload) {
                                               queue->hand_over(datagram, payload);
                                             },
                                             clock_));
  if (queue) sources_.emplace_back(std::move(queue), peer->name);
  peer->budget = {kMaxRatePerPeer, clock_()};
  peer->asked_for = true;
  return fmt::format("{}?baud={}", line.source(), line.baud);
}

void Intake::take_frame(PeerState& peer, std::span<const std::byte> frame) {
  const HostTime now = clock_();
  ++counts_.received;
  if (admit(peer, now))
    hand_over(peer, now, frame);
  else
    ++counts_.too_fast;
}

void Intake::hand_over(PeerState& peer, HostTime now, std::span<const std::byte> datagram) {
  peer.newest = now;
  const Head head{
      Arrived::Kind::datagram, peer.id, static_cast<std::size_t>(&peer - peers_.data()), now, 0, 0};
  if (!ring_.put(head, datagram)) {
    ++counts_.overrun;
    return;
  }
  ++peer.handed_over;
  signal_.give();
}

Intake::PeerState* Intake::place_for_another(std::string name) {
  PeerState* place = nullptr;
  const HostTime now = clock_();
  for (PeerState& peer : peers_) {
    if (peer.id == kNobody) {
      place = &peer;
      break;
    }
    if (peer.asked_for || peer.judged.load(std::memory_order_acquire) != peer.handed_over) continue;
    const bool bound = peer.bound.load(std::memory_order_relaxed);
    if (bound && now - peer.newest <= kForget) continue;
    // Strangers before devices, and of both who was silent longest.
    const auto rank = [](const PeerState& one) {
      return std::pair(one.bound.load(std::memory_order_relaxed), one.newest);
    };
    if (place == nullptr || rank(peer) < rank(*place)) place = &peer;
  }
  if (place == nullptr) return nullptr;
  if (place->id != kNobody) {
    known_.erase(place->endpoint);
    ++counts_.evicted;
    name += fmt::format("#{}", met_);
  }
  place->port = nullptr;
  place->name = std::move(name);
  place->newest = now;
  place->sent = place->dropped = 0;
  place->bound = false;
  place->id = met_++;
  return place;
}

Result<PayloadSource*> Intake::add_source(std::string name) {
  // A take tells its sources apart by their text: commands, senders and lines have theirs.
  const bool plain = !name.empty() && name.size() <= kMaxSourceName &&
                     std::ranges::all_of(name, [](char c) { return c > ' ' && c < 0x7F; });
  if (!plain || name == session::kPageSource || name.starts_with("udp://") || name.starts_with("serial:"))
    return fail(ErrorCode::bad_usage, "not a name for a source of the log", plain ? name : "source",
                "such as camera:left");
  if (std::ranges::any_of(peers_, [&](const PeerState& p) { return p.asked_for && p.name == name; }))
    return fail(ErrorCode::bad_usage, "given twice", std::move(name), "leave one out");
  PeerState* const peer = place_for_another(name);
  if (peer == nullptr) return fail(ErrorCode::bad_usage, "too many sources", std::move(name));
  peer->asked_for = true;
  return sources_.emplace_back(std::make_unique<PayloadSource>(peer->id, clock_, signal_), peer->name)
      .queue.get();
}

Intake::Counts Intake::counts() const {
  Counts counts = counts_;
  for (const Source& source : sources_) {
    const PayloadSource::Counts its = source.queue->counts();
    counts.received += its.received;
    counts.too_long += its.too_long;
    counts.payload_overrun += its.overrun;
  }
  for (const auto& port : ports_) counts.kernel_dropped += dropped_by_kernel(port->socket);
  return counts;
}

bool Intake::hears(const asio::ip::address& host, Duration within) const {
  const HostTime now = clock_();
  return std::ranges::any_of(peers_, [&](const PeerState& peer) {
    return peer.port != nullptr && peer.endpoint.address() == host && now - peer.newest <= within;
  });
}

void Intake::fast_senders(std::vector<FastSender>& out) const {
  out.clear();
  for (const PeerState& peer : peers_)
    if (peer.id != kNobody && peer.dropped > 0)
      out.push_back({.peer = peer.id, .source = peer.name, .sent = peer.sent, .dropped = peer.dropped});
}

bool Intake::command(std::uint64_t client, std::int64_t number, std::string_view json_text) {
  const Head head{Arrived::Kind::command, 0, 0, clock_(), client, number};
  if (!ring_.put(head, std::as_bytes(std::span(json_text)))) return false;
  signal_.give();
  return true;
}

void Intake::send(sensor::Peer peer, std::span<const std::byte> datagram) {
  const auto found = std::ranges::find_if(peers_, [&](const PeerState& p) { return p.id == peer; });
  if (found == peers_.end() || found->port == nullptr) return;
  boost::system::error_code ignored;  // Nobody there, or no room: said again when it is due.
  found->port->socket.send_to(asio::buffer(datagram.data(), datagram.size()), found->endpoint, 0, ignored);
}

void Intake::close() {
  boost::system::error_code ignored;
  for (const auto& port : ports_) port->socket.close(ignored);
  for (const auto& line : lines_) line->close();
}

std::vector<SerialPort::Status> Intake::lines() const {
  std::vector<SerialPort::Status> all;
  for (const auto& line : lines_) all.push_back(line->status());
  return all;
}

std::optional<Arrived> Intake::front() {
  if (front_) return front_;
  front_ = front_of_network();
  front_source_ = nullptr;
  if (!front_) front_peer_ = nullptr;
  for (const Source& source : sources_) {
    const std::optional<PayloadSource::Waiting> its = source.queue->front();
    if (!its || (front_ && front_->arrival <= its->arrival)) continue;
    front_ = Arrived{Arrived::Kind::datagram, its->arrival, source.queue->peer(), 0, 0,
                     its->datagram,           its->payload, source.name};
    front_source_ = source.queue.get();
    front_peer_ = nullptr;
  }
  return front_;
}

std::optional<Arrived> Intake::front_of_network() {
  const auto record = ring_.front_of<Head>();
  if (!record) return std::nullopt;
  const auto& [head, bytes] = *record;
  front_peer_ = head.kind == Arrived::Kind::datagram ? &peers_[head.place] : nullptr;
  // Nobody else gets its place, and it no other name, before this datagram is judged.
  const std::string_view source = front_peer_ != nullptr ? front_peer_->name : std::string_view();
  return Arrived{head.kind, head.arrival, head.peer, head.client, head.number, bytes, {}, source};
}

void Intake::release() {
  // Released in that order: who sees that it was judged sees how, and that nobody reads its name any more.
  const bool of_source = front_source_ != nullptr;
  if (front_peer_ != nullptr) front_peer_->judged.fetch_add(1, std::memory_order_release);
  front_peer_ = nullptr;
  front_.reset();
  if (of_source)
    std::exchange(front_source_, nullptr)->release();
  else
    ring_.release();
}

void Intake::judge_bound() {
  if (front_peer_ != nullptr) front_peer_->bound.store(true, std::memory_order_relaxed);
}

}  // namespace mien::live
