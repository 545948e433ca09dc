// What do the sensors send? Prints every sample, decoded and known by its place on the face:
//   hear_packets              of two packets that it makes itself
//   hear_packets TAKE.mien    of a recorded session, from its raw packets
//   hear_packets 5005         of boards that send there, or of `mien perform --to udp://127.0.0.1:5005`

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <boost/asio/ip/udp.hpp>
#include <map>

#include "mien/core/files.h"
#include "mien/imu/packets/packet.h"
#include "mien/modalities/modalities.h"
#include "mien/sensor/bindings.h"
#include "mien/session/replay.h"

namespace {
using namespace mien;

struct Printer final : session::SampleConsumer {  // Who is handed what was received.
  sensor::Rig rig;
  void add(HostTime arrival, const sensor::Sample& sample) override {
    fmt::print("{:9.4f} s  {:20} {::.3f}\n", to_seconds(arrival.time_since_epoch()),
               rig.sensors[sample.sensor].name, sample.used());
  }
  void rebound(std::uint16_t, const sensor::DeviceKey&, bool) override {}  // Another board sits there.
};

/// What the board at the rig's first place would send: gyroscope (rad/s) and accelerometer (m/s^2).
take::LogEntry own_packet(std::int64_t id) {
  const DeviceTime time(std::chrono::milliseconds(10 * id));
  sensor::Sample sample{.sequence = static_cast<std::uint32_t>(id), .time = time, .count = 6};
  sample.values = {0.5F, 0, 0, 0, 9.80665F, 0};
  imu::Packet packet = imu::make_packet({&sample, 1}).value();
  packet.device = sensor::virtual_device(0);
  return {id, HostTime(std::chrono::milliseconds(10 * id + 2)), "own", imu::encode_packet(packet).value()};
}

void receive_from(std::uint16_t port, session::Receiver& receiver, Printer& printer) {
  namespace asio = boost::asio;
  asio::io_context network;
  asio::ip::udp::socket socket(network, {asio::ip::udp::v4(), port});
  std::map<asio::ip::udp::endpoint, sensor::Peer> peers;  // To the receiver a sender is a number.
  for (std::array<std::byte, 2048> bytes;;) {
    asio::ip::udp::endpoint from;
    const auto datagram = std::span(bytes).first(socket.receive_from(asio::buffer(bytes), from));
    const HostTime arrival(std::chrono::steady_clock::now().time_since_epoch());
    const auto peer = peers.emplace(from, static_cast<sensor::Peer>(peers.size())).first;
    const auto reply = receiver.receive(arrival, peer->second, datagram, printer).reply;
    if (!reply.empty()) socket.send_to(asio::buffer(reply.data(), reply.size()), from);  // To a hello.
  }
}

Result<void> run(const std::string& source) {
  Printer printer;
  std::vector<take::LogEntry> log = {own_packet(1), own_packet(2)};
  if (source.ends_with(".mien")) {
    MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(source));
    MIEN_TRY_ASSIGN(log, take.entries());
    printer.rig = take.rig();
  } else {
    MIEN_TRY_ASSIGN(const auto path, find_resource("rigs/default.toml"));
    MIEN_TRY_ASSIGN(printer.rig, sensor::read_rig(path));
  }
  MIEN_TRY_ASSIGN(auto protocols, modalities::make_protocols());  // All that sensors speak.
  MIEN_TRY_ASSIGN(const auto receiver, session::Receiver::create(printer.rig, std::move(protocols)));
  if (!source.empty() && !source.ends_with(".mien"))
    receive_from(static_cast<std::uint16_t>(std::stoi(source)), *receiver, printer);
  static_cast<void>(session::replay_samples(log, {}, *receiver, printer, [](const auto&) { return true; }));
  return {};
}
}  // namespace

int main(int argc, char** argv) {
  const auto done = run(argc > 1 ? argv[1] : "");
  if (!done) fmt::print(stderr, "{}\n", done.error().message());
  return done ? 0 : 1;
}
