#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mien/session/recorded_lines.h"
#include "tests/session/session_run.h"

// Lines of a dataset in a whole session: consent, what was poor, and the same in a replay.
namespace mien::session::dataset_session_test {
namespace {

using test::kPrologue_s;
using ::testing::IsEmpty;

const char* const kConsent =
    R"({"command":"consent","performer":"Anna","recorded_by":"us","purpose":"a model","sound":false})";

std::string line(const std::string& name) {
  return R"({"command":"prompt","name":")" + name +
         R"(","text":"Read this.","block":"calm","emotion":"neutral","language":"en","own_pace":true,"seconds":3})";
}
std::string prompts(const std::string& word) {
  return R"({"command":"prompts","do":")" + word + R"("})";
}

/// Two lines, each read for three seconds, and what was poor of them for two more.
std::vector<test::Order> orders() {
  const double at = kPrologue_s;
  return {{at, kConsent},
          {at, line("one")},
          {at, line("two")},
          {at + 0.5, prompts("begin")},
          {at + 6.6, prompts("next")},   // One, from 3.5 on.
          {at + 9.6, prompts("next")}};  // Two.
}

TEST(DatasetSession, NobodyIsAskedForALineBeforeTheyConsented) {
  const auto session = test::session();
  EXPECT_FALSE(session->command(HostTime(), line("one")));
  EXPECT_TRUE(session->command(HostTime(), R"({"command":"prompt","name":"smile"})")) << "a pose for oneself";
  ASSERT_TRUE(session->command(HostTime(), kConsent));
  EXPECT_TRUE(session->command(HostTime(), line("one")));
}

TEST(DatasetSession, VideoIsAgreedToByItsOwnWord) {
  const auto consent_told = [](std::string command) {
    const test::Played played =
        test::run(*test::session(), test::performance(6).entries, {{kPrologue_s, std::move(command)}});
    const auto part = recorded_part(played.events);
    return part ? std::optional(part->consent) : std::nullopt;
  };
  const auto without = consent_told(kConsent);
  ASSERT_TRUE(without);
  EXPECT_FALSE(without->video) << "an older page says nothing of it";
  std::string command = kConsent;
  command.insert(command.size() - 1, R"(,"video":true)");
  const auto with = consent_told(command);
  ASSERT_TRUE(with);
  EXPECT_TRUE(with->video);
  EXPECT_FALSE(with->sound) << "of which nothing was said";
  // Takes of before, and of others.
  const auto video_in = [](const std::string& more) {
    const auto consent =
        consent_of(R"({"performer":"Anna","recorded_by":"us","purpose":"a model")" + more + "}");
    return consent && consent->video;
  };
  EXPECT_FALSE(video_in(""));
  EXPECT_FALSE(video_in(R"(,"video":1)"));
  EXPECT_FALSE(video_in(R"(,"video":"true")"));
  EXPECT_TRUE(video_in(R"(,"video":true)"));
}

TEST(DatasetSession, LinesThatWereGoodAreInTheTakeFromTheConsentOn) {
  const auto session = test::session();
  const test::Played played = test::run(*session, test::performance(14).entries, orders());
  const auto part = recorded_part(played.events);
  ASSERT_TRUE(part);
  EXPECT_EQ(part->consent.performer, "Anna");
  ASSERT_EQ(part->lines.size(), 2u);
  EXPECT_EQ(part->lines[0].name, "one");
  EXPECT_THAT(part->lines[0].poor, IsEmpty());
  EXPECT_THAT(part->lines[1].poor, IsEmpty());
  EXPECT_NEAR(to_seconds(part->lines[0].end - part->lines[0].begin), 3.1, 0.1);
  EXPECT_GE(part->lines[0].begin, part->begin);
  EXPECT_EQ(played.report.prompts.state, "over");
}

TEST(DatasetSession, ALineInWhichASensorWasLostIsAskedForAgainAtTheEnd) {
  const auto session = test::session();
  const auto log = test::without(test::performance(14), 1, kPrologue_s + 4, kPrologue_s + 5.5);
  const test::Played played = test::run(*session, log, orders());
  const auto part = recorded_part(played.events);
  ASSERT_TRUE(part);
  ASSERT_EQ(part->lines.size(), 2u);
  ASSERT_EQ(part->lines[0].poor.size(), 1u);
  EXPECT_TRUE(part->lines[0].poor[0].ends_with(" was lost")) << part->lines[0].poor[0];
  EXPECT_THAT(part->lines[1].poor, IsEmpty());
  EXPECT_EQ(played.report.prompts.state, "block");
  EXPECT_EQ(played.report.prompts.prompt.name, "one");
  EXPECT_EQ(played.report.prompts.prompt.attempt, 2);

  // The same log gives the same lines again.
  const auto again = test::session();
  const test::Played second = test::run(*again, log, orders());
  EXPECT_EQ(second.hash, played.hash);
  ASSERT_EQ(second.events.size(), played.events.size());
  for (std::size_t i = 0; i < played.events.size(); ++i) {
    EXPECT_EQ(second.events[i].json, played.events[i].json);
    EXPECT_EQ(second.events[i].begin, played.events[i].begin);
  }
}

TEST(DatasetSession, AskingChangesNoWeight) {
  const test::Played plain = test::run(*test::session(), test::performance(14).entries, {});
  const test::Played asked = test::run(*test::session(), test::performance(14).entries, orders());
  EXPECT_EQ(plain.hash, asked.hash);
}

}  // namespace
}  // namespace mien::session::dataset_session_test
