#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/intake.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <cstring>

#include "mien/core/host_port.h"

namespace mien::live {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;

/// Two seconds of sixty sensors.
constexpr std::size_t kRingBytes = std::size_t{1} << 21U;
/// What the system may keep while this thread is busy.
constexpr int kSocketBytes = 1 << 20;

struct Head {
  Arrived::Kind kind;
  sensor::Peer peer;
  HostTime arrival;
  std::uint64_t client;
  std::int64_t number;
};

}  // namespace

struct Intake::Port {
  explicit Port(asio::io_context& network) : socket(network) {}
  udp::socket socket;
  udp::endpoint from;
  Budget budget;
  std::array<std::byte, kMaxDatagram + 1> bytes;
};

bool Intake::Budget::spend(HostTime now, double rate) {
  // The clock begins anew when the session does, after its ports were opened.
  tokens = std::min(rate, tokens + rate * to_seconds(std::max(now - refilled, Duration{})));
  refilled = now;
  if (tokens < 1) return false;
  --tokens;
  return true;
}

Intake::Intake(asio::io_context& network, Clock clock)
    : network_(network), clock_(std::move(clock)), ring_(kRingBytes) {}

Intake::~Intake() = default;

Result<std::string> Intake::listen(std::string_view address) {
  if (address.starts_with("serial:")) return listen_serial(address);
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
  port->budget = {kMaxRatePerPort, clock_()};
  const std::uint16_t bound = port->socket.local_endpoint().port();
  receive(*port);
  ports_.push_back(std::move(port));
  return fmt::format("udp://{}:{}", ip.is_v6() ? "[" + host + "]" : host, bound);
}

void Intake::receive(Port& port) {
  port.socket.async_receive_from(
      asio::buffer(port.bytes), port.from, [this, &port](boost::system::error_code code, std::size_t size) {
        if (code == asio::error::operation_aborted) return;
        if (!code) {
          take(port, size);
          // All that is there, before the loop looks at anything else.
          for (int more = 0; more < 64; ++more) {
            size = port.socket.receive_from(asio::buffer(port.bytes), port.from, 0, code);
            if (code) break;
            take(port, size);
          }
        }
        receive(port);
      });
}

void Intake::take(Port& port, std::size_t size) {
  const HostTime now = clock_();
  ++counts_.received;
  if (size > kMaxDatagram) {
    ++counts_.too_long;
    return;
  }
  auto known = known_.find(port.from);
  const bool slow = known == known_.end() || peers_[known->second].budget.spend(now, kMaxRatePerPeer);
  if (!slow || !port.budget.spend(now, kMaxRatePerPort)) {
    ++counts_.too_fast;
    return;
  }
  if (known == known_.end()) {
    const auto place = place_for_another();
    if (!place) {
      ++counts_.too_many;
      return;
    }
    const std::string host = port.from.address().to_string();
    PeerState& peer = peers_[*place];
    peer.endpoint = port.from;
    peer.name =
        fmt::format("udp://{}:{}", port.from.address().is_v6() ? "[" + host + "]" : host, port.from.port());
    peer.budget = {kMaxRatePerPeer - 1, now};
    peer.met = counts_.received;
    met_ = std::max<std::size_t>(met_, *place + 1);
    known = known_.emplace(port.from, *place).first;
  }
  PeerState& peer = peers_[known->second];
  peer.port = &port;  // Answers go out where it last came in.
  hand_over(known->second, now, std::span(port.bytes).first(size));
}

Result<std::string> Intake::listen_serial(std::string_view address) {
  MIEN_TRY_ASSIGN(const SerialAddress line, parse_serial_address(address));
  if (std::ranges::any_of(lines_, [&](const auto& l) { return l->status().address == line.source(); }))
    return fail(ErrorCode::bad_usage, "given twice", line.source(), "leave one out");
  const auto place = place_for_another();
  if (!place) return fail(ErrorCode::bad_usage, "too many lines", line.source());
  MIEN_TRY_ASSIGN(std::unique_ptr<SerialPort> opened,
                  SerialPort::open(network_, line, [this, peer = *place](std::span<const std::byte> frame) {
                    take_frame(peer, frame);
                  }));
  lines_.push_back(std::move(opened));
  PeerState& peer = peers_[*place];
  peer.port = nullptr;
  peer.name = line.source();
  peer.budget = {kMaxRatePerPeer, clock_()};
  peer.vouched = true;  // It was asked for.
  met_ = std::max<std::size_t>(met_, *place + 1);
  return fmt::format("{}?baud={}", line.source(), line.baud);
}

void Intake::take_frame(sensor::Peer peer, std::span<const std::byte> frame) {
  const HostTime now = clock_();
  ++counts_.received;
  if (peers_[peer].budget.spend(now, kMaxRatePerPeer))
    hand_over(peer, now, frame);
  else
    ++counts_.too_fast;
}

