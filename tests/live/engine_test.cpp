// The whole session on this machine's loopback: virtual nodes send, a sink receives, a page looks on and
// asks, takes are written. Nothing here measures time: what is waited for comes, or the test fails.
#include "tests/live/page_client.h"

#include "mien/live/engine.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <map>
#include <stdexcept>
#include <stop_token>
#include <thread>

#include "mien/headset/headset_tracker.h"
#include "mien/headset/picture_protocol.h"
#include "mien/modalities/osc_commands.h"
#include "mien/session/replay.h"
#include "mien/take/take.h"
#include "tests/folder.h"
#include "tests/gaze/osc_bytes.h"
#include "tests/headset/small_model.h"
#include "tests/session/session_run.h"
#include "tests/sink/loopback.h"

namespace mien::live::engine_test {
namespace {

using boost::asio::ip::udp;
using test::PageClient;
using test::run_until;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Json = nlohmann::json;

/// Sends what a performer's nodes would, each from a socket of its own, when it is due; and what somebody
/// else sends who knows nothing. With a twin the same comes from another socket too.
class Nodes {
 public:
  enum class Twin : bool { no, yes };
  Nodes(const virt::VirtualSession& performed, std::uint16_t port, Twin twin = Twin::no)
      : twin_(twin == Twin::yes),
        thread_([this, &performed, port](const std::stop_token& asked) { send(performed, port, asked); }) {}

  /// Garbage that went out.
  [[nodiscard]] std::uint64_t garbage() const { return garbage_; }
  void stop() {
    thread_.request_stop();
    thread_.join();
  }

 private:
  void send(const virt::VirtualSession& performed, std::uint16_t port, const std::stop_token& asked) {
    boost::asio::io_context network;
    const udp::endpoint there(boost::asio::ip::address_v4::loopback(), port);
    std::map<std::string, udp::socket> sockets;
    const auto socket = [&](const std::string& source) -> udp::socket& {
      const auto known = sockets.find(source);
      return known != sockets.end()
                 ? known->second
                 : sockets
                       .emplace(source, udp::socket(network, udp::endpoint(
                                                                 boost::asio::ip::address_v4::loopback(), 0)))
                       .first->second;
    };
    const auto begun = std::chrono::steady_clock::now();
    boost::system::error_code ignored;  // Nobody hears any more, at the end.
    for (const take::LogEntry& entry : performed.entries) {
      std::this_thread::sleep_until(begun + entry.arrival.time_since_epoch());
      if (asked.stop_requested()) return;
      socket(entry.source).send_to(boost::asio::buffer(entry.bytes), there, 0, ignored);
      if (twin_) socket("twin").send_to(boost::asio::buffer(entry.bytes), there, 0, ignored);
      if (entry.id % 16 != 0) continue;
      socket("stranger").send_to(boost::asio::buffer(std::string("who is there?")), there, 0, ignored);
      ++garbage_;
    }
  }

  bool twin_;
  std::atomic<std::uint64_t> garbage_ = 0;
  std::jthread thread_;
};

/// An engine on a thread of its own.
class Running {
 public:
  explicit Running(EngineSettings settings,
                   std::unique_ptr<session::Session> session = session::test::session())
      : engine_(Engine::open(std::move(settings), std::move(session))) {
    if (!engine_) return;
    thread_ = std::jthread([this] { summary_ = (*engine_)->run(stop_, EngineListener()); });
  }
  ~Running() { stop_ = true; }
  [[nodiscard]] const Result<std::unique_ptr<Engine>>& engine() const { return engine_; }
  [[nodiscard]] Engine& operator*() const { return **engine_; }
  void ask_to_stop() { stop_ = true; }
  /// After wait().
  void close() { engine_ = nullptr; }
  EngineSummary wait() {
    thread_.join();
    EXPECT_TRUE(summary_) << summary_.error().message();
    return summary_ ? *summary_ : EngineSummary();
  }

