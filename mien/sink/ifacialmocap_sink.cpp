#include "mien/sink/sink_kinds.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <optional>
#include <vector>

#include "mien/face/ifacialmocap_request.h"
#include "mien/sink/frame_pace.h"
#include "mien/sink/ifacialmocap.h"
#include "mien/sink/udp_target.h"

namespace mien::sink {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

constexpr std::size_t kMaxPeers = 8;
/// A peer that has refused so many frames in a row has gone.
constexpr int kPatience = 120;
/// Requests that are read a frame, so that a flood of them costs no more than this.
constexpr int kRequestsPerFrame = 16;

/// Addresses that do not leave the house: loopback, private and link-local ones.
bool is_local(const boost::asio::ip::address& address) {
  if (address.is_v6() && !address.to_v6().is_v4_mapped()) {
    const auto bytes = address.to_v6().to_bytes();
    return address.is_loopback() || (bytes[0] & 0xFEU) == 0xFCU || address.to_v6().is_link_local();
  }
  const auto b =
      (address.is_v6() ? boost::asio::ip::make_address_v4(boost::asio::ip::v4_mapped, address.to_v6())
                       : address.to_v4())
          .to_bytes();
  return b[0] == 127 || b[0] == 10 || (b[0] == 172 && (b[1] & 0xF0U) == 16) || (b[0] == 192 && b[1] == 168) ||
         (b[0] == 169 && b[1] == 254);
}

/// One who gets frames.
struct Peer {
  UdpTarget target;
  IFacialMocapVersion version = IFacialMocapVersion::v2;
  int refusals = 0;  ///< In a row.
};

class IFacialMocapSink final : public Sink {
 public:
  IFacialMocapSink(boost::asio::io_context& network, std::string address, UdpTarget target,
                   IFacialMocapVersion version, int rate_hz)
      : network_(&network), address_(std::move(address)), pace_(rate_hz) {
    peers_.reserve(kMaxPeers + 1);
    peers_.push_back({std::move(target), version, 0});
  }

  /// Listens for requests on that port.
  Result<void> listen(std::uint16_t port) {
    udp::socket socket(*network_);
    const auto protocol = peers_.front().target.endpoint().protocol();
    error_code code;
    socket.open(protocol, code);
    if (!code) socket.non_blocking(true, code);
    if (!code) socket.bind({protocol, port}, code);
    if (code) {
      no_requests_ = fmt::format("no requests are received, port {}: {}", port, code.message());
      return fail(ErrorCode::io, no_requests_, address_);
    }
    requests_ = std::move(socket);
    return {};
  }

  void send(const face::OutputFrame& frame, std::int64_t frame_index) noexcept override {
    try {
      receive_requests();
      if (!pace_.due(frame_index)) return;
      const ArkitFrame arkit = arkit_frame(frame);
      std::array<bool, 2> encoded{};
      bool any = false;
      for (Peer& peer : peers_) {
        const Delivery news = peer.target.news();
        peer.refusals = news == Delivery::taken ? 0 : peer.refusals + 1;
        // Frames before were counted by whether anybody took them; this tells of the first receiver alone.
        if (news != Delivery::taken && peers_.size() == 1) pace_.undelivered();
        const auto version = static_cast<std::size_t>(peer.version);
        if (!encoded[version]) {
          datagrams_[version].clear();
          encode_ifacialmocap(arkit, peer.version, datagrams_[version]);
          encoded[version] = true;
        }
        const Delivery delivery = peer.target.send(datagrams_[version]);
        any = any || delivery == Delivery::taken;
        if (&peer == &peers_.front()) first_ = news == Delivery::taken ? delivery : news;
      }
      // The first was named by a person and stays.
      peers_.erase(std::remove_if(peers_.begin() + 1, peers_.end(),
                                  [](const Peer& peer) { return peer.refusals > kPatience; }),
                   peers_.end());
      if (any)
        pace_.sent();
      else
        pace_.failed();
    } catch (...) {  // Out of memory while the buffers grow: the frame is lost.
      pace_.failed();
    }
  }

