// What cameras see, for pages that ask: nobody else gets it, nothing is made while nobody looks, and a page
// that goes is forgotten.
#include "tests/live/page_client.h"

#include "mien/live/page_pictures.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "mien/core/encoding.h"
#include "mien/live/page_messages.h"
#include "mien/live/page_server.h"

namespace mien::live::test::page_pictures_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kToken = "0123456789abcdef";

struct PagePicturesTest : ::testing::Test {
  PagePicturesTest() {
    const std::vector<Feed> feeds = {{.name = "sound:talk.wav", .run = {}},
                                     {.name = "http://a/", .run = {}, .heard = false, .tap = left},
                                     {.name = "http://b/", .run = {}, .heard = false, .tap = right}};
    pictures.open(feeds);
    links.resize(2);
    links[0].device = left->device();
    links[1].device = right->device();
    for (session::Report::Link& link : links)
      link.view = {.crop = {0.1, 0.2, 0.5, 0.6}, .turn_deg = 0, .mirror = &link == &links[1]};
    PageSettings settings;
    settings.port = 0;
    settings.token = kToken;
    page = PageServer::open(
               network, settings, [] { return std::string(R"({"type": "hello"})"); },
               [this](std::uint64_t client, std::string_view text) { obey(client, text); })
               .value();
    const std::string address = page->address();
    port = static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)));
  }
  void obey(std::uint64_t client, std::string_view text) {
    const auto command = nlohmann::json::parse(text);
    const auto done = pictures.show(client, command["on"].get<bool>());
    page->send(client, reply_json(command["id"], done ? std::string() : done.error().message()));
  }
  std::string target() const { return std::string("/ws?token=") + kToken; }
  /// One look of the network's thread, and what the feeds do until the next.
  void look() {
    if (pictures.watched(*page)) pictures.look(links, *page);
    for (const auto& tap : {left, right})
      tap->offer([&](const PictureTap::Wish& wish, std::span<std::uint8_t> pixels) {
        wishes.push_back(wish);
        std::ranges::fill(pixels, static_cast<std::uint8_t>(40 + wish.sensor));
        return true;
      });
  }

  boost::asio::io_context network{1};
  std::shared_ptr<PictureTap> left = std::make_shared<PictureTap>(sensor::DeviceKey{.device = 7});
  std::shared_ptr<PictureTap> right = std::make_shared<PictureTap>(sensor::DeviceKey{.device = 8});
  PagePictures pictures;
  std::vector<session::Report::Link> links;
  std::vector<PictureTap::Wish> wishes;
  std::unique_ptr<PageServer> page;
  std::uint16_t port = 0;
};

const nlohmann::json kOn = {{"command", "pictures"}, {"on", true}};
const nlohmann::json kOff = {{"command", "pictures"}, {"on", false}};

TEST_F(PagePicturesTest, OnlyWhoAsksIsShownThem) {
  PageClient asks(network, port, target()), looks_on(network, port, target());
  ASSERT_EQ(asks.ask(kOn)["ok"], true);
  EXPECT_TRUE(run_until(network, [&] { return page->clients() == 2; }));
  look();
  ASSERT_EQ(wishes.size(), 2U);
  EXPECT_EQ(wishes[0].sensor, 0);
  EXPECT_EQ(wishes[1].sensor, 1);
  EXPECT_THAT(wishes[1].part.crop, ElementsAre(0.1, 0.2, 0.5, 0.6));
  EXPECT_FALSE(wishes[0].part.mirror);
  EXPECT_TRUE(wishes[1].part.mirror);
  look();
  ASSERT_TRUE(run_until(network, [&] { return asks.binary().size() == 2; }));
  const std::string& first = asks.binary()[0];
  ASSERT_EQ(first.size(), 12U + 96 * 96);
  EXPECT_EQ(hex(std::as_bytes(std::span(first)).first(13)), "4d504943010000006000600028");
  EXPECT_EQ(hex(std::as_bytes(std::span(asks.binary()[1])).first(13)), "4d504943010001006000600029");
  EXPECT_TRUE(looks_on.binary().empty());
}

