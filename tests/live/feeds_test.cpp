// Which browser a session hears: asked for over the page's own server, by another than our own code.
#include "tests/live/page_client.h"

#include "mien/live/feeds.h"

#include <gmock/gmock.h>

#include "mien/live/intake.h"
#include "mien/live/page_messages.h"
#include "mien/live/page_server.h"

namespace mien::live::feeds_test {
namespace {

using test::PageClient;
using test::run_until;
using ::testing::HasSubstr;

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text));
}

TEST(PageInlet, TakesOneClientsMessagesAndNoMoreThanItHasRoomFor) {
  PageInlet inlet;
  const auto now = PageInlet::Clock::now();
  EXPECT_FALSE(inlet.offer(7, bytes_of("early"), now)) << "nobody was let in";
  EXPECT_FALSE(inlet.offer(0, bytes_of("nobody"), now));
  inlet.admit(7);
  EXPECT_FALSE(inlet.offer(8, bytes_of("other"), now));
  EXPECT_TRUE(inlet.offer(7, bytes_of("one"), now));
  EXPECT_TRUE(inlet.offer(7, {}, now));
  EXPECT_EQ(inlet.refused(), 3U);
  ASSERT_TRUE(inlet.front());
  EXPECT_EQ(inlet.front()->client, 7U);
  EXPECT_EQ(inlet.front()->arrival, now);
  EXPECT_TRUE(std::ranges::equal(inlet.front()->bytes, bytes_of("one")));
  inlet.release();
  EXPECT_TRUE(inlet.front()->bytes.empty());
  inlet.release();
  EXPECT_FALSE(inlet.front());
  // Nobody takes them: what waits is bounded.
  const std::vector<std::byte> large(40'000);
  std::size_t taken = 0;
  while (inlet.offer(7, large, now)) ++taken;
  EXPECT_LE(taken * large.size(), PageInlet::kQueueBytes);
  EXPECT_GE((taken + 2) * large.size(), PageInlet::kQueueBytes / 2);
}

struct FeedsTest : ::testing::Test {
  void open(bool wanted, bool shut, std::shared_ptr<PageInlet> inlet) {
    std::vector<Feed> all;
    if (!shut)
      all.push_back({"microphone:page", [](FeedPort& out) { out.trouble("no sound"); }, std::move(inlet)});
    ASSERT_TRUE(feeds.open(std::move(all), wanted, shut, intake));
    auto made = PageServer::open(
        network, PageSettings{.host = "127.0.0.1", .port = 0, .token = {}, .assets = {}},
        [] { return std::string(R"({"type": "hello"})"); },
        [this](std::uint64_t client, std::string_view text) { say(client, text); },
        [this](std::uint64_t client, std::span<const std::byte> bytes) { feeds.take(client, bytes); });
    ASSERT_TRUE(made) << made.error().message();
    page = *std::move(made);
    port = test::port_of(page->address());
  }
  void say(std::uint64_t client, std::string_view text) {
    const auto command = nlohmann::json::parse(text);
    const auto done = feeds.microphone(client, command["on"].get<bool>(), *page);
    page->send(client, reply_json(command["id"].get<std::int64_t>(), done ? "" : done.error().message()));
  }

  boost::asio::io_context network;
  Intake intake{network, [] { return HostTime(); }};
  std::unique_ptr<PageServer> page;
  Feeds feeds;
  std::uint16_t port = 0;
};

const nlohmann::json kOn = {{"command", "microphone"}, {"on", true}};
const nlohmann::json kOff = {{"command", "microphone"}, {"on", false}};

TEST_F(FeedsTest, OneBrowserIsHeardUntilItStopsIsReplacedGoesOrIsSwitchedOff) {
  const auto inlet = std::make_shared<PageInlet>();
  open(true, false, inlet);
  PageClient one(network, port);
  auto two = std::make_unique<PageClient>(network, port);
  one.send(bytes_of("unasked"));
  EXPECT_TRUE(run_until(network, [&] { return inlet->refused() == 1; }));
  EXPECT_EQ(one.ask(kOn)["ok"], true);
  EXPECT_TRUE(feeds.state().browser->heard);
  one.send(bytes_of("sound"));
  EXPECT_TRUE(run_until(network, [&] { return inlet->front().has_value(); }));
  EXPECT_TRUE(std::ranges::equal(inlet->front()->bytes, bytes_of("sound")));

  EXPECT_EQ(two->ask(kOn)["ok"], true);
  EXPECT_TRUE(run_until(network, [&] { return !one.last("microphone").is_null(); }));
  EXPECT_EQ(one.last("microphone")["on"], false);
  EXPECT_THAT(one.last("microphone")["why"].get<std::string>(), HasSubstr("Another browser"));
  one.send(bytes_of("still me"));
  EXPECT_TRUE(run_until(network, [&] { return inlet->refused() == 2; }));
  EXPECT_EQ(one.ask(kOff)["ok"], true);
  EXPECT_TRUE(feeds.state().browser->heard) << "the other one is";

  two.reset();
  EXPECT_TRUE(run_until(network, [&] { return page->clients() == 1; }));
  feeds.look(std::nullopt, page.get());
  EXPECT_FALSE(feeds.state().browser->heard) << "it is gone";

  EXPECT_EQ(one.ask(kOn)["ok"], true);
  EXPECT_EQ(one.ask(kOff)["ok"], true);
  EXPECT_FALSE(feeds.state().browser->heard);

  EXPECT_EQ(one.ask(kOn)["ok"], true);
  feeds.look(false, page.get());
  EXPECT_FALSE(feeds.state().browser->heard);
  EXPECT_TRUE(run_until(network, [&] { return one.last("microphone")["why"] == ""; }));
  const auto refused = one.ask(kOn);
  EXPECT_EQ(refused["ok"], false);
  EXPECT_THAT(refused["error"].get<std::string>(), HasSubstr("switched off"));
  feeds.look(true, page.get());
  EXPECT_EQ(one.ask(kOn)["ok"], true);
  EXPECT_EQ(feeds.state().browser->refused, 2U);
}

TEST_F(FeedsTest, AShutSessionAndOneOfOtherFeedsHearNoBrowser) {
  open(false, true, nullptr);
  PageClient client(network, port);
  EXPECT_THAT(client.ask(kOn)["error"].get<std::string>(), HasSubstr("--no-audio"));
  client.send(bytes_of("sound"));
  EXPECT_EQ(client.ask(kOff)["ok"], false) << "and it is still there";
  EXPECT_TRUE(feeds.state().shut);
  EXPECT_FALSE(feeds.state().browser);
}

TEST_F(FeedsTest, WhatStandsAgainstHearingIsKept) {
  open(true, false, nullptr);
  EXPECT_EQ(feeds.state().trouble, "");
  feeds.begin([](const std::string&, const std::string&) {});
  EXPECT_TRUE(run_until(network, [&] { return feeds.state().trouble == "no sound"; }));
  PageClient client(network, port);
  EXPECT_THAT(client.ask(kOn)["error"].get<std::string>(), HasSubstr("--audio page"));
  feeds.end();
}

}  // namespace
}  // namespace mien::live::feeds_test
