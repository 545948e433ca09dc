// `mien perform --phone` from outside: a virtual phone in a take, and before a live session.
#include <gmock/gmock.h>
#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "mien/sensor/rig_part.h"
#include "mien/take/take.h"
#include "tests/app/free_port.h"
#include "tests/app/program.h"
#include "tests/virtual/three_sensors.h"

namespace mien::app::test::perform_phone_test {
namespace {

using ::testing::HasSubstr;

class PerformPhone : public ::testing::Test {
 protected:
  void SetUp() override { write(folder_ / "rig.toml", virt::test::kRig); }

  [[nodiscard]] std::vector<std::string> perform(std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"perform",   "--rig", folder_ / "rig.toml", "--script", "free",
                                          "--seconds", "3",     "--prologue",         "none",     "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  /// One line, which is returned.
  [[nodiscard]] std::string refused(const std::vector<std::string>& more) const {
    const Outcome outcome = run(perform(more));
    EXPECT_EQ(outcome.status, 2) << joined(more) << outcome.err;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    return outcome.err;
  }
  Folder folder_;
};

/// Samples of the take's truth.
std::ptrdiff_t told(const take::Take& take) {
  const std::vector<std::uint16_t> truths = sensor::truths_of(take.rig());
  if (truths.size() != 1) return -1;
  const auto samples = take.samples().value();
  return std::ranges::count_if(samples, [&](const auto& s) { return s.sample.sensor == truths[0]; });
}

TEST_F(PerformPhone, ItsTrackStandsInATakeBesideTheTruth) {
  const Outcome both = run(perform({"--phone", "--take", folder_ / "both.mien"}));
  ASSERT_EQ(both.status, 0) << both.err;
  const Outcome alone = run(perform({"--take", folder_ / "alone.mien"}));
  ASSERT_EQ(alone.status, 0) << alone.err;
  const take::Take take = take::Take::open(folder_ / "both.mien").value();
  EXPECT_TRUE(take.check());
  EXPECT_GT(told(take), 150);
  EXPECT_FALSE(take.truth().value().empty());
  const auto frames = [](const Outcome& outcome) { return nlohmann::json::parse(outcome.out)["frames"]; };
  EXPECT_EQ(frames(both), frames(alone));
}

TEST_F(PerformPhone, ALiveSessionHearsIt) {
  const std::uint16_t boards = free_port(), phones = free_port();
  const auto at = [](std::uint16_t port) { return "127.0.0.1:" + std::to_string(port); };
  const pid_t performer =
      start(perform({"--to", "udp://" + at(boards), "--phone", at(phones), "--wait", "20"}),
            folder_ / "perform.out", folder_ / "perform.err");
  const std::string take = folder_ / "take.mien";
  const Outcome live = run({"live", "--listen", "udp://" + at(boards), "--listen", "livelink://" + at(phones),
                            "--phone", "truth", "--page", "off", "--json", "--for", "6", "--record", take});
  ::kill(performer, SIGTERM);
  int status = 0;
  ::waitpid(performer, &status, 0);
  ASSERT_EQ(live.status, 0) << live.err << content(folder_ / "perform.err");
  const auto summary = nlohmann::json::parse(live.out);
  EXPECT_EQ(summary["malformed"], 0);
  EXPECT_GT(told(take::Take::open(take).value()), 100);
  const Outcome again = run({"live", "--replay", take, "--json"});
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(nlohmann::json::parse(again.out)["hash"], summary["hash"]);
}

TEST_F(PerformPhone, SaysWhatToTypeInstead) {
  EXPECT_THAT(refused({"--phone", "10.0.0.9", "--take", folder_ / "a.mien"}),
              HasSubstr("leave out the address"));
  EXPECT_THAT(refused({"--to", "udp://127.0.0.1:5005", "--phone"}), HasSubstr("--phone HOST[:PORT]"));
  EXPECT_THAT(refused({"--to", "udp://127.0.0.1:5005", "--phone", ":11111"}), HasSubstr("no address"));
  EXPECT_THAT(refused({"--to", "udp://127.0.0.1:5005", "--phone", "10.0.0.9:0"}), HasSubstr("no address"));
  EXPECT_THAT(refused({"--to", "http://127.0.0.1:8081", "--phone", "127.0.0.1"}), HasSubstr("--cameras"));
  write(folder_ / "key", "7 " + std::string(64, 'a') + "\n");
  std::filesystem::permissions(folder_ / "key", std::filesystem::perms::owner_read);
  EXPECT_THAT(refused({"--to", "udp://127.0.0.1:5005", "--phone", "127.0.0.1", "--key", folder_ / "key"}),
              HasSubstr("phones seal none"));
  // A rig's own phone is told where to send as well.
  EXPECT_EQ(run(perform({"--phone", "--take", folder_ / "own.mien"})).status, 0);
  write(folder_ / "rig.toml", take::Take::open(folder_ / "own.mien").value().header().rig_toml);
  EXPECT_THAT(refused({"--to", "udp://127.0.0.1:5005"}), HasSubstr("--phone HOST[:PORT]"));
  EXPECT_EQ(run(perform({"--take", folder_ / "again.mien"})).status, 0);
}

TEST_F(PerformPhone, HelpSaysThatItsAddressMayBeLeftOut) {
  EXPECT_THAT(run({"perform", "--help"}).out, HasSubstr("--phone [HOST[:PORT]]"));
}

}  // namespace
}  // namespace mien::app::test::perform_phone_test