void Intake::hand_over(sensor::Peer peer, HostTime now, std::span<const std::byte> datagram) {
  const std::span<std::byte> room = ring_.claim(sizeof(Head) + datagram.size());
  if (room.empty()) {
    ++counts_.overrun;
    return;
  }
  const Head head{Arrived::Kind::datagram, peer, now, 0, 0};
  std::memcpy(room.data(), &head, sizeof(head));
  if (!datagram.empty()) std::memcpy(room.data() + sizeof(head), datagram.data(), datagram.size());
  ++peers_[peer].handed_over;
  ring_.publish();
  signal_.give();
}

/// A free place in the table, or that of whom has to go: the oldest of those who never sent anything that was
/// understood, and of whom nothing is on its way to be.
std::optional<sensor::Peer> Intake::place_for_another() {
  if (met_ < kMaxPeers) return static_cast<sensor::Peer>(met_);
  const PeerState* oldest = nullptr;
  for (const PeerState& peer : peers_) {
    const bool judged = peer.judged.load(std::memory_order_acquire) == peer.handed_over;
    if (!judged || peer.vouched.load(std::memory_order_relaxed)) continue;
    if (oldest == nullptr || peer.met < oldest->met) oldest = &peer;
  }
  if (oldest == nullptr) return std::nullopt;
  known_.erase(oldest->endpoint);
  ++counts_.evicted;
  return static_cast<sensor::Peer>(oldest - peers_.data());
}

Result<PayloadSource*> Intake::add_source(std::string name) {
  for (std::size_t i = 0; i < met_; ++i)
    if (peers_[i].name == name)
      return fail(ErrorCode::bad_usage, "given twice", std::move(name), "leave one out");
  const auto place = place_for_another();
  if (!place) return fail(ErrorCode::bad_usage, "too many sources", std::move(name));
  PeerState& peer = peers_[*place];
  peer.port = nullptr;
  peer.name = std::move(name);
  peer.vouched = true;  // It was asked for.
  met_ = std::max<std::size_t>(met_, *place + 1);
  return sources_.emplace_back(std::make_unique<PayloadSource>(*place, clock_, signal_)).get();
}

Intake::Counts Intake::counts() const {
  Counts counts = counts_;
  for (const auto& source : sources_) {
    const PayloadSource::Counts its = source->counts();
    counts.received += its.received;
    counts.too_long += its.too_long;
    counts.payload_overrun += its.overrun;
  }
  return counts;
}

bool Intake::command(std::uint64_t client, std::int64_t number, std::string_view json) {
  const std::span<std::byte> room = ring_.claim(sizeof(Head) + json.size());
  if (room.empty()) return false;
  const Head head{Arrived::Kind::command, 0, clock_(), client, number};
  std::memcpy(room.data(), &head, sizeof(head));
  std::memcpy(room.data() + sizeof(head), json.data(), json.size());
  ring_.publish();
  signal_.give();
  return true;
}

void Intake::send(sensor::Peer peer, std::span<const std::byte> datagram) {
  if (peer >= met_ || peers_[peer].port == nullptr) return;
  boost::system::error_code ignored;  // Nobody there, or no room: said again when it is due.
  peers_[peer].port->socket.send_to(asio::buffer(datagram.data(), datagram.size()), peers_[peer].endpoint, 0,
                                    ignored);
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
  for (const auto& source : sources_) {
    const std::optional<PayloadSource::Waiting> its = source->front();
    if (!its || (front_ && front_->arrival <= its->arrival)) continue;
    front_ =
        Arrived{Arrived::Kind::datagram, its->arrival, source->peer(), 0, 0, its->datagram, its->payload};
    front_source_ = source.get();
  }
  return front_;
}

std::optional<Arrived> Intake::front_of_network() {
  const std::span<const std::byte> record = ring_.front();
  if (record.empty()) return std::nullopt;
  Head head{};
  std::memcpy(&head, record.data(), sizeof(head));
  return Arrived{head.kind, head.arrival, head.peer, head.client, head.number, record.subspan(sizeof(head)),
                 {}};
}

void Intake::release() {
  // Released in that order: who sees that it was judged sees how, and that nobody reads its name any more.
  const bool of_source = front_source_ != nullptr;
  if (front_ && !of_source && front_->kind == Arrived::Kind::datagram)
    peers_[front_->peer].judged.fetch_add(1, std::memory_order_release);
  front_.reset();
  if (of_source)
    std::exchange(front_source_, nullptr)->release();
  else
    ring_.release();
}

void Intake::vouch(sensor::Peer peer) {
  peers_[peer].vouched.store(true, std::memory_order_relaxed);
}

}  // namespace mien::live
