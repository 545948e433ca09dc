// Video in a whole session: a dataset is begun from a page, which sends its camera meanwhile.
#include "tests/live/page_client.h"

#include "mien/live/engine.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "mien/live/video_message.h"
#include "mien/take/take.h"
#include "tests/folder.h"
#include "tests/hex.h"
#include "tests/session/session_run.h"

namespace mien::live::video_session_test {
namespace {

using test::PageClient;
using test::run_until;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Json = nlohmann::json;

std::vector<std::byte> chunk(std::uint32_t sequence, std::size_t bytes) {
  std::vector<std::byte> data = mien::bytes_of("1a45dfa3");
  data.resize(bytes);
  return encode_video_message(
      {.container = VideoContainer::webm, .sequence = sequence, .age_ms = 1000 * sequence, .data = data});
}

Result<std::vector<RecordingScript>> one_script() {
  RecordingScript script{"short", {}};
  script.script.name = "Short";
  session::Prompt& prompt = script.script.prompts.emplace_back();
  prompt.name = "one";
  prompt.text = "Read this.";
  prompt.block = "calm";
  prompt.seconds = 3;
  prompt.own_pace = true;
  return std::vector{std::move(script)};
}

struct VideoSession : ::testing::Test {
  void SetUp() override {
    EngineSettings settings;
    settings.listen = {"udp://127.0.0.1:0"};
    settings.takes = folder.path();
    settings.header.software = "test";
    settings.header.rig_toml = virt::test::kRig;
    settings.scripts = one_script;
    settings.page = PageSettings{.host = "127.0.0.1", .port = 0, .token = {}, .assets = {}};
    auto opened = Engine::open(std::move(settings), session::test::session());
    ASSERT_TRUE(opened) << opened.error().message();
    engine = *std::move(opened);
    port = test::port_of(engine->page());
    thread = std::jthread([this] { summary = engine->run(stop, EngineListener()); });
  }
  void TearDown() override { stop = true; }

  static Json begin_command(bool video) {
    return {{"command", "dataset"},
            {"begin",
             {{"name", "faces"},
              {"script", "short"},
              {"performer", "Anna"},
              {"recorded_by", "us"},
              {"purpose", "a model"},
              {"sound", false},
              {"video", video},
              {"agreed", true},
              {"pace", "key"}}}};
  }
  /// Begins one; the take's path.
  std::filesystem::path begin(PageClient& page, bool video) {
    Json begun = page.ask(begin_command(video));
    EXPECT_EQ(begun["ok"], true) << begun;
    return begun["result"]["take"].get<std::string>();
  }
  [[nodiscard]] static Json video_of(const PageClient& page) {
    Json status = page.last("status");
    return status.is_object() ? status["video"] : Json();
  }
  std::vector<take::Event> video_events(const std::filesystem::path& path) {
    const auto take = take::Take::open(path);
    EXPECT_TRUE(take) << take.error().message();
    if (!take) return {};
    EXPECT_TRUE(take->finished());
    std::vector<take::Event> events = take->events().value();
    std::erase_if(events, [](const take::Event& event) { return !event.kind.starts_with("video"); });
    return events;
  }

