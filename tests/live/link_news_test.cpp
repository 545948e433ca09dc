#include "mien/live/link_news.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace mien::live::link_news_test {
namespace {

HostTime at(double seconds) {
  return HostTime(from_seconds(seconds));
}

take::Event event(bool lost, const std::string& sensor) {
  return {lost ? "sensor_lost" : "sensor_back", {}, {}, fmt::format(R"({{"sensor": "{}"}})", sensor)};
}

std::vector<std::string> texts(LinkNews& news, double seconds, const std::vector<take::Event>& events) {
  std::vector<std::string> out;
  for (const Sentence& said : news.tell(at(seconds), events)) out.push_back(said.text);
  return out;
}
using Texts = std::vector<std::string>;

TEST(LinkNews, ALossAndTheReturnFromItAreSaidAtOnce) {
  LinkNews news;
  EXPECT_EQ(texts(news, 1, {event(true, "chin")}), Texts{"chin is lost"});
  EXPECT_EQ(LinkNews::loss_text("chin"), "chin is lost");
  EXPECT_EQ(texts(news, 2, {}), Texts());
  EXPECT_EQ(texts(news, 3, {event(false, "chin")}), Texts{"chin is back"});
  EXPECT_EQ(texts(news, 30, {event(true, "chin")}), Texts{"chin is lost"});
  EXPECT_EQ(texts(news, 60, {}), Texts());
}

TEST(LinkNews, WhatFlapsIsCountedAndSaidOnceInTenSeconds) {
  LinkNews news;
  std::size_t said = 0;
  std::string counted;
  int flaps = 0;
  for (double t = 0; t < 60; t += 0.5) {
    const bool lost = static_cast<int>(2 * t) % 2 == 0;
    flaps += lost ? 1 : 0;
    for (const std::string& text : texts(news, t, {event(lost, "chin")})) {
      ++said;
      if (text.starts_with("chin was lost ")) counted = text;
    }
  }
  EXPECT_EQ(flaps, 60);
  EXPECT_LE(said, 2u + 6u * 2u);
  EXPECT_EQ(counted, "chin was lost 11 more times in 10 s and is lost now");
  const Texts rest = texts(news, 75, {});
  ASSERT_EQ(rest.size(), 1u);
  EXPECT_EQ(rest[0].substr(rest[0].size() - 11), "is back now") << rest[0];
  EXPECT_EQ(texts(news, 100, {}), Texts());
}

TEST(LinkNews, ManyAtOnceAreOneSentence) {
  LinkNews news;
  EXPECT_EQ(texts(news, 1, {event(true, "a"), event(true, "b"), event(true, "c")}),
            Texts{"3 sensors are lost"});
  EXPECT_EQ(texts(news, 2, {event(false, "a"), event(false, "b")}), (Texts{"a is back", "b is back"}));
}

TEST(LinkNews, AFaceThatIsNotSeenIsSaidApartFromTheLink) {
  LinkNews news;
  const auto face = [](bool lost) {
    return take::Event{lost ? "face_lost" : "face_back", {}, {}, R"({"sensor": "phone"})"};
  };
  EXPECT_EQ(texts(news, 1, {face(true)}), Texts{"phone sees no face"});
  EXPECT_EQ(texts(news, 2, {event(true, "phone")}), Texts{"phone is lost"});
  EXPECT_EQ(texts(news, 3, {event(false, "phone"), face(false)}),
            (Texts{"phone is back", "phone sees the face again"}));
  for (int i = 0; i < 4; ++i) EXPECT_EQ(texts(news, 4 + i, {face(i % 2 == 0)}), Texts());
  EXPECT_EQ(texts(news, 14, {}), Texts{"phone lost the face 2 more times in 10 s and sees it now"});
}

TEST(LinkNews, PassesOverWhatIsNoLinkAndWhatNamesNone) {
  LinkNews news;
  EXPECT_FALSE(LinkNews::is_about_a_link({"calibrated", {}, {}, {}}));
  EXPECT_EQ(texts(news, 1, {{"calibrated", {}, {}, {}}}), Texts());
  EXPECT_EQ(texts(news, 1, {{"sensor_lost", {}, {}, "[]"}}), Texts{" is lost"});
}

}  // namespace
}  // namespace mien::live::link_news_test