 private:
  std::atomic<bool> stop_ = false;
  Result<EngineSummary> summary_ = EngineSummary();
  Result<std::unique_ptr<Engine>> engine_;
  std::jthread thread_;
};

EngineSettings settings(const mien::test::Folder& folder) {
  EngineSettings settings;
  settings.listen = {"udp://127.0.0.1:0"};
  settings.takes = folder.path();
  settings.header.software = "test";
  settings.header.rig_toml = virt::test::kRig;
  settings.model = "two shapes";
  settings.make_session = [](const sensor::Rig& rig) -> Result<std::unique_ptr<session::Session>> {
    return session::test::session(rig);
  };
  return settings;
}

TEST(Engine, CarriesFramesFromNodesToSinksAndThePageAndObeysIt) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  boost::asio::io_context network;
  sink::test::Receiver receiver(network), second(network);

  EngineSettings asked = settings(folder);
  asked.out = {fmt::format("livelink://127.0.0.1:{}", receiver.port())};
  asked.page = PageSettings{.host = "127.0.0.1", .port = 0, .token = {}, .assets = {}};
  Running running(std::move(asked));
  ASSERT_TRUE(running.engine()) << running.engine().error().message();
  ASSERT_EQ((*running).listening().size(), 1u);
  const virt::VirtualSession performed = session::test::performance(60);
  Nodes nodes(performed, test::port_of((*running).listening().front()));

  PageClient page(network, test::port_of((*running).page()));
  std::size_t packets = 0;
  EXPECT_TRUE(run_until(network,
                        [&] {
                          packets += receiver.take().size();
                          return packets >= 30 && page.frames() >= 30 && !page.last("status").is_null();
                        }))
      << packets << " packets, " << page.frames() << " frames";
  ASSERT_FALSE(page.messages().empty());
  EXPECT_EQ(page.messages().front()["type"], "hello");
  EXPECT_EQ(page.messages().front()["rig"]["sensors"].size(), 3u);
  EXPECT_EQ(page.last_frame()["weights"].size(), face::kShapeCount);

  // What is not understood is answered, and changes nothing.
  page.say("[[[[");
  page.say(R"({"command": 7})");
  EXPECT_FALSE(page.ask({{"command", "dance"}})["ok"]);
  EXPECT_FALSE(page.ask({{"command", "record"}, {"on", true}, {"name", "../elsewhere"}})["ok"]);
  EXPECT_FALSE(page.ask({{"command", "sink"}, {"add", "csv:/elsewhere.csv"}})["ok"]);
  EXPECT_FALSE(page.ask({{"command", "sink"}, {"add", "vmc://somebody.example"}})["ok"]);
  EXPECT_FALSE(page.ask({{"command", "bind"}, {"sensor", "nose"}, {"device", "02:4D:49:45:4E:07"}})["ok"]);
  EXPECT_FALSE(page.ask({{"command", "replay"}, {"paused", true}})["ok"]);

  // A second sink, of another kind, for a while.
  ASSERT_TRUE(
      page.ask({{"command", "sink"}, {"add", fmt::format("vmc://127.0.0.1:{}", second.port())}})["ok"]);
  EXPECT_TRUE(run_until(network, [&] { return !second.take().empty(); }));
  EXPECT_TRUE(page.ask({{"command", "sink"}, {"sink", 2}, {"remove", true}})["ok"]);

  // A take, from the session's beginning on; a second one is refused meanwhile.
  const auto shown_before = page.last_frame()["index"].get<std::int64_t>();
  ASSERT_TRUE(page.ask({{"command", "record"}, {"on", true}, {"name", "one"}})["ok"]);
  EXPECT_FALSE(page.ask({{"command", "record"}, {"on", true}, {"name", "two"}})["ok"]);
  EXPECT_TRUE(page.ask({{"command", "shape"}, {"smoothing", 0.3}})["ok"]);
  EXPECT_TRUE(page.ask({{"command", "recentre"}})["ok"]);
  EXPECT_TRUE(page.ask({{"command", "tap"}, {"sensor", "mentalis"}})["ok"]);
  EXPECT_TRUE(run_until(network, [&] {
    Json status = page.last("status");  // What is not there is null.
    return status["recording"]["on"] == true && status["recording"]["seconds"] > 0.5 &&
           status["tap"]["sensor"] == "mentalis" && status["shaping"]["smoothing"] == 0.3;
  }));
  EXPECT_TRUE(page.ask({{"command", "record"}, {"on", false}})["ok"]);
  EXPECT_TRUE(run_until(network, [&] { return page.has_event("recorded"); }));
  Json takes = page.ask({{"command", "takes"}})["result"]["takes"];
  ASSERT_EQ(takes.size(), 1u);
  EXPECT_EQ(takes[0]["name"], "one.mien");
  EXPECT_TRUE(run_until(network, [&] {
    Json pushed = page.last("takes");
    return pushed.is_object() && pushed["takes"][0]["seconds"] > 0.5;
  })) << "its length is read behind the session's back, and then sent";

