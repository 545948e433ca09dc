// What do the sensors send? Prints every sample, decoded and known by its place on the face:
//   hear_packets              of two packets that it makes itself
//   hear_packets TAKE.mien    of a recorded session, from its raw packets
//   hear_packets 5005         of boards that send there, or of `mien perform --to udp://127.0.0.1:5005`

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <boost/asio/ip/udp.hpp>
#include <map>

#include "mien/core/bytes.h"
#include "mien/core/files.h"
#include "mien/imu/packets/packet.h"
#include "mien/modalities/modalities.h"
#include "mien/sensor/bindings.h"

namespace {
using namespace mien;

void print(const session::Session& session, HostTime arrival, std::span<const sensor::Sample> samples) {
  for (const sensor::Sample& sample : samples)
    fmt::print("{:9.4f} s  {:20} {::.3f}\n", to_seconds(arrival.time_since_epoch()),
               session.rig().sensors[sample.sensor].name, sample.used());
}

/// What the board at the rig's first place would send: gyroscope (rad/s) and accelerometer (m/s^2).
take::LogEntry own_packet(std::int64_t id) {
  const DeviceTime time(std::chrono::milliseconds(10 * id));
  sensor::Sample sample{.sequence = static_cast<std::uint32_t>(id), .time = time, .count = 6};
  sample.values = {0.5F, 0, 0, 0, 9.80665F, 0};
  imu::Packet packet = imu::make_packet({&sample, 1}).value();
  packet.device = sensor::virtual_device(0);
  return {id, HostTime(std::chrono::milliseconds(10 * id + 2)), "own", imu::encode_packet(packet).value()};
}

void receive_from(std::uint16_t port, session::Session& session) {
  namespace asio = boost::asio;
  asio::io_context network;
  asio::ip::udp::socket socket(network, {asio::ip::udp::v4(), port});
  std::map<asio::ip::udp::endpoint, sensor::Peer> peers;  // To the session a sender is a number.
  for (std::array<std::byte, 2048> bytes;;) {
    asio::ip::udp::endpoint from;
    const auto datagram = std::span(bytes).first(socket.receive_from(asio::buffer(bytes), from));
    const HostTime arrival(std::chrono::steady_clock::now().time_since_epoch());
    const auto peer = peers.emplace(from, static_cast<sensor::Peer>(peers.size())).first;
    const auto received = session.receive(arrival, peer->second, datagram);
    print(session, arrival, received.samples);
    if (!received.reply.empty())  // To a hello.
      socket.send_to(asio::buffer(received.reply.data(), received.reply.size()), from);
  }
}

Result<void> run(const std::string& source) {
  const bool recorded = source.ends_with(".mien");
  std::vector<take::LogEntry> log = {own_packet(1), own_packet(2)};
  sensor::Rig rig;
  if (recorded) {
    MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(source));
    MIEN_TRY_ASSIGN(log, take.entries());
    rig = take.rig();
  } else {
    MIEN_TRY_ASSIGN(const auto path, find_resource("rigs/default.toml"));
    MIEN_TRY_ASSIGN(rig, sensor::read_rig(path));
  }
  MIEN_TRY_ASSIGN(const auto session, modalities::make_receiving_session(rig));  // It tracks nothing.
  if (!source.empty() && !recorded) receive_from(static_cast<std::uint16_t>(std::stoi(source)), *session);
  session::Peers peers;
  for (const take::LogEntry& entry : log)
    if (entry.source == session::kPageSource)  // It binds a board to another place, say.
      static_cast<void>(session->command(entry.arrival, as_text(entry.bytes)));
    else
      print(*session, entry.arrival,
            session->receive_logged(entry.arrival, peers.of(entry.source), entry.bytes, {}).samples);
  return {};
}
}  // namespace

int main(int argc, char** argv) {
  const auto done = run(argc > 1 ? argv[1] : "");
  if (!done) fmt::print(stderr, "{}\n", done.error().message());
  return done ? 0 : 1;
}
