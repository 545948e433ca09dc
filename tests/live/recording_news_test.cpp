#include "mien/live/recording_news.h"

#include <gmock/gmock.h>

namespace mien::live::test::recording_news_test {
namespace {

using ::testing::HasSubstr;

std::vector<std::string> kinds(const std::vector<Sentence>& news) {
  std::vector<std::string> out;
  for (const Sentence& one : news) out.push_back(one.kind);
  return out;
}
using Kinds = std::vector<std::string>;

TEST(RecordingNews, SaysOfEachTakeThatItIsWrittenOrWhyItEnded) {
  RecordingNews news;
  Recorder::State state;
  EXPECT_EQ(kinds(news.tell(state, {})), Kinds{});
  state.on = true;
  EXPECT_EQ(kinds(news.tell(state, {})), Kinds{});
  // The next one runs already.
  const auto said = news.tell(state, {{"a.mien", ""}, {"b.mien", "the disk is full"}, {"c.mien", ""}});
  ASSERT_EQ(kinds(said), (Kinds{"recorded", "recording_failed", "recorded"}));
  EXPECT_EQ(said[0].text, "a.mien is written");
  EXPECT_THAT(said[1].text, HasSubstr("the disk is full; the capture goes on"));
  EXPECT_EQ(kinds(news.tell(state, {})), Kinds{});
}

TEST(RecordingNews, WhyOneEndedIsNotSaidOnceMoreOfTheSession) {
  RecordingNews news;
  Recorder::State state;
  state.unable = "the log is full";
  EXPECT_EQ(kinds(news.tell(state, {{"a.mien", "the log is full"}})), Kinds{"recording_failed"});
  EXPECT_EQ(kinds(news.tell(state, {})), Kinds{});
}

TEST(RecordingNews, SaysOnceThatTheLogFillsAndThatItIsFull) {
  RecordingNews news;
  Recorder::State state;
  state.log.seconds_left = RecordingNews::kLogWarning_s + 1;
  EXPECT_EQ(kinds(news.tell(state, {})), Kinds{});
  state.log.seconds_left = 95;
  const auto said = news.tell(state, {});
  ASSERT_EQ(kinds(said), Kinds{"log_fills"});
  EXPECT_THAT(said[0].text, HasSubstr("full in 2 minutes"));
  EXPECT_EQ(kinds(news.tell(state, {})), Kinds{});
  state.unable = "the log is full";
  EXPECT_EQ(kinds(news.tell(state, {})), Kinds{"recording_failed"});
  EXPECT_EQ(kinds(news.tell(state, {})), Kinds{});
}

}  // namespace
}  // namespace mien::live::test::recording_news_test