  // It is looked at while the session goes on.
  ASSERT_TRUE(page.ask({{"command", "replay"}, {"take", "one"}})["ok"]);
  EXPECT_TRUE(run_until(network, [&] {
    Json replay = page.last("status")["replay"];
    return replay.is_object() && replay["duration"] > 0.5 && replay["time"] > 0.1;
  }));
  EXPECT_TRUE(page.ask({{"command", "replay"}, {"stop", true}})["ok"]);
  EXPECT_TRUE(run_until(network, [&] { return page.last("status")["replay"].is_null(); }));

  // Others come and go as they like.
  for (int i = 0; i < 3; ++i) {
    PageClient other(network, test::port_of((*running).page()));
    EXPECT_TRUE(run_until(network, [&] { return other.frames() > 0; }));
  }
  const std::size_t before = page.frames();
  EXPECT_TRUE(run_until(network, [&] { return page.frames() > before + 10; }));

  nodes.stop();
  running.ask_to_stop();
  const EngineSummary summary = running.wait();
  EXPECT_GE(summary.frames, page.frames());
  EXPECT_EQ(summary.latency.count() + summary.missed, summary.frames);
  EXPECT_LE(summary.malformed, nodes.garbage());
  EXPECT_GT(summary.malformed, 0u);
  EXPECT_EQ(summary.sinks.size(), 1u);
  EXPECT_GE(summary.sinks.front().sent, 30u);
  EXPECT_THAT(summary.recording_error, IsEmpty());
  running.close();
  EXPECT_TRUE(run_until(network, [&] { return page.ended(); })) << "the page was not told";

  const auto take = take::Take::open(folder / "one.mien");
  ASSERT_TRUE(take) << take.error().message();
  EXPECT_TRUE(take->finished());
  EXPECT_EQ(take->note("live.model").value(), "two shapes");
  EXPECT_LE(take->ticks().value().front().index, shown_before - 20) << "not from the beginning";
}

TEST(Engine, ADatagramOfOscRecentresAndThePageIsToldWhoAsked) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  boost::asio::io_context network;
  session::Session::Parts parts;
  parts.rig = virt::test::three_sensors();
  parts.trackers.push_back(
      std::make_unique<imu::ImuTracker>(parts.rig, std::make_unique<session::test::TwoShapes>()));
  parts.protocols.push_back(std::make_unique<modalities::OscCommands>());
  parts.protocols.push_back(std::make_unique<imu::NodeProtocol>(imu::NodeProtocol::create().value()));
  EngineSettings asked = settings(folder);
  asked.page = PageSettings{.host = "127.0.0.1", .port = 0, .token = {}, .assets = {}};
  Running running(std::move(asked), session::Session::create(std::move(parts)).value());
  ASSERT_TRUE(running.engine()) << running.engine().error().message();
  const std::uint16_t port = test::port_of((*running).listening().front());
  const virt::VirtualSession performed = session::test::performance(60);
  Nodes nodes(performed, port);
  PageClient page(network, test::port_of((*running).page()));
  EXPECT_TRUE(run_until(network, [&] { return page.frames() >= 30; }));

  udp::socket headset(network, udp::endpoint(boost::asio::ip::address_v4::loopback(), 0));
  headset.send_to(boost::asio::buffer(gaze::test::message("/mien/recentre", {1})),
                  udp::endpoint(boost::asio::ip::address_v4::loopback(), port));
  EXPECT_TRUE(run_until(network, [&] { return page.has_event("recentre"); }));
  const auto told = std::ranges::find_if(page.messages(), [](const Json& message) {
    return message["type"] == "event" && message["kind"] == "recentre";
  });
  ASSERT_NE(told, page.messages().end());
  EXPECT_EQ((*told)["text"],
            fmt::format("re-centring, as udp://127.0.0.1:{} asks by OSC: relax your face and look ahead",
                        headset.local_endpoint().port()));
}

