// `mien live --listen livelink://` and `ifacialmocap://` from outside: a phone in, a take and a hash out.
#include <utility>  // Before Asio 1.74, which forgets it.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <signal.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>

#include "mien/sensor/rig_part.h"
#include "mien/take/take.h"
#include "tests/app/free_port.h"
#include "tests/app/program.h"
#include "tests/phone/live_link_bytes.h"

namespace mien::app::test::phone_live_test {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using testing::HasSubstr;

const udp::endpoint kAnyPort(asio::ip::address_v4::loopback(), 0);

/// A phone with a socket of its own, on a thread of its own: what it does between two frames of sixty.
class Phone {
 public:
  explicit Phone(std::function<void(udp::socket&, int number)> frame)
      : thread_([this, frame = std::move(frame)](const std::stop_token& stop) {
          for (int n = 0; !stop.stop_requested(); ++n) {
            frame(socket_, n);
            std::this_thread::sleep_for(std::chrono::microseconds(16'667));
          }
        }) {}
  [[nodiscard]] std::uint16_t port() const { return socket_.local_endpoint().port(); }

 private:
  asio::io_context network_;
  udp::socket socket_{network_, kAnyPort};
  std::jthread thread_;
};

void send(udp::socket& socket, std::uint16_t to, std::span<const std::byte> bytes) {
  boost::system::error_code nobody_listens_yet;
  socket.send_to(asio::buffer(bytes.data(), bytes.size()), udp::endpoint(kAnyPort.address(), to), 0,
                 nobody_listens_yet);
}

Phone live_link_phone(std::uint16_t to) {
  return Phone([to](udp::socket& socket, int number) {
    phone::test::LiveLinkFields fields{.frame = 7'000 + number};
    fields.values.emplace().fill(0.25F);
    send(socket, to, phone::test::live_link_bytes(fields));
  });
}

const std::string kRig =
    "name = \"phone\"\nreference = \"phone\"\n[[sensor]]\nname = \"phone\"\nkind = \"weights\"\n"
    "role = \"face\"\ndevice = \"02:4D:49:50:48:00\"\n";

TEST(PhoneProgram, APhoneThatIsHeardMovesTheFaceAndItsTakeReplaysToTheSameBits) {
  const Folder folder;
  write(folder / "rig.toml", kRig);
  const std::uint16_t port = free_port();
  const Phone phone = live_link_phone(port);
  const Outcome live =
      run({"live", "--rig", folder / "rig.toml", "--listen", fmt::format("livelink://127.0.0.1:{}", port),
           "--page", "off", "--json", "--for", "2.5", "--record", folder / "take.mien"});
  ASSERT_EQ(live.status, 0) << live.err;
  const auto summary = nlohmann::json::parse(live.out);
  EXPECT_GT(summary["frames"], 60);
  EXPECT_EQ(summary["malformed"], 0);
  const Outcome solved = run({"solve", folder / "take.mien", "--out", folder / "face.csv", "--json"});
  ASSERT_EQ(solved.status, 0) << solved.err;
  EXPECT_EQ(nlohmann::json::parse(solved.out)["hash"], summary["hash"]);
  EXPECT_THAT(content(folder / "face.csv"), HasSubstr(",0.25"));
}

TEST(PhoneProgram, ATruthBesideSensorsIsInTheTakeAndAReplayIsTheSameBits) {
  const Folder folder;
  const std::uint16_t phone_port = free_port(), board_port = free_port();
  const Phone phone = live_link_phone(phone_port);
  const pid_t performer = start(
      {"perform", "--to", fmt::format("udp://127.0.0.1:{}", board_port), "--seconds", "3", "--wait", "20"},
      folder / "perform.out", folder / "perform.err");
  const std::string take = folder / "take.mien";
  const Outcome live = run({"live", "--listen", fmt::format("udp://127.0.0.1:{}", board_port), "--listen",
                            fmt::format("livelink://127.0.0.1:{}", phone_port), "--phone", "truth", "--page",
                            "off", "--json", "--for", "6", "--record", take});
  ::kill(performer, SIGTERM);
  int status = 0;
  ::waitpid(performer, &status, 0);
  ASSERT_EQ(live.status, 0) << live.err << content(folder / "perform.err");
  const auto summary = nlohmann::json::parse(live.out);
  EXPECT_GT(summary["frames"], 60);
  const Outcome again = run({"live", "--replay", take, "--json"});
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(nlohmann::json::parse(again.out)["hash"], summary["hash"]);

  const take::Take opened = take::Take::open(take).value();
  const auto truths = sensor::truths_of(opened.rig());
  ASSERT_EQ(truths.size(), 1U);
  EXPECT_EQ(opened.rig().sensors[truths[0]].name, "phone");
  EXPECT_EQ(opened.rig().sensors[0].device, "02:4D:49:45:4E:00");
  const auto samples = opened.samples().value();
  EXPECT_GT(std::ranges::count_if(samples, [&](const auto& s) { return s.sample.sensor == truths[0]; }), 300);
}

TEST(PhoneProgram, APhoneThatIsAskedAnswers) {
  boost::system::error_code taken;
  {
    asio::io_context network;
    udp::socket answers(network, udp::v4());
    answers.bind(udp::endpoint(asio::ip::address_v4::any(), 49983), taken);
  }
  if (taken) GTEST_SKIP() << "port 49983 is taken on this machine";
  const Folder folder;
  std::atomic<int> asked = 0;
  const Phone phone([&asked](udp::socket& socket, int) {
    std::array<char, 256> heard{};
    boost::system::error_code code;
    udp::endpoint from;
    socket.non_blocking(true);
    const std::size_t size = socket.receive_from(asio::buffer(heard), from, 0, code);
    if (!code && std::string(heard.data(), size) ==
                     "iFacialMocap_sahuasouryya9218sauhuiayeta91555dy3719|sendDataVersion=v2")
      ++asked;
    const std::string frame = "trackingStatus&1|jawOpen&40|=head#0,0,0,0,0,0|";
    if (asked > 0) send(socket, 49983, std::as_bytes(std::span(frame)));
  });
  // By its name, which takes a while to be looked up.
  const std::string address = fmt::format("ifacialmocap://localhost:{}", phone.port());
  std::string rig = kRig;
  rig.replace(rig.find("02:4D:49:50:48:00"), 17, "02:4D:49:46:4D:00");
  write(folder / "rig.toml", rig);
  const Outcome live = run(
      {"live", "--rig", folder / "rig.toml", "--listen", address, "--page", "off", "--json", "--for", "3"});
  ASSERT_EQ(live.status, 0) << live.err;
  EXPECT_THAT(live.err, HasSubstr("Asking " + address + " for its frames"));
  EXPECT_GT(nlohmann::json::parse(live.out)["frames"], 60);
  EXPECT_GE(asked, 2) << "it is asked again and again";
  EXPECT_THAT(live.err, testing::Not(HasSubstr("no frame comes")));
  asked = std::numeric_limits<int>::min();  // This one sends no more.
  // One on which nothing listens, and one that takes the question and is mute. (Here, since the port is this
  // machine's one.)
  asio::io_context network;
  const udp::socket mute(network, kAnyPort);
  const std::string mute_address = fmt::format("ifacialmocap://127.0.0.1:{}", mute.local_endpoint().port());
  const Outcome closed = run({"live", "--rig", folder / "rig.toml", "--listen",
                              fmt::format("ifacialmocap://127.0.0.1:{}", free_port()), "--listen",
                              mute_address, "--phone", "truth", "--page", "off", "--json", "--for", "6"});
  EXPECT_THAT(closed.err, HasSubstr(mute_address + " was asked 3 times and no frame comes from it"));
  EXPECT_THAT(closed.err, HasSubstr("open iFacialMocap on the phone"));
  EXPECT_THAT(closed.err, testing::Not(HasSubstr("is asked again")));
}

TEST(PhoneProgram, WhatItIsForHasToBeSaid) {
  const Folder folder;
  write(folder / "rig.toml", kRig);
  const auto refused = [](std::vector<std::string> more) {
    more.insert(more.begin(), {"live", "--page", "off", "--for", "1"});
    const Outcome outcome = run(more);
    EXPECT_NE(outcome.status, 0) << joined(more);
    return outcome.err;
  };
  EXPECT_THAT(refused({"--listen", "livelink://127.0.0.1:0"}), HasSubstr("give --phone truth"));
  EXPECT_THAT(refused({"--phone", "truth"}), HasSubstr("no phone is listened to"));
  EXPECT_THAT(refused({"--phone", "mirror", "--listen", "livelink://127.0.0.1"}), HasSubstr("truth"));
  EXPECT_THAT(
      refused({"--rig", folder / "rig.toml", "--phone", "truth", "--listen", "livelink://127.0.0.1:0"}),
      HasSubstr("the rig has a sensor for it"));
  EXPECT_THAT(refused({"--phone", "truth", "--listen", "livelink:127.0.0.1"}),
              HasSubstr("no address of a phone"));
  EXPECT_THAT(refused({"--phone", "truth", "--listen", "ifacialmocap://"}), HasSubstr("no host"));
  EXPECT_THAT(
      refused({"--phone", "truth", "--listen", "livelink://127.0.0.1", "--listen", "livelink://127.0.0.1"}),
      HasSubstr("given twice"));
  EXPECT_THAT(refused({"--phone", "truth", "--listen", fmt::format("udp://127.0.0.1:{}", free_port()),
                       "--listen", "livelink://no.such.address.here"}),
              HasSubstr("no IP address of this machine"));
}

}  // namespace
}  // namespace mien::app::test::phone_live_test
