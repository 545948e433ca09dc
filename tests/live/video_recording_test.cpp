#include "mien/live/video_recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/folder.h"
#include "tests/hex.h"

// Without a network: what a browser's chunks become, on a clock of the test's own.
namespace mien::live::video_recording_test {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::uint64_t kAnna = 7, kOther = 8;

HostTime at(double seconds) {
  return HostTime(from_seconds(seconds));
}

struct VideoRecordingTest : ::testing::Test {
  static std::vector<std::byte> chunk(std::uint32_t sequence, std::uint32_t age_ms, std::size_t bytes = 1000,
                                      VideoContainer container = VideoContainer::webm) {
    std::vector<std::byte> data = mien::bytes_of("1a45dfa3");
    data.resize(bytes);
    return encode_video_message(
        {.container = container, .sequence = sequence, .age_ms = age_ms, .data = data});
  }
  /// What is written is; and all that is new.
  VideoRecording::News look(double seconds, bool here = true) {
    VideoRecording::News news = video.look(at(seconds), here);
    for (int i = 0; i < 1000 && video.state() && video.state()->on && video.state()->file.empty(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      add(video.look(at(seconds), here), news);
    }
    return news;
  }
  /// The same until all files are closed.
  VideoRecording::News look_until_over(double seconds) {
    VideoRecording::News news = look(seconds);
    for (int i = 0; i < 5000 && !video.is_over(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      add(video.look(at(seconds), true), news);
    }
    EXPECT_TRUE(video.is_over());
    return news;
  }
  static void add(VideoRecording::News more, VideoRecording::News& to) {
    for (auto& one : more.sentences) to.sentences.push_back(std::move(one));
    for (auto& one : more.events) to.events.push_back(std::move(one));
    for (auto& one : more.stops) to.stops.push_back(std::move(one));
  }
  static std::vector<std::string> kinds(const VideoRecording::News& news) {
    std::vector<std::string> out;
    for (const auto& event : news.events) out.push_back(event.kind);
    return out;
  }
  void begin() {
    video.allow(folder / "anna.mien");
    ASSERT_TRUE(video.camera(kAnna, true, at(10)));
  }

  const mien::test::Folder folder{mien::test::Folder::On::memory};
  VideoRecording video{0};
};

TEST_F(VideoRecordingTest, NothingIsKeptOfWhoDidNotAgree) {
  EXPECT_FALSE(video.state());
  EXPECT_FALSE(video.camera(kAnna, true, at(1)));
  for (std::uint32_t i = 0; i < 5; ++i) video.take(kAnna, chunk(i, 1000 * i), at(1 + i));
  const auto news = look(6);
  ASSERT_EQ(news.sentences.size(), 1U) << "counted, and told once";
  EXPECT_THAT(news.sentences[0].text, HasSubstr("performer agreed to it"));
  EXPECT_EQ(video.state()->refused, 5U);
  EXPECT_FALSE(video.state()->agreed);
  EXPECT_THAT(folder.files(), IsEmpty());
  EXPECT_TRUE(video.is_over());
}

TEST_F(VideoRecordingTest, StandsBesideTheTakeWithItsPlaceOnTheSessionsClock) {
  begin();
  EXPECT_THAT(look(10).events, IsEmpty());
  video.take(kAnna, chunk(0, 1000), at(11.25));
  const auto first = look(11.3);
  ASSERT_THAT(kinds(first), ElementsAre("video"));
  EXPECT_EQ(json::parse(first.events[0].json),
            json({{"file", "anna.webm"}, {"container", "webm"}, {"received_s", 11.25}, {"age_s", 1.0}}));
  EXPECT_TRUE(video.state()->on);
  EXPECT_EQ(video.state()->file, "anna.webm");
  video.take(kAnna, chunk(1, 2000), at(12.05));  // Which was quicker.
  video.take(kAnna, chunk(2, 3000), at(13.1));
  video.finish(at(13.5));
  const auto told = look(13.5);
  ASSERT_EQ(told.stops.size(), 1U);
  EXPECT_EQ(told.stops[0].client, kAnna);
  EXPECT_EQ(told.stops[0].why, "");
  EXPECT_FALSE(video.is_over()) << "the last chunk is on its way";
  video.take(kAnna, chunk(3, 3400), at(13.55));
  ASSERT_TRUE(video.camera(kAnna, false, at(13.56)));
  const auto last = look_until_over(13.6);
  ASSERT_THAT(kinds(last), ElementsAre("video_over"));
  EXPECT_EQ(json::parse(last.events[0].json), json({{"file", "anna.webm"},
                                                    {"bytes", 4000},
                                                    {"chunks", 4},
                                                    {"zero_s", 10.05},
                                                    {"last_s", 3.4},
                                                    {"ended", "the recording is over"}}));
  EXPECT_EQ(last.sentences.at(0).kind, "video");
  EXPECT_EQ(std::filesystem::file_size(folder / "anna.webm"), 4000U);
  EXPECT_FALSE(video.camera(kAnna, true, at(14))) << "what was agreed to is over";
}

TEST_F(VideoRecordingTest, TheLastChunkIsNotWaitedForForLong) {
  begin();
  video.take(kAnna, chunk(0, 1000), at(11));
  static_cast<void>(look(11));
  video.finish(at(12));
  EXPECT_FALSE(video.is_over());
  video.take(kAnna, chunk(0, 5), at(12.1));
  EXPECT_EQ(video.state()->refused, 1U) << "none begins any more";
  EXPECT_THAT(kinds(look_until_over(14.1)), ElementsAre("video_over"));
  EXPECT_EQ(video.state()->files, 1U);
}

TEST_F(VideoRecordingTest, AGapBeginsAnotherFileAndSoDoesTheSameBrowserAnew) {
  begin();
  video.take(kAnna, chunk(0, 1000), at(11));
  static_cast<void>(look(11));
  video.take(kAnna, chunk(2, 3000), at(13));
  const auto gap = look(13);
  ASSERT_EQ(gap.stops.size(), 1U);
  EXPECT_TRUE(gap.stops[0].again);
  EXPECT_THAT(video.state()->trouble, HasSubstr("missing (1)"));
  video.take(kAnna, chunk(3, 4000), at(14));
  EXPECT_EQ(video.state()->refused, 2U) << "until it has begun anew";
  video.take(kAnna, chunk(0, 900), at(15));
  video.take(kAnna, chunk(1, 1900), at(16));
  video.take(kAnna, chunk(0, 1000, 1000), at(17));
  video.finish(at(18));
  ASSERT_TRUE(video.camera(kAnna, false, at(18)));
  static_cast<void>(look_until_over(18));
  EXPECT_THAT(folder.files(), ElementsAre((folder / "anna.webm").string(), (folder / "anna_2.webm").string(),
                                          (folder / "anna_3.webm").string()));
  EXPECT_EQ(video.state()->files, 3U);
  EXPECT_EQ(std::filesystem::file_size(folder / "anna_2.webm"), 2000U);
}

TEST_F(VideoRecordingTest, OneBrowserAtATimeUntilItIsGoneOrSilent) {
  begin();
  video.take(kAnna, chunk(0, 1000), at(11));
  const auto refused = video.camera(kOther, true, at(12));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr("another browser's camera is recorded"));
  video.take(kOther, chunk(0, 1000), at(12));
  video.take(kOther, chunk(1, 2000), at(12));
  EXPECT_EQ(video.state()->refused, 2U);
  ASSERT_TRUE(video.camera(kOther, false, at(12))) << "which changes nothing";
  EXPECT_EQ(video.client(), kAnna);
  // It is gone.
  const auto gone = look(12.5, false);
  EXPECT_EQ(video.client(), 0U);
  EXPECT_THAT(video.state()->trouble, HasSubstr("gone"));
  ASSERT_TRUE(video.camera(kOther, true, at(13)));
  video.take(kOther, chunk(0, 1000), at(14));
  EXPECT_THAT(video.state()->trouble, IsEmpty());
  // This one is silent.
  static_cast<void>(look(15));
  // What the writer tells meanwhile stands beside it.
  const auto told_silent = [&](double at_s) {
    const auto news = look(at_s);
    return std::ranges::count_if(
        news.sentences, [](const auto& one) { return one.text.find("no video comes") != std::string::npos; });
  };
  EXPECT_EQ(told_silent(19.5), 1);
  EXPECT_EQ(told_silent(19.6), 0) << "once";
  ASSERT_TRUE(video.camera(kAnna, true, at(20)));
  const auto taken = look(20);
  ASSERT_EQ(taken.stops.size(), 1U);
  EXPECT_EQ(taken.stops[0].client, kOther);
  EXPECT_THAT(taken.stops[0].why, HasSubstr("Another browser"));
  video.finish(at(21));
  static_cast<void>(look_until_over(21));
}

TEST_F(VideoRecordingTest, GarbageAndWhatIsTooLongIsRefusedAndToldOnce) {
  begin();
  std::vector<std::byte> garbage = chunk(0, 1000);
  garbage[4] = std::byte{9};
  for (int i = 0; i < 5; ++i) video.take(kAnna, garbage, at(11));
  std::vector<std::byte> no_webm = chunk(0, 1000);
  no_webm[16] = std::byte{9};
  video.take(kAnna, no_webm, at(11));
  video.take(kAnna, chunk(0, 1000, kMaxVideoChunk + 1), at(11));
  const auto news = look(11);
  ASSERT_EQ(news.sentences.size(), 1U);
  EXPECT_EQ(news.sentences[0].kind, "video_failed");
  EXPECT_THAT(news.sentences[0].text, HasSubstr("load the page anew"));
  EXPECT_EQ(video.state()->refused, 7U);
  // What comes twice, or of another kind, changes nothing either.
  video.take(kAnna, chunk(0, 1000), at(12));
  video.take(kAnna, chunk(1, 2000), at(13));
  video.take(kAnna, chunk(1, 2000), at(13));
  video.take(kAnna, chunk(2, 3000, 1000, VideoContainer::mp4), at(14));
  video.take(kAnna, chunk(2, 3000), at(14));
  EXPECT_EQ(video.state()->refused, 9U);
  video.finish(at(15));
  ASSERT_TRUE(video.camera(kAnna, false, at(15)));
  static_cast<void>(look_until_over(15));
  EXPECT_EQ(std::filesystem::file_size(folder / "anna.webm"), 3000U);
}

TEST_F(VideoRecordingTest, WhoSendsTooMuchIsToldToStop) {
  begin();
  std::uint32_t sent = 0;
  double seconds = 11;
  // 5 MB a second: what may come at once lasts for a while.
  for (; sent < 60 && video.client() == kAnna; ++sent, seconds += 1)
    video.take(kAnna, chunk(sent, 1000 * sent, 5'000'000), at(seconds));
  EXPECT_GE(sent, 10U);
  EXPECT_LE(sent, 20U);
  const auto news = look(seconds);
  ASSERT_FALSE(news.stops.empty());
  EXPECT_THAT(news.stops.back().why, HasSubstr("more than 4 MB a second"));
  EXPECT_FALSE(news.stops.back().again);
}

TEST_F(VideoRecordingTest, AFullDiskEndsTheVideoAlone) {
  VideoRecording full(std::uint64_t{1} << 60U);
  full.allow(folder / "anna.mien");
  ASSERT_TRUE(full.camera(kAnna, true, at(10)));
  full.take(kAnna, chunk(0, 1000), at(11));
  VideoRecording::News news;
  for (int i = 0; i < 5000 && full.client() != 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    add(full.look(at(11.1), true), news);
  }
  EXPECT_EQ(full.client(), 0U);
  ASSERT_EQ(news.stops.size(), 1U);
  EXPECT_THAT(full.state()->trouble, HasSubstr("make room"));
  EXPECT_TRUE(full.state()->agreed) << "it may be used again when there is room";
  const std::uint64_t refused = full.state()->refused;
  full.take(kAnna, chunk(1, 2000), at(12));
  add(full.look(at(12), true), news);
  EXPECT_EQ(full.state()->refused, refused + 1);
  full.close(at(13));
  add(full.look(at(13), true), news);
  EXPECT_TRUE(full.is_over());
  std::size_t told = 0;
  for (const auto& sentence : news.sentences) told += sentence.kind == "video_failed" ? 1 : 0;
  EXPECT_EQ(told, 1U) << "one line";
  EXPECT_THAT(folder.files(), IsEmpty());
}

TEST_F(VideoRecordingTest, TheSessionsEndKeepsWhatCame) {
  begin();
  video.take(kAnna, chunk(0, 1000), at(11));
  video.close(at(11.2));
  const auto news = video.look(at(11.2), true);
  EXPECT_THAT(kinds(news), ElementsAre("video", "video_over"));
  EXPECT_TRUE(video.is_over());
  EXPECT_EQ(std::filesystem::file_size(folder / "anna.webm"), 1000U);
}

}  // namespace
}  // namespace mien::live::video_recording_test