TEST(Engine, ATakeOfTheWholeSessionReplaysToItsBitsAndItEndsByItself) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  EngineSettings asked = settings(folder);
  asked.record = folder / "whole.mien";
  asked.commands.emplace_back(session::Shape{R"({"constraints":true,"rules":"","smoothing":0.25})"});
  asked.seconds = 3;
  Running running(std::move(asked));
  ASSERT_TRUE(running.engine()) << running.engine().error().message();
  const virt::VirtualSession performed = session::test::performance(10);
  Nodes nodes(performed, test::port_of((*running).listening().front()));
  const EngineSummary summary = running.wait();
  nodes.stop();
  EXPECT_GT(summary.frames, 0u);
  EXPECT_THAT(summary.recording_error, IsEmpty());

  const auto take = take::Take::open(folder / "whole.mien");
  ASSERT_TRUE(take) << take.error().message();
  const auto session = session::test::session();
  ASSERT_TRUE(
      session::replay(*take, *session, [](const take::Tick&, const face::OutputFrame&) { return true; }));
  EXPECT_EQ(session->frames(), summary.frames);
  EXPECT_EQ(session->hash(), summary.hash);
  EXPECT_EQ(take->note("live.hash").value(), summary.hash);
  // Its first command too.
  session::Report report;
  session->report(HostTime(), report);
  for (const std::string& shaping : {summary.report.shaping, report.shaping}) {
    EXPECT_EQ(Json::parse(shaping)["rules"], "");
    EXPECT_EQ(Json::parse(shaping)["smoothing"], 0.25);
  }
}

TEST(Engine, OneOfTwoSendersIsChosenOnThePageAndAReplayDoesTheSame) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  EngineSettings asked = settings(folder);
  asked.record = folder / "two.mien";
  asked.page = PageSettings{.host = "127.0.0.1", .port = 0, .token = {}, .assets = {}};
  Running running(std::move(asked));
  ASSERT_TRUE(running.engine()) << running.engine().error().message();
  boost::asio::io_context network;
  PageClient page(network, test::port_of((*running).page()));
  // News is told to the pages that are there.
  ASSERT_TRUE(run_until(network, [&] { return Json(page.last("status")).is_object(); }));
  const virt::VirtualSession performed = session::test::performance(60);
  Nodes nodes(performed, test::port_of((*running).listening().front()), Nodes::Twin::yes);
  const auto chin = [&] {
    Json status = page.last("status");
    return status["links"][0];
  };
  ASSERT_TRUE(run_until(network, [&] {
    Json link = chin();
    return link.is_object() && link["rivals"].size() == 1 && page.frames() > 30;
  }));
  EXPECT_TRUE(run_until(network, [&] { return page.has_event("contested"); }));
  const std::string first = chin()["source"];
  const std::string other = chin()["rivals"][0]["source"];
  EXPECT_THAT(first, HasSubstr("udp://127.0.0.1:"));
  EXPECT_THAT(other, HasSubstr("udp://127.0.0.1:"));
  EXPECT_NE(first, other);
  EXPECT_FALSE(
      page.ask({{"command", "hear"}, {"sensor", "mentalis"}, {"source", "udp://127.0.0.2:1"}})["ok"]);
  EXPECT_TRUE(page.ask({{"command", "hear"}, {"sensor", "mentalis"}, {"source", other}})["ok"]);
  EXPECT_TRUE(run_until(network, [&] {
    const Json link = chin();
    return link["source"] == other && link["rivals"].size() == 1 && link["rivals"][0]["source"] == first;
  }));
  const std::size_t before = page.frames();
  EXPECT_TRUE(run_until(network, [&] { return page.frames() > before + 30; }));
  nodes.stop();
  running.ask_to_stop();
  const EngineSummary summary = running.wait();
  EXPECT_THAT(summary.recording_error, IsEmpty());

  const auto take = take::Take::open(folder / "two.mien");
  ASSERT_TRUE(take) << take.error().message();
  const auto session = session::test::session();
  ASSERT_TRUE(
      session::replay(*take, *session, [](const take::Tick&, const face::OutputFrame&) { return true; }));
  EXPECT_EQ(session->hash(), summary.hash);
  session::Report report;
  session->report(take->ticks().value().back().fired, report);
  EXPECT_EQ(report.links[0].source, other);
}

