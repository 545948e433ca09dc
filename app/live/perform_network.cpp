#include "app/live/perform_network.h"

#include <fmt/format.h>

#include <utility>
// Asio 1.74 needs <utility> before itself.
#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "app/command.h"
#include "mien/core/host_port.h"
#include "mien/phone/live_link.h"
#include "mien/sink/live_link.h"
#include "mien/virtual/headset/worn_headset.h"

namespace mien::app {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using Code = boost::system::error_code;

/// The simulation runs this far ahead, so that no hiccup of the machine makes a packet late.
constexpr double kAheadS = 0.5;
/// When one node was answered the others get this long.
constexpr Duration kOthersAnswer = std::chrono::seconds(1);
/// How often a stop is asked for.
constexpr Duration kLookUp = std::chrono::milliseconds(20);

/// One node's way to the receiver.
struct Line {
  explicit Line(asio::io_context& io) : socket(io) {}
  udp::socket socket;
  bool is_phone = false;
  std::array<std::byte, 2048> received{};
};

bool speaks_as_phone(const virt::Node& node) {
  return node.device() == phone::kLiveLinkDevice;
}

/// Nodes, sockets and the one clock: what happens when.
class Broadcast {
 public:
  Broadcast(virt::NodeGroup& nodes, const NetworkOptions& options)
      : nodes_(nodes), options_(options), timer_(io_) {}

  /// `phone`: where there is one among the nodes.
  Result<void> open(const NetworkTarget& target, const std::optional<NetworkTarget>& phone);
  Result<NetworkSummary> run();

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] HostTime now() const { return HostTime(Clock::now() - opened_); }
  [[nodiscard]] std::size_t answered();
  [[nodiscard]] Result<udp::endpoint> look_up(const NetworkTarget& target, const std::string& name);
  /// As people wrote it.
  [[nodiscard]] std::string receiver_of(const Line& line) const {
    return line.is_phone ? "--phone " + options_.phone : options_.to;
  }
  void listen(std::size_t node);
  void refused(const Line& line);
  Result<void> send_due();
  Result<bool> wait_for_an_answer(const Progress& progress);
  Result<std::optional<HostTime>> agree_on_start(const Progress& progress);
  Result<void> simulate_ahead(HostTime at);
  void sleep_until(HostTime time);

  virt::NodeGroup& nodes_;
  const NetworkOptions& options_;
  Clock::time_point opened_ = Clock::now();
  asio::io_context io_;
  asio::steady_timer timer_;
  std::vector<std::unique_ptr<Line>> lines_;
  std::optional<HostTime> start_;
  std::set<std::string> told_;  // Of receivers that nobody listens there.
  NetworkSummary summary_;
};

Result<udp::endpoint> Broadcast::look_up(const NetworkTarget& target, const std::string& name) {
  Code code;
  udp::resolver resolver(io_);
  const auto found = resolver.resolve(target.host, std::to_string(target.port), code);
  if (code || found.empty())
    return fail(ErrorCode::not_found, code ? code.message() : "no such host", name,
                "name a host that this machine can reach");
  return found.begin()->endpoint();
}

Result<void> Broadcast::open(const NetworkTarget& target, const std::optional<NetworkTarget>& phone) {
  MIEN_TRY_ASSIGN(const udp::endpoint boards, look_up(target, options_.to));
  udp::endpoint phones;
  if (phone) {
    MIEN_TRY_ASSIGN(phones, look_up(*phone, "--phone " + options_.phone));
  }
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    Line& line = *lines_.emplace_back(std::make_unique<Line>(io_));
    line.is_phone = speaks_as_phone(nodes_[n]);
    const udp::endpoint& endpoint = line.is_phone ? phones : boards;
    Code code;
    line.socket.open(endpoint.protocol(), code);
    // Connected, so that only the receiver is heard, and so that its machine may say that nobody listens.
    if (!code) line.socket.connect(endpoint, code);
    if (code) return fail(ErrorCode::io, code.message(), receiver_of(line));
    listen(n);
  }
  return {};
}

std::size_t Broadcast::answered() {
  std::size_t count = 0;
  for (std::size_t n = 0; n < nodes_.size(); ++n) count += nodes_[n].answered() ? 1 : 0;
  return count;
}

void Broadcast::listen(std::size_t node) {
  Line& line = *lines_[node];
  line.socket.async_receive(asio::buffer(line.received),
                            [this, node, &line](const Code& code, std::size_t size) {
                              if (code == asio::error::operation_aborted) return;
                              if (code == asio::error::connection_refused) refused(line);
                              if (!code) nodes_[node].receive(now(), std::span(line.received).first(size));
                              listen(node);
                            });
}

