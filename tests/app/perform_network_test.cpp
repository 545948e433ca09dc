// `mien perform --to`: what reaches a receiver's socket.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "mien/imu/packets/node_protocol.h"
#include "mien/imu/packets/packet.h"
#include "mien/imu/packets/slimevr.h"
#include "mien/imu/packets/slimevr_protocol.h"
#include "mien/take/take.h"
#include "tests/app/program.h"
#include "tests/virtual/three_sensors.h"

namespace mien::app::test::perform_network_test {
namespace {

using ::testing::HasSubstr;

/// A UDP receiver on a free port of this machine.
class Receiver {
 public:
  Receiver() {
    socket_ = ::socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    socklen_t size = sizeof address;
    ::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    const int buffer = 1 << 22;
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer);
    const timeval patience{.tv_sec = 0, .tv_usec = 100'000};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  ~Receiver() { ::close(socket_); }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }

  /// Hears until `over`, answering as `answer` says.
  void receive(
      const std::function<bool()>& over,
      const std::function<std::vector<std::byte>(std::uint16_t, std::span<const std::byte>)>& answer) {
    std::array<std::byte, 2048> buffer{};
    for (;;) {
      sockaddr_in from{};
      socklen_t size = sizeof from;
      const ssize_t got =
          ::recvfrom(socket_, buffer.data(), buffer.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
      if (got < 0) {
        if (over()) return;
        continue;
      }
      const auto reply = answer(ntohs(from.sin_port), std::span(buffer).first(static_cast<std::size_t>(got)));
      if (!reply.empty())
        ::sendto(socket_, reply.data(), reply.size(), 0, reinterpret_cast<sockaddr*>(&from), size);
    }
  }

 private:
  int socket_ = -1;
  std::uint16_t port_ = 0;
};

class PerformNetwork : public ::testing::Test {
 protected:
  void SetUp() override { write(folder_ / "rig.toml", virt::test::kRig); }

  [[nodiscard]] std::vector<std::string> perform(std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"perform",   "--rig", folder_ / "rig.toml", "--script", "free",
                                          "--seconds", "2",     "--prologue",         "none",     "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  /// Runs a performance while its receiver hears it.
  Outcome performed(
      const std::vector<std::string>& arguments, Receiver& receiver,
      const std::function<std::vector<std::byte>(std::uint16_t, std::span<const std::byte>)>& answer) {
    Outcome outcome;
    std::atomic<bool> over = false;
    std::thread performer([&] {
      outcome = run(arguments);
      over = true;
    });
    receiver.receive([&] { return over.load(); }, answer);
    performer.join();
    return outcome;
  }

  Folder folder_;
};

TEST_F(PerformNetwork, EveryNodeOfOursIsASocketAndSendsWhatATakeHolds) {
  Receiver receiver;
  imu::NodeProtocol host = imu::NodeProtocol::create({.session = 9}).value();
  sensor::Inbox inbox;
  std::map<std::uint16_t, std::set<std::uint64_t>> devices;
  std::multiset<std::vector<std::byte>> samples;
  std::set<std::string> sites;
  const Outcome outcome = performed(perform({"--to", "udp://127.0.0.1:" + std::to_string(receiver.port())}),
                                    receiver, [&](std::uint16_t port, std::span<const std::byte> bytes) {
                                      inbox.clear();
                                      EXPECT_EQ(host.receive({}, port, bytes, inbox), sensor::Verdict::taken);
                                      for (const auto& announcement : inbox.announcements)
                                        sites.insert(announcement.site);
                                      if (const auto packet = imu::parse_packet(bytes)) {
                                        devices[port].insert(packet->device);
                                        samples.emplace(bytes.begin(), bytes.end());
                                      }
                                      return inbox.reply;
                                    });
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(sites, ::testing::UnorderedElementsAre("mentalis", "buccinator_L", "mastoid_L"));
  EXPECT_EQ(devices.size(), 3U);
  for (const auto& [port, ids] : devices) EXPECT_EQ(ids.size(), 1U);
  const auto said = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(said["nodes"], 3);
  EXPECT_EQ(said["answered"], 3);
  EXPECT_EQ(said["refused"], 0);
  EXPECT_EQ(said["stopped"], false);
  EXPECT_GE(said["packets"], samples.size());

  ASSERT_EQ(run(perform({"--take", folder_ / "same.mien"})).status, 0);
  const auto entries = take::Take::open(folder_ / "same.mien").value().entries().value();
  EXPECT_EQ(samples.size(), entries.size());
  for (const take::LogEntry& entry : entries) EXPECT_TRUE(samples.contains(entry.bytes));
}

TEST_F(PerformNetwork, ASlimeVrServerTakesItsTrackers) {
  Receiver receiver;
  imu::SlimeVrProtocol server;
  sensor::Inbox inbox;
  std::map<std::uint64_t, std::size_t> rotations;
  HostTime now;
  const Outcome outcome =
      performed(perform({"--to", "slimevr://127.0.0.1:" + std::to_string(receiver.port())}), receiver,
                [&](std::uint16_t port, std::span<const std::byte> bytes) {
                  inbox.clear();
                  now += std::chrono::milliseconds(3);
                  EXPECT_NE(server.receive(now, port, bytes, inbox), sensor::Verdict::malformed);
                  for (const auto& reading : inbox.readings) ++rotations[reading.from.device];
                  return inbox.reply;
                });
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  ASSERT_EQ(rotations.size(), 3U);
  for (std::uint64_t n = 0; n < 3; ++n) EXPECT_GT(rotations[0x024D'4945'4E00U + n], 50U) << n;
}

TEST_F(PerformNetwork, SaysOnceThatNobodyListensGoesOnAndFailsAtTheEnd) {
  std::uint16_t port = 0;
  {
    const Receiver gone;
    port = gone.port();
  }
  const std::string to = "udp://127.0.0.1:" + std::to_string(port);
  const Outcome outcome = run(perform({"--to", to, "--wait", "0"}));
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err,
              ::testing::EndsWith("mien: " + to +
                                  ": nobody listened there: every packet was refused; start mien "
                                  "live first, and see that it listens on this port\n"));
  EXPECT_THAT(outcome.err, HasSubstr("nobody listens"));
  EXPECT_EQ(outcome.err.find("nobody listens"), outcome.err.rfind("nobody listens"));
  const auto said = nlohmann::json::parse(outcome.out);
  EXPECT_GT(said["refused"], 0);
  EXPECT_GT(said["packets"], 300);
  EXPECT_EQ(said["answered"], 0);
}

TEST_F(PerformNetwork, AStopIsACleanEnd) {
  Receiver receiver;
  const std::string to = "udp://127.0.0.1:" + std::to_string(receiver.port());
  const pid_t process =
      start(perform({"--to", to, "--wait", "0", "--loop"}), folder_ / "out", folder_ / "err");
  ASSERT_GT(process, 0);
  // Once the performance is on, and no sooner: the first samples say so.
  bool received = false;
  receiver.receive([&] { return received; },
                   [&](std::uint16_t, std::span<const std::byte> bytes) {
                     if (imu::is_packet(bytes) && !received) {
                       received = true;
                       ::kill(process, SIGINT);
                     }
                     return std::vector<std::byte>();
                   });
  int status = 0;
  ::waitpid(process, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(nlohmann::json::parse(content(folder_ / "out"))["stopped"], true);
}

TEST_F(PerformNetwork, WrongTargetsAreToldInOneLine) {
  for (const auto& [more, names] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"--to", "udp://127.0.0.1"}, "udp://127.0.0.1"},
           {{"--to", "udp://:5005"}, "udp://:5005"},
           {{"--to", "udp://127.0.0.1:0"}, "udp://127.0.0.1:0"},
           {{"--to", "udp://127.0.0.1:70000"}, "70000"},
           {{"--to", "udp://::1:5005"}, "udp://::1:5005"},
           {{"--to", "http://127.0.0.1:80"}, "udp://HOST:PORT"},
           {{"--to", "udp://nobody.invalid:5005"}, "nobody.invalid"},
           {{"--to", "udp://127.0.0.1:5005", "--devices", "lab"}, "lab"},
           {{"--to", "udp://127.0.0.1:5005", "--take", folder_ / "a.mien"}, "--take"},
           {{"--to", "udp://127.0.0.1:5005", "--wait", "-1"}, "--wait"},
           {{"--to", "udp://127.0.0.1:5005", "--pace", "real"}, "--take"},
           {{"--take", folder_ / "a.mien", "--loop"}, "--to"},
           {{}, "--take"}}) {
    const Outcome refused = run(perform(more));
    SCOPED_TRACE(joined(more));
    EXPECT_EQ(refused.status, 2);
    EXPECT_EQ(refused.out, "");
    EXPECT_EQ(std::ranges::count(refused.err, '\n'), 1) << refused.err;
    EXPECT_THAT(refused.err, HasSubstr(names));
  }
}

}  // namespace
}  // namespace mien::app::test::perform_network_test