TEST(Engine, ThePageNarrowsWhatIsListenedOnAndShowsTheKey) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  EngineSettings asked = settings(folder);
  asked.listen = {"udp://0.0.0.0:0", "udp://127.0.0.1:0"};
  asked.page = PageSettings{.host = "127.0.0.1", .port = 0, .token = {}, .assets = {}};
  asked.pair = [] {
    return Result<Pairing>(Pairing{.file = "f", .firmware = "line", .command = "mien live"});
  };
  Running running(std::move(asked));
  ASSERT_TRUE(running.engine()) << running.engine().error().message();
  const std::vector<std::string> listening = (*running).listening();
  boost::asio::io_context network;
  PageClient page(network, test::port_of((*running).page()));
  const auto said = [&] {
    Json status = page.last("status");
    return status.is_object() ? status["network"] : Json();
  };
  ASSERT_TRUE(run_until(network, [&] { return said().is_object(); }));
  EXPECT_EQ(said()["open"], Json({listening.front()})) << "that of one address is not open";
  EXPECT_EQ(said()["only"], "");
  EXPECT_EQ(said()["sealed"], false);
  bool loopback = false;
  const Json interfaces = said()["interfaces"];
  for (const Json& one : interfaces)
    loopback = loopback || (one["address"] == "127.0.0.1" && one["loopback"] == true);
  EXPECT_TRUE(loopback) << said();

  EXPECT_FALSE(page.ask({{"command", "listen"}})["ok"]);
  EXPECT_FALSE(page.ask({{"command", "listen"}, {"only", "no_such_interface"}})["ok"]);
  EXPECT_TRUE(page.ask({{"command", "listen"}, {"only", "127.0.0.2"}})["ok"]);
  EXPECT_TRUE(run_until(network, [&] { return page.has_event("listening"); }));
  udp::socket stranger(network, udp::v4());
  const auto send = [&](const char* to, const std::string& port) {
    stranger.send_to(boost::asio::buffer(std::string("who is there?")),
                     {boost::asio::ip::make_address(to), test::port_of(port)});
  };
  send("127.0.0.1", listening[0]);
  EXPECT_TRUE(run_until(network, [&] { return said()["elsewhere"] == 1; }));
  EXPECT_EQ(said()["only"], "127.0.0.2");
  EXPECT_TRUE(page.ask({{"command", "listen"}, {"only", ""}})["ok"]);
  send("127.0.0.1", listening[0]);
  send("127.0.0.1", listening[1]);
  EXPECT_TRUE(run_until(network, [&] { return said()["only"] == ""; }));

  const Json pairing = page.ask({{"command", "pair"}});
  EXPECT_TRUE(pairing["ok"]);
  EXPECT_EQ(pairing["result"], Json::parse(R"({"file": "f", "firmware": "line", "command": "mien live",
                                              "in_force": false})"));
  running.ask_to_stop();
  const EngineSummary summary = running.wait();
  EXPECT_EQ(summary.listening, listening);
  EXPECT_EQ(summary.network.elsewhere, 1U);
  EXPECT_EQ(summary.dropped, 1U);
}

