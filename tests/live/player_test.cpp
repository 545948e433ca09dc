#include "mien/live/player.h"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <thread>

#include "tests/folder.h"
#include "tests/session/session_run.h"

namespace mien::live::player_test {
namespace {

HostTime at(double seconds) {
  return HostTime(from_seconds(seconds));
}

class PlayerTest : public ::testing::Test {
 protected:
  /// Writes what a session of a short performance leaves behind; returns the frames that it gave.
  static std::vector<session::test::Played::Frame> record(const std::filesystem::path& path, bool truth);

  using Played = session::test::Played;
  static Result<std::unique_ptr<session::Session>> make_session(const sensor::Rig& rig) {
    return session::test::session(rig);
  }
  /// Until it was read; a minute at most.
  static std::optional<Player::Moment> first(Player& player, HostTime now) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (std::chrono::steady_clock::now() < end) {
      if (const auto moment = player.next(now)) return moment;
      if (!player.view(now).error.empty()) return std::nullopt;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return std::nullopt;
  }

  mien::test::Folder folder{mien::test::Folder::On::memory};
  Player player{make_session};
};

std::vector<session::test::Played::Frame> PlayerTest::record(const std::filesystem::path& path, bool truth) {
  const virt::VirtualSession performed = session::test::performance(0.5);
  const Played run = session::test::run(*session::test::session(), performed.entries);
  take::Header header;
  header.software = "test";
  header.rig_toml = virt::test::kRig;
  auto writer = take::TakeWriter::create(path, header, true);
  EXPECT_TRUE(writer) << writer.error().message();
  for (const take::LogEntry& entry : run.log) writer->add_entry(entry.arrival, entry.source, entry.bytes);
  for (const Played::Frame& frame : run.frames) writer->add_tick(frame.tick);
  if (truth)
    for (const take::TruthFrame& frame : performed.truth) writer->add_truth(frame);
  EXPECT_TRUE(writer->finish());
  return run.frames;
}

TEST_F(PlayerTest, PlaysHoldsAndWindsWhatTheSessionGave) {
  const auto frames = record(folder / "a.mien", true);
  const auto count = static_cast<double>(frames.size());
  EXPECT_FALSE(player.on());
  EXPECT_FALSE(player.next(at(0)));
  player.load(folder / "a.mien");
  EXPECT_TRUE(player.on());
  const auto begun = first(player, at(100));
  ASSERT_TRUE(begun) << player.view(at(100)).error;
  EXPECT_EQ(begun->index, 0);
  EXPECT_EQ(begun->frame->weights, frames.front().frame.weights);
  EXPECT_FALSE(player.next(at(100.001))) << "the same frame once more";
  const Player::View view = player.view(at(101));
  EXPECT_EQ(view.take, "a.mien");
  EXPECT_NEAR(view.time_s, 1, 1e-9);
  EXPECT_NEAR(view.duration_s, count / 60, 1e-9);
  EXPECT_TRUE(view.has_truth);
  EXPECT_FALSE(view.paused);

  const auto later = player.next(at(110.001));
  ASSERT_TRUE(later);
  EXPECT_EQ(later->index, 600);
  EXPECT_EQ(later->frame->weights, frames[600].frame.weights);
  player.pause(true, at(110.001));
  EXPECT_FALSE(player.next(at(150)));
  EXPECT_TRUE(player.view(at(150)).paused);
  player.seek(2.0001, at(150));
  const auto wound = player.next(at(151));
  ASSERT_TRUE(wound) << "shown also while paused";
  EXPECT_EQ(wound->index, 120);
  player.pause(false, at(200));
  EXPECT_EQ(player.next(at(200.501))->index, 150);

  // It stands still at its end, and begins anew from there.
  EXPECT_EQ(player.next(at(300))->index, static_cast<std::int64_t>(frames.size()) - 1);
  EXPECT_TRUE(player.view(at(300)).paused);
  player.pause(false, at(301));
  EXPECT_EQ(player.next(at(301.001))->index, 0);

  for (const double odd : {-5.0, 1e9}) {
    player.seek(odd, at(400));
    const auto moment = player.next(at(400));
    ASSERT_TRUE(moment) << odd;
    EXPECT_EQ(moment->index, odd < 0 ? 0 : static_cast<std::int64_t>(frames.size()) - 1);
  }
  player.stop();
  EXPECT_FALSE(player.on());
  EXPECT_FALSE(player.next(at(500)));
  EXPECT_EQ(player.view(at(500)).take, "");
}

TEST_F(PlayerTest, ShowsNoTruthWhereThereIsNone) {
  record(folder / "plain.mien", false);
  player.load(folder / "plain.mien");
  const auto moment = first(player, at(0));
  ASSERT_TRUE(moment);
  EXPECT_EQ(moment->truth, nullptr);
  EXPECT_FALSE(player.view(at(0)).has_truth);
}

TEST_F(PlayerTest, SaysWhyATakeCannotBeShown) {
  player.load(folder / "none.mien");
  EXPECT_FALSE(first(player, at(0)));
  EXPECT_FALSE(player.view(at(0)).error.empty());
  EXPECT_TRUE(player.on()) << "so that somebody sees it";
  // Nothing that is asked of it then does harm.
  player.pause(true, at(1));
  player.pause(false, at(1));
  player.seek(3, at(1));
  EXPECT_FALSE(player.next(at(2)));

  Player strict([](const sensor::Rig&) -> Result<std::unique_ptr<session::Session>> {
    throw std::runtime_error("no such thing");
  });
  record(folder / "a.mien", false);
  strict.load(folder / "a.mien");
  EXPECT_FALSE(first(strict, at(0)));
  EXPECT_EQ(strict.view(at(0)).error, "no such thing");
}

TEST_F(PlayerTest, AnotherTakeTakesThePlaceOfOneThatIsStillRead) {
  const auto frames = record(folder / "a.mien", false);
  for (int i = 0; i < 5; ++i) player.load(folder / "a.mien");
  const auto moment = first(player, at(0));
  ASSERT_TRUE(moment);
  EXPECT_EQ(moment->frame->weights, frames.front().frame.weights);
  player.load(folder / "a.mien");  // And is left before it was read.
}

}  // namespace
}  // namespace mien::live::player_test