void Broadcast::refused(const Line& line) {
  ++summary_.refused;
  const std::string receiver = receiver_of(line);
  if (!told_.insert(receiver).second || (options_.title.empty() && options_.start == nullptr)) return;
  clear_progress();
  const bool left = !line.is_phone && answered() > 0;
  fmt::print(stderr, "mien: {}: {}; performing all the same ({})\n", receiver,
             left ? "the receiver listens no more" : "nobody listens there",
             line.is_phone ? "a session hears phones with mien live --listen livelink://0.0.0.0 --phone truth"
                           : "the calibration comes once, at the beginning: start mien live first");
}

Result<void> Broadcast::send_due() {
  const HostTime at = now();
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    for (;;) {
      const HostTime due = nodes_[n].due();
      const auto datagram = nodes_[n].next_datagram(at);
      if (!datagram) break;
      Code code;
      Line& line = *lines_[n];
      line.socket.send(asio::buffer(*datagram), 0, code);
      if (code == asio::error::connection_refused) {
        // That was said of an earlier one; this one has not left yet.
        refused(line);
        line.socket.send(asio::buffer(*datagram), 0, code);
      }
      if (code && code != asio::error::connection_refused)
        return fail(ErrorCode::io, code.message(), receiver_of(line));
      ++summary_.packets;
      if (options_.sent) options_.sent(*datagram);
      if (start_) summary_.latest_ms = std::max(summary_.latest_ms, 1e3 * to_seconds(now() - due));
    }
  }
  return {};
}

void Broadcast::sleep_until(HostTime time) {
  timer_.expires_at(opened_ + time.time_since_epoch());
  timer_.async_wait([](const Code&) {});
  io_.restart();
  io_.run_one();
  // Where a datagram ended the wait: else the next wait would end at once, by this one being cancelled.
  timer_.cancel();
  io_.poll();
}

/// False when its user would not wait.
Result<bool> Broadcast::wait_for_an_answer(const Progress& progress) {
  const Duration patience = from_seconds(options_.wait_s);
  std::optional<HostTime> since, first_answer;  // Of the wait: while pictures are rendered nobody is late.
  bool said = false;
  for (;;) {
    MIEN_TRY(send_due());
    const HostTime at = now();
    const std::size_t count = answered();
    if (!since && (options_.start == nullptr || options_.start->cameras_on)) since = at;
    if (count > 0 && !first_answer) first_answer = at;
    if (since && (count == summary_.listening || at - *since >= patience ||
                  (first_answer && at - *first_answer >= kOthersAnswer)))
      return true;
    if (!said && since && at - *since > std::chrono::milliseconds(200)) {
      said = true;
      clear_progress();
      fmt::print(stderr, "mien: {}: waiting {:.0f} s for an answer (--wait)\n", options_.to, options_.wait_s);
    }
    if (!progress(0, "waiting") || (options_.start != nullptr && options_.start->stopped)) return false;
    sleep_until(since ? std::min(at + kLookUp, *since + patience) : at + kLookUp);
  }
}

/// None: stopped.
Result<std::optional<HostTime>> Broadcast::agree_on_start(const Progress& progress) {
  // Devices are on a little before the performance begins.
  if (options_.start == nullptr) return now() + from_seconds(virt::kDeviceMarginS);
  options_.start->boards_ready = true;
  while (options_.start->begin.load() == Clock::time_point()) {
    MIEN_TRY(send_due());
    if (options_.start->stopped || !progress(0, "waiting")) return std::nullopt;
    sleep_until(now() + kLookUp);
  }
  return HostTime(options_.start->begin.load() - opened_);
}

Result<void> Broadcast::simulate_ahead(HostTime at) {
  const double performed_s = to_seconds(at - *start_);
  // One stretch at a time where it is ahead: it takes less than what a packet may be late.
  if (nodes_.simulated_s() < performed_s + kAheadS) MIEN_TRY(nodes_.simulate());
  while (nodes_.simulated_s() < performed_s) MIEN_TRY(nodes_.simulate());
  return {};
}