TEST(Engine, ARecordingAsksForItsPosesWritesThemAndEndsWithThem) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  EngineSettings asked = settings(folder);
  asked.record = folder / "poses.mien";
  asked.ends_with_recording = true;
  asked.page = PageSettings{.host = "127.0.0.1", .port = 0, .token = {}, .assets = {}};
  for (const char* name : {"rest", "open", "shut"}) {
    session::Prompt& prompt = asked.prompts.emplace_back();
    prompt.name = name;
    prompt.seconds = 1;
    if (prompt.name == "open") prompt.target[face::shape("jawOpen")] = 0.5F;
  }
  Running running(std::move(asked));
  ASSERT_TRUE(running.engine()) << running.engine().error().message();
  boost::asio::io_context network;
  PageClient page(network, test::port_of((*running).page()));
  const virt::VirtualSession performed = session::test::performance(60);
  Nodes nodes(performed, test::port_of((*running).listening().front()));
  EXPECT_TRUE(run_until(network, [&] {
    Json prompts = page.last("status")["prompts"];
    return prompts.is_object() && prompts["state"] == "running" && prompts["name"] == "open";
  }));
  Json prompts = page.last("status")["prompts"];
  EXPECT_EQ(prompts["number"], 2);
  EXPECT_EQ(prompts["of"], 3);
  EXPECT_EQ(prompts["target"]["jawOpen"], 0.5);
  EXPECT_EQ(prompts["next"]["name"], "shut");
  EXPECT_TRUE(run_until(network, [&] { return page.last("status")["prompts"]["state"] == "over"; }));
  EXPECT_TRUE(run_until(network, [&] { return page.has_event("recording_over"); }));
  const EngineSummary summary = running.wait();
  nodes.stop();
  EXPECT_THAT(summary.recording_error, IsEmpty());
  EXPECT_EQ(summary.report.prompts.state, "over");

  const auto take = take::Take::open(folder / "poses.mien");
  ASSERT_TRUE(take) << take.error().message();
  EXPECT_TRUE(take->finished());
  const auto events = take->events().value();
  EXPECT_EQ(std::ranges::count(events, "prompt", &take::Event::kind), 3);
  // What is asked for is in the log: a replay comes to the same events.
  const auto session = session::test::session();
  std::vector<take::Event> again;
  ASSERT_TRUE(session::replay(*take, *session, [&](const take::Tick&, const face::OutputFrame&) {
    for (take::Event& event : session->take_events()) again.push_back(std::move(event));
    return true;
  }));
  EXPECT_EQ(session->hash(), summary.hash);
  std::erase_if(again, [](const take::Event& event) { return event.kind != "prompt"; });
  ASSERT_EQ(again.size(), 3u);
  std::size_t i = 0;
  for (const take::Event& event : events) {
    if (event.kind != "prompt") continue;
    EXPECT_EQ(event.begin, again[i].begin);
    EXPECT_EQ(event.end, again[i].end);
    EXPECT_EQ(event.json, again[i++].json);
  }
}

TEST(Engine, FeedsHandOverUntilTheyAreOverFailOrAreStopped) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  EngineSettings asked = settings(folder);
  std::atomic<int> handed = 0;
  std::atomic<bool> was_stopped = false;
  const std::vector<std::byte> rubbish(40, std::byte{7});
  asked.feeds.push_back({"toy:short", [&](FeedPort& out) {
                           for (int i = 0; i < 3; ++i) handed += out.hand_over(rubbish, rubbish) ? 1 : 0;
                         }});
  asked.feeds.push_back({"toy:broken", [](FeedPort&) { throw std::runtime_error("the lens fell off"); }});
  asked.feeds.push_back({"toy:endless", [&](FeedPort& port) {
                           while (!port.stopped()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
                           was_stopped = true;
                         }});
  auto engine = Engine::open(std::move(asked), session::test::session());
  ASSERT_TRUE(engine) << engine.error().message();
  std::vector<std::string> told;
  std::atomic<bool> stop = false;
  EngineListener listener;
  listener.told = [&](const std::string& text) {
    told.push_back(text);
    if (told.size() == 2) stop = true;
  };
  const auto summary = (*engine)->run(stop, listener);
  ASSERT_TRUE(summary) << summary.error().message();
  EXPECT_THAT(told,
              ::testing::UnorderedElementsAre("toy:short is over", "toy:broken ended: the lens fell off"));
  EXPECT_EQ(handed, 3);
  EXPECT_TRUE(was_stopped);
  EXPECT_EQ(summary->datagrams, 3U);
}

