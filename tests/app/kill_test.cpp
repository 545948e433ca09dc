// `mien perform --take --pace real`, killed at random moments: the take opens again and has lost a second at
// most. MIEN_KILLS sets how many (default 12).
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "mien/core/random.h"
#include "mien/face/livelink_csv.h"
#include "mien/take/take.h"
#include "tests/app/program.h"
#include "tests/virtual/three_sensors.h"

namespace mien::app::test {
namespace {

using Clock = std::chrono::steady_clock;

/// One recording, and how it ended.
struct Recording {
  pid_t process = -1;
  std::string take;
  double wanted_s = 0;      ///< How long after its take appeared it is to be killed.
  Clock::time_point begun;  ///< When its take was there.
  bool appeared = false;
  double killed_s = -1;  ///< After its take appeared.
};

/// Seconds of the session that the take holds.
double kept_s(const take::Take& take) {
  const auto entries = take.entries().value();
  return entries.empty() ? 0 : to_seconds(entries.back().arrival.time_since_epoch());
}

int kills_wanted() {
  const char* wanted = std::getenv("MIEN_KILLS");
  return wanted == nullptr ? 12 : std::atoi(wanted);
}

TEST(Killed, ATakeLosesASecondAtMost) {
  const Folder folder;
  write(folder / "rig.toml", virt::test::kRig);
  write(folder / "talking.csv",
        face::format_livelink_csv(face::livelink_from_motion(virt::test::talking(900))));
  Random random(20'26);
  constexpr int kAtOnce = 12;
  double worst_s = 0;
  double total_s = 0;
  int killed = 0;
  int left = kills_wanted();
  for (int batch = 0; left > 0; ++batch) {
    std::vector<Recording> recordings(static_cast<std::size_t>(std::min(left, kAtOnce)));
    left -= static_cast<int>(recordings.size());
    for (std::size_t i = 0; i < recordings.size(); ++i) {
      Recording& r = recordings[i];
      const std::string name = std::to_string(batch) + "-" + std::to_string(i);
      r.take = folder / (name + ".mien");
      r.wanted_s = random.uniform(0, 5);
      r.process = start({"perform", "--pace", "real", "--prologue", "none", "--rig", folder / "rig.toml",
                         "--motion", folder / "talking.csv", "--take", r.take, "--seed", std::to_string(i)},
                        folder / (name + ".out"), folder / (name + ".err"));
      ASSERT_GT(r.process, 0);
    }
    // Each is killed when its moment has come; one that ends by itself before its take appears has failed.
    const Clock::time_point give_up = Clock::now() + std::chrono::minutes(5);
    for (std::size_t running = recordings.size(); running > 0 && Clock::now() < give_up;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      for (Recording& r : recordings) {
        if (r.process < 0) continue;
        const Clock::time_point now = Clock::now();
        if (!r.appeared && std::filesystem::exists(r.take)) {
          r.appeared = true;
          r.begun = now;
        }
        const double since_s = r.appeared ? std::chrono::duration<double>(now - r.begun).count() : -1;
        if (r.appeared && since_s >= r.wanted_s) {
          ::kill(r.process, SIGKILL);
          r.killed_s = std::chrono::duration<double>(Clock::now() - r.begun).count();
        }
        int status = 0;
        if (::waitpid(r.process, &status, r.killed_s >= 0 ? 0 : WNOHANG) != r.process) continue;
        EXPECT_TRUE(WIFSIGNALED(status)) << "it ended by itself: " << r.take;
        r.process = -1;
        --running;
      }
    }
    for (Recording& r : recordings)
      if (r.process > 0) {
        ::kill(r.process, SIGKILL);
        ::waitpid(r.process, nullptr, 0);
        ADD_FAILURE() << "no take appeared at " << r.take;
      }
    for (const Recording& r : recordings) {
      if (r.killed_s < 0) continue;
      const Outcome checked = run({"take", "check", r.take});
      EXPECT_EQ(checked.status, 0) << "killed after " << r.killed_s << " s: " << checked.err;
      const auto take = take::Take::open(r.take);
      ASSERT_TRUE(take) << take.error().message();
      EXPECT_FALSE(take->finished());
      const double lost_s = r.killed_s - kept_s(*take);
      EXPECT_LE(lost_s, 1.0) << "killed after " << r.killed_s << " s";
      worst_s = std::max(worst_s, lost_s);
      total_s += lost_s;
      ++killed;
    }
  }
  RecordProperty("worst_loss_ms", static_cast<int>(1000 * worst_s));
  std::printf("%d kills: mean loss %.3f s, worst %.3f s\n", killed, total_s / killed, worst_s);
  EXPECT_EQ(killed, kills_wanted());
}

}  // namespace
}  // namespace mien::app::test