Result<NetworkSummary> Broadcast::run() {
  summary_.nodes = nodes_.size();
  for (std::size_t n = 0; n < nodes_.size(); ++n) summary_.listening += nodes_[n].listens() ? 1 : 0;
  const auto shown = [this](const std::string& title) -> Progress {
    if (options_.title.empty()) return [](double, std::string_view) { return !stop_asked(); };
    return terminal_progress(title);
  };
  Progress progress = shown(options_.title);
  MIEN_TRY_ASSIGN(const bool waited, wait_for_an_answer(progress));
  if (waited) {
    while (nodes_.simulated_s() < kAheadS) MIEN_TRY(nodes_.simulate());
    MIEN_TRY_ASSIGN(start_, agree_on_start(progress));
  }
  if (start_) nodes_.begin(*start_);
  summary_.stopped = !start_;
  while (!summary_.stopped && !nodes_.finished()) {
    const HostTime at = now();
    MIEN_TRY(simulate_ahead(at));
    MIEN_TRY(send_due());

    summary_.performed_s = std::max(0.0, to_seconds(at - *start_));
    const auto [round, share] = nodes_.round_at(summary_.performed_s);
    if (round > summary_.rounds && round > 1)
      progress = shown(fmt::format("{}, round {}", options_.title, round));
    summary_.rounds = round;
    if (options_.enough && options_.enough(round)) {
      summary_.answered = answered();
      return summary_;
    }
    summary_.stopped = !progress(
        std::min(0.999, share), summary_.listening == 0
                                    ? fmt::format("{} nodes", nodes_.size())
                                    : fmt::format("{} of {} nodes answered", answered(), summary_.listening));
    if (options_.start != nullptr && options_.start->stopped) summary_.stopped = true;

    HostTime next = at + kLookUp;
    for (std::size_t n = 0; n < nodes_.size(); ++n) next = std::min(next, nodes_[n].due());
    sleep_until(next);
  }
  if (!summary_.stopped) progress(1, "performed");
  summary_.answered = answered();
  return summary_;
}

}  // namespace

Result<NetworkTarget> parse_target(const std::string& text) {
  const auto bad = [&] {
    return fail(ErrorCode::bad_usage, "no address of a receiver", text,
                "write udp://HOST:PORT or slimevr://HOST:PORT");
  };
  NetworkTarget target;
  std::string_view rest = text;
  if (rest.starts_with("slimevr://"))
    target.language = virt::NodeLanguage::slimevr;
  else if (!rest.starts_with("udp://"))
    return bad();
  rest.remove_prefix(rest.find("//") + 2);
  const auto address = parse_host_port(rest);
  if (!address || address->host.empty() || address->port.value_or(0) == 0) return bad();
  target.host = address->host;
  target.port = *address->port;
  return target;
}

Result<NetworkTarget> parse_phone_target(const std::string& text) {
  const auto address = parse_host_port(text);
  const std::uint16_t port = address ? address->port.value_or(sink::kLiveLinkPort) : std::uint16_t{0};
  if (!address || address->host.empty() || port == 0)
    return fail(ErrorCode::bad_usage, "no address of a receiver", "--phone " + text,
                "write HOST or HOST:PORT, where mien live --listen livelink:// hears it");
  return NetworkTarget{.host = std::string(address->host), .port = port};
}

bool has_senders(const sensor::Rig& rig) {
  return std::ranges::any_of(rig.sensors, [](const sensor::Mount& mount) { return mount.kind != "camera"; });
}

Result<NetworkSummary> perform_to_network(const virt::StageRequest& request, const NetworkOptions& options) {
  MIEN_TRY(parse_target(options.to));
  MIEN_TRY_ASSIGN(virt::Stage stage, virt::set_stage(request));
  return perform_to_network(std::move(stage), options);
}

Result<NetworkSummary> perform_to_network(virt::Stage stage, const NetworkOptions& options) {
  MIEN_TRY_ASSIGN(const NetworkTarget target, parse_target(options.to));
  if (options.start == nullptr && virt::headset_of(stage) != nullptr && has_senders(stage.rig))
    return fail(ErrorCode::bad_usage, "the rig's cameras are asked for their pictures, which nobody offers",
                stage.rig.name, "offer them, too: --cameras http://HOST:PORT");
  const std::string rig = stage.rig.name;
  MIEN_TRY_ASSIGN(const std::unique_ptr<virt::NodeGroup> nodes,
                  virt::NodeGroup::create(std::move(stage), target.language, options.loop));
  std::optional<NetworkTarget> phone;
  for (std::size_t n = 0; n < nodes->size(); ++n) {
    if (!speaks_as_phone((*nodes)[n])) continue;
    if (options.key)
      return fail(ErrorCode::bad_usage, "with a key all packets are sealed, and phones seal none", "--key",
                  "leave out --key or the phone");
    if (options.phone.empty())
      return fail(ErrorCode::bad_usage, "it was not said to whom the phone sends", "rig " + rig,
                  "give --phone HOST[:PORT], where mien live --listen livelink:// hears it");
    MIEN_TRY_ASSIGN(phone, parse_phone_target(options.phone));
  }
  if (options.key) {
    // What a board counts in its flash: each performer of a session is after the one before, and no nonce
    // comes twice.
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(now).count();
    nodes->seal(*options.key, static_cast<std::uint32_t>(seconds & 0x7FFF'FFFF));
  }
  Broadcast broadcast(*nodes, options);
  MIEN_TRY(broadcast.open(target, phone));
  return broadcast.run();
}

}  // namespace mien::app