  Status status() const override {
    // Those who asked are known, the one that was named only to be deaf.
    std::optional<std::size_t> receivers;
    if (first_ == Delivery::refused)
      receivers = peers_.size() - 1;
    else if (peers_.size() > 1)
      receivers = peers_.size();
    std::string note(describe(first_));
    if (note.empty())
      note = tcp_asked_ ? "somebody asks for TCP, which is not spoken here; let it use UDP" : no_requests_;
    return {address_, pace_.sent_count(), pace_.failed_count(), pace_.measured_hz(), receivers, note};
  }

 private:
  void receive_requests() {
    if (!requests_) return;
    for (int i = 0; i < kRequestsPerFrame; ++i) {
      std::array<std::byte, 256> bytes;
      udp::endpoint from;
      error_code code;
      const std::size_t size = requests_->receive_from(boost::asio::buffer(bytes), from, 0, code);
      if (code == boost::asio::error::would_block) return;
      if (code || !is_local(from.address())) continue;
      const auto request = parse_ifacialmocap_request(std::span(bytes).first(size));
      if (!request) continue;
      if (*request == IFacialMocapRequest::tcp) tcp_asked_ = true;
      if (*request == IFacialMocapRequest::v1) answer(from, IFacialMocapVersion::v1);
      if (*request == IFacialMocapRequest::v2) answer(from, IFacialMocapVersion::v2);
    }
  }

  /// Whoever asks is sent to from now on, at the port where its kind listens.
  void answer(const udp::endpoint& from, IFacialMocapVersion version) {
    const udp::endpoint to(from.address(), peers_.front().target.endpoint().port());
    const auto known = std::ranges::find(peers_, to, [](const Peer& peer) { return peer.target.endpoint(); });
    if (known != peers_.end()) {
      known->version = version;
      return;
    }
    if (peers_.size() > kMaxPeers) return;
    if (auto target = UdpTarget::open(*network_, to)) peers_.push_back({*std::move(target), version, 0});
  }

  boost::asio::io_context* network_;
  std::string address_;
  FramePace pace_;
  std::vector<Peer> peers_;  ///< The first is the address's own.
  std::optional<udp::socket> requests_;
  std::array<Datagrams, 2> datagrams_;  ///< One a version.
  Delivery first_ = Delivery::taken;    ///< How the first receiver does.
  bool tcp_asked_ = false;
  std::string no_requests_;
};

}  // namespace

Result<std::unique_ptr<Sink>> open_ifacialmocap_sink(boost::asio::io_context& network, const Address& address,
                                                     std::string_view text) {
  MIEN_TRY(address.expect_options({"version", "listen", "rate"}));
  MIEN_TRY_ASSIGN(const int rate_hz, address.whole_option("rate", 60, 1, 60));
  MIEN_TRY_ASSIGN(const int version, address.whole_option("version", 2, 1, 2));
  MIEN_TRY_ASSIGN(UdpTarget target, UdpTarget::open(network, address, face::kIFacialMocapPort));
  const bool asked = address.option("listen") != nullptr;
  const int usual = is_this_machine(target.endpoint().address()) ? 0 : int{face::kIFacialMocapPort};
  MIEN_TRY_ASSIGN(const int port, address.whole_option("listen", usual, 0, 65535));
  auto sink = std::make_unique<IFacialMocapSink>(
      network, std::string(text), std::move(target),
      version == 1 ? IFacialMocapVersion::v1 : IFacialMocapVersion::v2, rate_hz);
  if (port != 0) {
    const auto listening = sink->listen(static_cast<std::uint16_t>(port));
    if (!listening && asked) return std::unexpected(listening.error());
  }
  return sink;
}

}  // namespace mien::sink