TEST(Engine, ShowsWhatACameraSeesToWhoAsksAndLogsNoneOfIt) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  boost::asio::io_context network;
  session::Session::Parts parts;
  parts.rig = headset::test::headset_rig();
  parts.trackers.push_back(headset::HeadsetTracker::create(parts.rig, headset::test::small_model()).value());
  parts.protocols.push_back(std::make_unique<headset::PictureProtocol>());
  const auto tap = std::make_shared<PictureTap>(sensor::parse_device(parts.rig.sensors[1].device).value());

  EngineSettings asked = settings(folder);
  asked.header.rig_toml = headset::test::headset_rig_text();
  asked.page = PageSettings{.host = "127.0.0.1", .port = 0, .token = {}, .assets = {}};
  std::atomic<int> made = 0;
  asked.feeds.push_back({.name = "http://camera/",
                         .run =
                             [&](FeedPort& port) {
                               while (!port.stopped()) {
                                 tap->offer([&](const PictureTap::Wish&, std::span<std::uint8_t> pixels) {
                                   std::ranges::fill(pixels, static_cast<std::uint8_t>(100 + ++made % 100));
                                   return true;
                                 });
                                 std::this_thread::sleep_for(std::chrono::milliseconds(2));
                               }
                             },
                         .heard = false,
                         .tap = tap});
  Running running(std::move(asked), session::Session::create(std::move(parts)).value());
  ASSERT_TRUE(running.engine()) << running.engine().error().message();
  PageClient page(network, test::port_of((*running).page()));
  ASSERT_TRUE(run_until(network, [&] { return !page.last("status").is_null(); }));
  EXPECT_EQ(page.last("status")["pictures"], Json({{"cameras", 1}, {"watchers", 0}}));
  EXPECT_EQ(made, 0);
  EXPECT_EQ(page.ask({{"command", "pictures"}})["ok"], false) << "on or off?";
  EXPECT_EQ(page.ask({{"command", "record"}, {"on", true}, {"name", "seen"}})["ok"], true);
  EXPECT_EQ(page.ask({{"command", "pictures"}, {"on", true}})["ok"], true);
  ASSERT_TRUE(run_until(network, [&] { return page.binary().size() >= 3; }));
  EXPECT_TRUE(page.has_event("pictures")) << "it is said that somebody looks";
  const std::string& picture = page.binary().front();
  ASSERT_EQ(picture.size(), 12U + 96 * 96);
  EXPECT_EQ(picture.substr(0, 12), std::string("MPIC\x01\0\x01\0\x60\0\x60\0", 12));
  EXPECT_EQ(picture[12], 101);
  EXPECT_TRUE(run_until(network, [&] { return page.last("status")["pictures"]["watchers"] == 1; }));
  EXPECT_EQ(page.ask({{"command", "pictures"}, {"on", false}})["ok"], true);
  const std::size_t seen = page.binary().size();
  ASSERT_TRUE(run_until(network, [&] { return page.last("status")["pictures"]["watchers"] == 0; }));
  EXPECT_LE(page.binary().size(), seen + 1) << "but for one on its way";
  EXPECT_EQ(page.ask({{"command", "record"}, {"on", false}, {"name", ""}})["ok"], true);
  ASSERT_TRUE(run_until(network, [&] { return page.has_event("recorded"); }));
  running.ask_to_stop();
  running.wait();
  const auto take = take::Take::open(folder / "seen.mien");
  ASSERT_TRUE(take) << take.error().message();
  EXPECT_THAT(take->entries().value(), IsEmpty()) << "neither the pictures nor that they were asked for";
}

TEST(Engine, SaysWhyItCannotBegin) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  const auto error_of = [&](auto change) {
    EngineSettings asked = settings(folder);
    change(asked);
    const auto engine = Engine::open(std::move(asked), session::test::session());
    return engine ? std::string() : engine.error().message();
  };
  const auto first = Engine::open(settings(folder), session::test::session());
  ASSERT_TRUE(first);
  EXPECT_THAT(error_of([&](EngineSettings& s) { s.listen = (*first)->listening(); }), HasSubstr("--listen"));
  EXPECT_THAT(error_of([](EngineSettings& s) { s.listen = {"udp://nowhere"}; }), HasSubstr("address"));
  EXPECT_THAT(error_of([](EngineSettings& s) { s.feeds = {{"toy", {}}, {"toy", {}}}; }), HasSubstr("twice"));
  EXPECT_THAT(error_of([](EngineSettings& s) { s.out = {"pigeon://127.0.0.1"}; }), HasSubstr("pigeon"));
  EXPECT_THAT(error_of([](EngineSettings& s) {
                s.page = PageSettings{.host = "0.0.0.0", .port = 0, .token = {}, .assets = {}};
              }),
              HasSubstr("token"));
  EXPECT_THAT(error_of([&](EngineSettings& s) { s.record = folder / "no" / "such.mien"; }),
              HasSubstr("folder"));
}

}  // namespace
}  // namespace mien::live::engine_test
