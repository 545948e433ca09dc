// A browser's microphone: what is made of its messages, and of wrong ones; and a whole session that hears
// one.
#include "tests/live/page_client.h"

#include "app/live/page_microphone.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "app/live/running_session.h"
#include "mien/core/files.h"
#include "mien/live/intake.h"
#include "mien/modalities/modalities.h"
#include "mien/session/replay.h"
#include "mien/speech/sound_block.h"
#include "mien/take/take.h"
#include "tests/folder.h"
#include "tests/project_path.h"

namespace mien::app::test::page_microphone_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Clock = PageSound::Clock;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::uint64_t kDevice = speech::kThisMachine;

/// Samples `count` to `count + length` of a tone.
speech::SoundMessage tone(int rate_hz, std::uint64_t count, std::size_t length, double loud = 0.2) {
  speech::SoundMessage out{.rate_hz = rate_hz, .count = count, .samples = std::vector<std::int16_t>(length)};
  for (std::size_t i = 0; i < length; ++i)
    out.samples[i] = static_cast<std::int16_t>(
        32'767 * loud * std::sin(2 * std::numbers::pi * 200 * static_cast<double>(count + i) / rate_hz));
  return out;
}

/// A feed's end, and what came out of it.
struct PageSoundTest : ::testing::Test {
  PageSoundTest() : start(Clock::now()), sound(kDevice, port, start) {}

  bool send(const speech::SoundMessage& message, Clock::duration after, std::uint64_t client = 1) {
    const bool taken = sound.take(client, speech::encode_message(message), start + after);
    drain();
    return taken;
  }
  /// 20 ms each, from `from` on, each when it has been spoken; how many were taken.
  int stream(int rate_hz, int from, int to, Clock::duration late = {}, double loud = 0.2) {
    int taken = 0;
    const auto length = static_cast<std::uint64_t>(rate_hz / 50);
    for (int i = from; i < to; ++i)
      taken += send(tone(rate_hz, length * static_cast<std::uint64_t>(i), length, loud),
                    milliseconds(20) * (i + 1) + late)
                   ? 1
                   : 0;
    return taken;
  }
  void drain() {
    while (const auto waiting = source.front()) {
      const auto header = speech::parse_header(waiting->datagram);
      EXPECT_TRUE(header);
      EXPECT_EQ(header->device, kDevice);
      const auto block = speech::samples_of(waiting->payload);
      EXPECT_TRUE(block);
      blocks.push_back(header->block);
      loudness.push_back(speech::loudness_of(*block).peak);
      source.release();
    }
  }
  [[nodiscard]] std::size_t rises() const {
    std::size_t wrong = 0;
    for (std::size_t i = 1; i < blocks.size(); ++i) wrong += blocks[i] > blocks[i - 1] ? 0 : 1;
    return wrong;
  }

  live::Signal awake;
  live::PayloadSource source{0, [] { return HostTime(); }, awake};
  std::atomic<bool> stop = false;
  std::atomic<bool> wanted = true;
  std::vector<std::string> told;
  live::FeedPort::Tell tell = [this](const std::string& kind, const std::string&) { told.push_back(kind); };
  live::FeedPort port{source, stop, wanted, tell};
  Clock::time_point start;
  PageSound sound;
  std::vector<std::uint64_t> blocks;
  std::vector<float> loudness;
};

TEST_F(PageSoundTest, OfAnyRateItBecomesBlocksNumberedOnTheMachinesClock) {
  for (const int rate_hz : {8'000, 44'100, 48'000, 192'000}) {
    blocks.clear();
    loudness.clear();
    // Each rate begins a stream anew, seconds later than the one before.
    const auto late = seconds(10) * (rate_hz / 8'000);
    EXPECT_EQ(stream(rate_hz, 0, 100, late), 100) << rate_hz;
    ASSERT_GE(blocks.size(), 97U) << rate_hz;
    EXPECT_LE(blocks.size(), 100U) << rate_hz;
    EXPECT_GE(blocks.front(), static_cast<std::uint64_t>(late / milliseconds(20)));
    EXPECT_EQ(blocks.back() - blocks.front(), blocks.size() - 1) << "none is left out";
    for (std::size_t i = 5; i < loudness.size(); ++i) EXPECT_NEAR(loudness[i], 0.2, 0.03) << rate_hz;
  }
  EXPECT_THAT(told, IsEmpty());
  EXPECT_EQ(port.state().trouble, "");
}

TEST_F(PageSoundTest, AGapIsCountedOverAndShortOnesAreFilled) {
  EXPECT_EQ(stream(16'000, 0, 50), 50);
  EXPECT_EQ(stream(16'000, 75, 100), 25) << "half a second was lost";
  ASSERT_EQ(blocks.size(), 75U);
  EXPECT_EQ(blocks[50] - blocks[49], 26U);
  // Half a block was lost: silence stands for it.
  EXPECT_TRUE(send(tone(16'000, 100 * 320 + 160, 320), milliseconds(2030)));
  EXPECT_TRUE(send(tone(16'000, 101 * 320 + 160, 160), milliseconds(2040)));
  ASSERT_EQ(blocks.size(), 77U);
  EXPECT_EQ(blocks.back() - blocks.front(), 101U);
  EXPECT_EQ(stream(16'000, 102, 200), 98);
  EXPECT_EQ(rises(), 0U);
}

TEST_F(PageSoundTest, MoreThanRealTimeIsRefusedAndToldOnce) {
  int taken = 0;
  for (std::uint64_t i = 0; i < 1'000; ++i) taken += send(tone(16'000, 320 * i, 320), {}) ? 1 : 0;
  EXPECT_LE(taken, 51) << "a second at once";
  EXPECT_GE(taken, 49);
  EXPECT_THAT(told, ElementsAre("microphone_failed"));
  EXPECT_THAT(port.state().trouble, HasSubstr("refused"));
  // Twenty thousand empty-handed ones a second: each counts for something.
  taken = 0;
  for (std::uint64_t i = 0; i < 20'000; ++i)
    taken += send(tone(16'000, i, 1), seconds(10) + std::chrono::microseconds(50) * i, 2) ? 1 : 0;
  EXPECT_LE(taken, 410);
  EXPECT_LE(blocks.size(), 115U) << "what they claim is a second and a quarter";
}

TEST_F(PageSoundTest, WhatStandsElsewhereIsRefusedUntilItStays) {
  EXPECT_EQ(stream(16'000, 0, 100), 100);
  EXPECT_FALSE(send(tone(16'000, 16'000 * 9, 320), milliseconds(2020))) << "from the future";
  EXPECT_FALSE(send(tone(16'000, speech::kMostSamples - 1, 320), milliseconds(2030)));
  EXPECT_FALSE(send(tone(16'000, 320 * 60, 320), milliseconds(2040))) << "repeated";
  EXPECT_EQ(stream(16'000, 102, 150), 48) << "and it goes on";
  EXPECT_THAT(port.state().trouble, IsEmpty());
  // A line that was held up for 1.5 s brings the old sound at once: what is too late is left out.
  int taken = 0;
  for (int i = 150; i < 225; ++i)
    taken += send(tone(16'000, 320 * static_cast<std::uint64_t>(i), 320), milliseconds(4510)) ? 1 : 0;
  EXPECT_GE(taken, 40);
  EXPECT_LE(taken, 51);
  EXPECT_EQ(rises(), 0U);
  // A browser that slept for ten seconds and counts on: after two it is taken at its word, on the clock.
  EXPECT_NEAR(stream(16'000, 225, 425, seconds(10)), 100, 5);
  EXPECT_GE(blocks.back(), static_cast<std::uint64_t>(seconds(18) / milliseconds(20)));
  EXPECT_EQ(rises(), 0U);
  EXPECT_THAT(told, ElementsAre("microphone_failed")) << "once a client";
}

TEST_F(PageSoundTest, AClockThatRunsFastIsFollowed) {
  // In a quarter of an hour it is further off than any one message may be.
  const double fast = 1 + 1500e-6;
  speech::SoundMessage piece = tone(16'000, 0, 1'600);
  int refused = 0;
  for (int i = 0; i < 9'000; ++i, piece.count += 1'600) {
    const auto when =
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(0.1 * (i + 1) / fast));
    refused += send(piece, when) ? 0 : 1;
  }
  EXPECT_EQ(refused, 0);
  EXPECT_EQ(blocks.back() - blocks.front(), blocks.size() - 1) << "no block is left out";
}

TEST_F(PageSoundTest, SilenceAndNothingAreTold) {
  EXPECT_EQ(stream(16'000, 0, 249, {}, 0), 249);
  EXPECT_THAT(told, IsEmpty());
  EXPECT_EQ(stream(16'000, 249, 260, {}, 0), 11);
  EXPECT_THAT(told, ElementsAre("microphone_silent"));
  EXPECT_THAT(port.state().trouble, HasSubstr("silent for 5 s"));
  EXPECT_EQ(stream(16'000, 260, 262), 2);
  EXPECT_THAT(told, ElementsAre("microphone_silent", "microphone_heard"));
  EXPECT_EQ(port.state().trouble, "");

  told.clear();
  sound.look(1, start + seconds(6));
  sound.look(1, start + seconds(8));
  EXPECT_THAT(told, IsEmpty());
  sound.look(1, start + seconds(9));
  sound.look(1, start + seconds(30));
  EXPECT_THAT(told, ElementsAre("microphone_lost"));
  EXPECT_THAT(port.state().trouble, HasSubstr("nothing comes"));
  sound.look(0, start + seconds(31));
  EXPECT_EQ(port.state().trouble, "") << "nobody is to be heard";
  sound.look(0, start + seconds(60));
  EXPECT_EQ(told.size(), 1U);
}

TEST_F(PageSoundTest, ARefusalAndASilenceDoNotHideEachOthersEnd) {
  EXPECT_EQ(stream(16'000, 0, 260, {}, 0), 260);
  EXPECT_THAT(port.state().trouble, HasSubstr("silent for 5 s"));
  EXPECT_FALSE(send(tone(16'000, 320 * 250, 320, 0), milliseconds(5210)));
  EXPECT_THAT(port.state().trouble, HasSubstr("it repeats what was heard; press Stop"));
  EXPECT_EQ(stream(16'000, 260, 261, {}, 0), 1);
  EXPECT_THAT(port.state().trouble, HasSubstr("silent for 5 s")) << "it still is";
  EXPECT_THAT(told, ElementsAre("microphone_silent", "microphone_failed")) << "and was told";
  EXPECT_FALSE(send(tone(16'000, 320 * 250, 320, 0), milliseconds(5230)));
  EXPECT_EQ(stream(16'000, 261, 262), 1) << "sound ends both";
  EXPECT_EQ(port.state().trouble, "");

  // A stream that begins anew has not been silent yet, and is told of in its turn.
  const auto late = seconds(11);
  EXPECT_EQ(stream(16'000, 262, 530, {}, 0), 268);
  EXPECT_THAT(port.state().trouble, HasSubstr("silent for 5 s"));
  told.clear();
  EXPECT_EQ(stream(16'000, 0, 249, late, 0), 249);
  EXPECT_THAT(told, IsEmpty());
  EXPECT_EQ(port.state().trouble, "");
  EXPECT_EQ(stream(16'000, 249, 260, late, 0), 11);
  EXPECT_THAT(told, ElementsAre("microphone_silent"));
  EXPECT_THAT(port.state().trouble, HasSubstr("silent for 5 s"));
  sound.look(1, start + seconds(17));
  EXPECT_EQ(port.state().trouble, "") << "another is to be heard";
}

TEST_F(PageSoundTest, WhatCameBeforeItBeganIsOfTheFirstBlock) {
  // The network's thread may stamp a message while the feed's thread still begins.
  EXPECT_TRUE(send(tone(16'000, 0, 320), -milliseconds(50)));
  EXPECT_EQ(stream(16'000, 1, 5), 4);
  EXPECT_THAT(blocks, ElementsAre(0, 1, 2, 3, 4));
}

TEST_F(PageSoundTest, FullScaleConstantAndUnreadableSoundHarmNothing) {
  speech::SoundMessage loud{.rate_hz = 48'000, .count = 0, .samples = std::vector<std::int16_t>(4'800)};
  for (int i = 0; i < 20; ++i) {
    loud.count = 4'800 * static_cast<std::uint64_t>(i);
    std::ranges::fill(loud.samples, static_cast<std::int16_t>(i % 2 == 0 ? -32'768 : 32'767));
    EXPECT_TRUE(send(loud, milliseconds(100) * (i + 1)));
  }
  EXPECT_GE(blocks.size(), 95U);
  for (const char* bytes : {"", "MSND", "not a sound at all, but long enough"}) {
    EXPECT_FALSE(sound.take(1, std::as_bytes(std::span(std::string_view(bytes))), start + seconds(3)));
    EXPECT_THAT(port.state().trouble, HasSubstr("; load the page anew"));
  }
  EXPECT_THAT(told, ElementsAre("microphone_failed"));
  EXPECT_FALSE(sound.take(2, {}, start + seconds(3)));
  EXPECT_EQ(told.size(), 2U) << "of each client once";
  EXPECT_TRUE(send(tone(48'000, 0, 960), seconds(4)));
  EXPECT_EQ(port.state().trouble, "") << "and a new beginning is heard";
  drain();
  EXPECT_EQ(rises(), 0U);
}

/// A session with one microphone, a browser's, and a page.
struct PageSession {
  explicit PageSession(const std::filesystem::path& take) {
    const std::string file = project_path("rigs/microphone.toml");
    const std::string toml = read_text(file).value();
    const sensor::Rig rig = sensor::parse_rig(toml, file).value();
    model = modalities::live_model(rig, "").value();
    live::EngineSettings settings;
    settings.listen = {"udp://127.0.0.1:0"};
    settings.feeds.push_back(page_feed(kDevice));
    settings.record = take;
    settings.takes = take.parent_path();
    settings.page = live::PageSettings{.host = "127.0.0.1", .port = 0, .token = {}, .assets = {}};
    settings.model = model.filename().string();
    settings.header.software = "mien 0.0.0";
    settings.header.rig_toml = toml;
    settings.header.prologue = "none";
    engine = live::Engine::open(std::move(settings), modalities::make_session(rig, model).value()).value();
  }
  std::filesystem::path model;
  std::unique_ptr<live::Engine> engine;
};

TEST(PageMicrophone, ASessionHearsABrowserAndItsReplayTheSame) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  const PageSession session(folder / "heard.mien");
  RunningSession running(*session.engine);
  boost::asio::io_context network;
  live::test::PageClient client(network, live::test::port_of(session.engine->page()));
  const auto hearing = [&] {
    const auto status = client.last("status");
    return status.is_object() && status["hearing"].is_object() ? status["hearing"] : nlohmann::json::object();
  };
  const auto wait_for = [&](auto done) { EXPECT_TRUE(mien::test::run_until(network, done)); };
  wait_for([&] { return hearing().value("on", false); });
  EXPECT_EQ(client.ask({{"command", "microphone"}})["ok"], false) << "on is missing";
  EXPECT_EQ(client.ask({{"command", "microphone"}, {"on", true}})["ok"], true);
  const auto begun = Clock::now();
  std::uint64_t sent = 0;
  double loudest = 0;
  // What a browser of the session's own rate would send: a message is a block.
  const auto speak = [&] {
    const auto now = static_cast<std::uint64_t>((Clock::now() - begun) / milliseconds(20));
    for (; sent < now; ++sent) client.send(speech::encode_message(tone(16'000, 320 * sent, 320)));
    const auto status = client.last("status");
    if (status.is_object() && status["links"][0]["level"].is_number())
      loudest = std::max(loudest, status["links"][0]["level"].get<double>());
  };
  wait_for([&] {
    speak();
    return hearing().value("blocks", 0) >= 60;
  });
  EXPECT_GT(loudest, 0.5);
  EXPECT_EQ(hearing()["browser"]["heard"], true);

  // All that was sent has come through, so that nothing is under way when the switch is thrown. A machine
  // that stood still for a second has refused some.
  wait_for([&] {
    const auto now = hearing();
    return now["blocks"].get<std::uint64_t>() + now["browser"]["refused"].get<std::uint64_t>() == sent;
  });

  // Switched off: the browser is told to stop, and what it sends all the same is not heard.
  EXPECT_EQ(client.ask({{"command", "shape"}, {"merge", {{"audio", false}}}})["ok"], true);
  wait_for([&] { return !client.last("microphone").is_null(); });
  wait_for([&] { return !hearing().value("on", true) && hearing()["browser"]["heard"] == false; });
  const int blocks = hearing()["blocks"].get<int>();
  const int refused = hearing()["browser"]["refused"].get<int>();
  wait_for([&] {
    speak();
    return hearing()["browser"]["refused"].get<int>() > refused + 20;
  });
  EXPECT_EQ(hearing()["blocks"].get<int>(), blocks);

  const auto summary = running.finish();
  ASSERT_TRUE(summary) << summary.error().message();
  EXPECT_EQ(summary->datagrams, static_cast<std::uint64_t>(blocks));
  EXPECT_EQ(summary->malformed, 0U);
  const auto take = take::Take::open(folder / "heard.mien");
  ASSERT_TRUE(take) << take.error().message();
  EXPECT_EQ(take->samples().value().size(), static_cast<std::size_t>(blocks));
  const auto again = modalities::make_session(take->rig(), session.model).value();
  ASSERT_TRUE(session::replay(*take, *again, [](const auto&, const auto&) { return true; }));
  EXPECT_EQ(again->hash(), summary->hash);
}

}  // namespace
}  // namespace mien::app::test::page_microphone_test