  const mien::test::Folder folder;
  boost::asio::io_context network;
  std::unique_ptr<Engine> engine;
  std::uint16_t port = 0;
  std::atomic<bool> stop = false;
  Result<EngineSummary> summary = EngineSummary();
  std::jthread thread;
};

/// The reply to a command of that number.
Json reply_of(boost::asio::io_context& network, const PageClient& page, int number) {
  Json reply;
  EXPECT_TRUE(run_until(network, [&] {
    for (const Json& message : page.messages())
      if (message["type"] == "reply" && message["id"] == number) reply = message;
    return !reply.is_null();
  })) << number;
  return reply;
}

TEST_F(VideoSession, AnEndRightAfterTheBeginningEndsIt) {
  PageClient page(network, port);
  ASSERT_TRUE(run_until(network, [&] { return !page.last("status").is_null(); }));
  int number = 1000;
  for (const Json& end :
       {Json{{"command", "dataset"}, {"end", true}}, Json{{"command", "record"}, {"on", false}}}) {
    Json begin = begin_command(false);
    begin["id"] = ++number;
    page.say(begin.dump());
    EXPECT_EQ(page.ask(end)["ok"], true);
    // It had not begun, or is ended.
    const Json reply = reply_of(network, page, number);
    if (reply["ok"] == false) {
      EXPECT_THAT(reply["error"].get<std::string>(), HasSubstr("ended before it began"));
    }
    const auto statuses = [&] {
      return std::ranges::count_if(page.messages(),
                                   [](const Json& message) { return message["type"] == "status"; });
    };
    // What was told before may be older.
    const auto known = statuses();
    EXPECT_TRUE(run_until(network, [&] {
      if (statuses() < known + 2) return false;
      const Json status = page.last("status");
      return status["recording"]["on"] == false &&
             (status["dataset"].is_null() || status["dataset"]["over"] == true) &&
             (status["prompts"].is_null() || status["prompts"]["state"] != "block");
    })) << page.last("status");
  }
}

TEST_F(VideoSession, EveryRecordingIsToldToBeWrittenHoweverSoonTheNextBegins) {
  PageClient page(network, port);
  ASSERT_TRUE(run_until(network, [&] { return !page.last("status").is_null(); }));
  constexpr int kTakes = 5;
  for (int i = 0; i < kTakes; ++i) {
    EXPECT_EQ(page.ask({{"command", "record"}, {"on", true}, {"name", ""}})["ok"], true);
    EXPECT_EQ(page.ask({{"command", "record"}, {"on", false}})["ok"], true);
  }
  const auto written = [&] {
    return std::ranges::count_if(page.messages(), [](const Json& message) {
      return message["type"] == "event" && message["kind"] == "recorded";
    });
  };
  EXPECT_TRUE(run_until(network, [&] { return written() == kTakes; })) << written();
}

TEST_F(VideoSession, AnAnswerHasTheNumberOfWhatIsNoCommand) {
  PageClient page(network, port);
  ASSERT_TRUE(run_until(network, [&] { return !page.last("status").is_null(); }));
  page.say(R"({"id": 41, "command": 5})");
  EXPECT_EQ(reply_of(network, page, 41)["ok"], false);
}

TEST_F(VideoSession, StandsBesideTheTakeAndInItsLog) {
  PageClient page(network, port);
  ASSERT_TRUE(run_until(network, [&] { return !page.last("status").is_null(); }));
  EXPECT_EQ(page.ask({{"command", "video"}, {"on", true}})["ok"], false) << "nothing is recorded";
  const std::filesystem::path take = begin(page, true);
  ASSERT_EQ(page.ask({{"command", "video"}, {"on", true}})["ok"], true);
  page.send(chunk(0, 300'000));
  page.send(chunk(1, 400'000));
  ASSERT_TRUE(run_until(network, [&] {
    Json video = video_of(page);
    return video.is_object() && video["on"] == true && video["megabytes"] == 0.7;
  }));
  EXPECT_EQ(video_of(page)["file"], take.stem().string() + ".webm");

  // The recording ends when the page has sent the last.
  EXPECT_EQ(page.ask({{"command", "dataset"}, {"end", true}})["ok"], true);
  ASSERT_TRUE(run_until(network, [&] { return !page.last("video").is_null(); }));
  EXPECT_EQ(page.last("video"), Json::parse(R"({"type":"video","on":false,"why":"","again":false})"));
  page.send(chunk(2, 500));
  EXPECT_EQ(page.ask({{"command", "video"}, {"on", false}})["ok"], true);
  ASSERT_TRUE(run_until(network, [&] { return page.has_event("recorded"); }));
  EXPECT_EQ(std::filesystem::file_size(std::filesystem::path(take).replace_extension(".webm")), 700'500U);
  const auto events = video_events(take);
  ASSERT_EQ(events.size(), 2U);
  Json first = Json::parse(events[0].json), last = Json::parse(events[1].json);
  EXPECT_EQ(events[0].kind, "video");
  EXPECT_EQ(first["file"], take.stem().string() + ".webm");
  EXPECT_GT(first["received_s"], 0);
  EXPECT_EQ(events[1].kind, "video_over");
  EXPECT_EQ(last["bytes"], 700'500);
  EXPECT_EQ(last["ended"], "the recording is over");
}

TEST_F(VideoSession, IsNotTakenWithoutConsentNorFromTwo) {
  PageClient page(network, port), other(network, port);
  ASSERT_TRUE(
      run_until(network, [&] { return !page.last("status").is_null() && !other.last("status").is_null(); }));
  const std::filesystem::path without = begin(page, false);
  EXPECT_EQ(page.ask({{"command", "video"}, {"on", true}})["ok"], false);
  page.send(chunk(0, 1000));
  ASSERT_TRUE(run_until(network, [&] { return page.has_event("video_failed"); }));
  ASSERT_TRUE(run_until(network, [&] {
    Json video = video_of(page);
    return video.is_object() && video["refused"] == 1 && video["agreed"] == false;
  }));
  EXPECT_EQ(page.ask({{"command", "dataset"}, {"end", true}})["ok"], true);
  ASSERT_TRUE(run_until(network, [&] { return page.has_event("recorded"); }));
  EXPECT_FALSE(std::filesystem::exists(std::filesystem::path(without).replace_extension(".webm")));

  const std::filesystem::path with = begin(page, true);
  ASSERT_EQ(page.ask({{"command", "video"}, {"on", true}})["ok"], true);
  page.send(chunk(0, 1000));
  Json refused = other.ask({{"command", "video"}, {"on", true}});
  EXPECT_EQ(refused["ok"], false);
  EXPECT_THAT(refused["error"].get<std::string>(), HasSubstr("another browser's camera"));
  // A page that withdraws the consent ends it.
  EXPECT_EQ(page.ask({{"command", "consent_over"}})["ok"], true);
  ASSERT_TRUE(run_until(network, [&] { return video_of(page)["agreed"] == false; }));
  EXPECT_EQ(page.ask({{"command", "video"}, {"on", false}})["ok"], true);
  stop = true;
  thread.join();
  ASSERT_TRUE(summary) << summary.error().message();
  const auto events = video_events(with);
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(Json::parse(events[1].json)["bytes"], 1000);
}

TEST_F(VideoSession, AChunkThatIsTooLongIsToldAndABrowserThatIsGoneMayComeBack) {
  std::filesystem::path take;
  {
    PageClient page(network, port);
    ASSERT_TRUE(run_until(network, [&] { return !page.last("status").is_null(); }));
    take = begin(page, true);
    ASSERT_EQ(page.ask({{"command", "video"}, {"on", true}})["ok"], true);
    page.send(chunk(0, kMaxVideoChunk + 1));
    ASSERT_TRUE(run_until(network, [&] { return page.has_event("video_failed"); }));
    EXPECT_FALSE(page.ended()) << "it is told, and not dropped";
    page.send(chunk(0, 1000));
    ASSERT_TRUE(run_until(network, [&] { return video_of(page)["on"] == true; }));
  }
  PageClient again(network, port);
  ASSERT_TRUE(run_until(network, [&] {
    Json video = video_of(again);
    return video.is_object() && video["on"] == false;
  }));
  ASSERT_EQ(again.ask({{"command", "video"}, {"on", true}})["ok"], true);
  again.send(chunk(0, 2000));
  ASSERT_TRUE(run_until(network, [&] { return video_of(again)["files"] == 2; }));
  // The session ends: what came is kept.
  stop = true;
  thread.join();
  ASSERT_TRUE(summary) << summary.error().message();
  EXPECT_EQ(std::filesystem::file_size(take.parent_path() / (take.stem().string() + ".webm")), 1000U);
  EXPECT_EQ(std::filesystem::file_size(take.parent_path() / (take.stem().string() + "_2.webm")), 2000U);
  const auto events = video_events(take);
  ASSERT_EQ(events.size(), 4U);
  EXPECT_THAT(Json::parse(events[1].json)["ended"].get<std::string>(), HasSubstr("gone"));
}

}  // namespace
}  // namespace mien::live::video_session_test