TEST_F(PagePicturesTest, NothingIsMadeWhileNobodyLooks) {
  PageClient client(network, port, target());
  ASSERT_TRUE(run_until(network, [&] { return page->clients() == 1; }));
  look();
  look();
  EXPECT_TRUE(wishes.empty());
  ASSERT_EQ(client.ask(kOn)["ok"], true);
  EXPECT_EQ(pictures.state()->watchers, 1U);
  look();
  EXPECT_EQ(wishes.size(), 2U);
  ASSERT_EQ(client.ask(kOff)["ok"], true);
  EXPECT_EQ(pictures.state()->watchers, 0U);
  look();
  look();
  EXPECT_EQ(wishes.size(), 2U);
  EXPECT_FALSE(left->take()) << "a view that nobody wants any more is wiped";
  EXPECT_TRUE(client.binary().empty());
}

TEST_F(PagePicturesTest, WhoGoesIsForgotten) {
  {
    PageClient client(network, port, target());
    ASSERT_EQ(client.ask(kOn)["ok"], true);
    EXPECT_TRUE(pictures.watched(*page));
  }
  EXPECT_TRUE(run_until(network, [&] { return page->clients() == 0; }));
  EXPECT_FALSE(pictures.watched(*page));
  EXPECT_EQ(pictures.state()->watchers, 0U);
}

TEST_F(PagePicturesTest, NobodyWithoutTheTokenAsks) {
  PageClient stranger(network, port, "/ws"), wrong(network, port, "/ws?token=0123456789abcdee");
  EXPECT_TRUE(run_until(network, [&] { return stranger.ended() && wrong.ended(); }));
  EXPECT_FALSE(pictures.watched(*page));
}

TEST_F(PagePicturesTest, ACameraAtNoCamerasPlaceIsNotShown) {
  PageClient client(network, port, target());
  ASSERT_EQ(client.ask(kOn)["ok"], true);
  links[0].device = "";
  std::swap(links[0].device, links[1].device);
  look();
  ASSERT_EQ(wishes.size(), 1U) << "the left one is bound to nothing";
  EXPECT_EQ(wishes[0].sensor, 0) << "and the right one to the left one's place";
  EXPECT_FALSE(wishes[0].part.mirror);
}

TEST_F(PagePicturesTest, ASlowPageGetsTheNewestAlone) {
  PageClient client(network, port, target());
  ASSERT_EQ(client.ask(kOn)["ok"], true);
  const std::size_t before = client.binary().size();
  // No turn of the network between them: the connection is busy with none, one waits, others take its place.
  for (int i = 0; i < 50; ++i) page->send_picture(1, 0, std::string(1, static_cast<char>('a' + i % 26)));
  page->send_picture(1, 0, "newest");
  ASSERT_TRUE(
      run_until(network, [&] { return !client.binary().empty() && client.binary().back() == "newest"; }));
  EXPECT_LE(client.binary().size() - before, 2U);
}

TEST(PagePictures, ASessionWithoutCamerasSaysSo) {
  PagePictures none;
  EXPECT_FALSE(none.state());
  const auto refused = none.show(1, true);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unsupported);
  EXPECT_THAT(refused.error().message(), HasSubstr("no camera"));
}

TEST(PictureTap, IsAskedOnceATimeAndWipedWhenTaken) {
  PictureTap tap(sensor::DeviceKey{.device = 7});
  int made = 0;
  const auto feed = [&](bool works = true) {
    tap.offer([&](const PictureTap::Wish& wish, std::span<std::uint8_t> pixels) {
      ++made;
      std::ranges::fill(pixels, static_cast<std::uint8_t>(wish.sensor));
      return works;
    });
  };
  feed();
  EXPECT_EQ(made, 0) << "nobody asked";
  tap.ask({.sensor = 5, .part = {}});
  feed(false);
  EXPECT_FALSE(tap.take()) << "a picture that could not be shown";
  feed();
  feed();
  EXPECT_EQ(made, 2) << "one view a wish";
  tap.ask({.sensor = 6, .part = {}});
  const auto view = tap.take();
  ASSERT_TRUE(view);
  EXPECT_EQ(view->sensor, 5) << "of what was asked when it was made";
  EXPECT_EQ(view->pixels[0], 5);
  EXPECT_FALSE(tap.take());
}

}  // namespace
}  // namespace mien::live::test::page_pictures_test
