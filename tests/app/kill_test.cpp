// Killed at random moments: a take that `mien perform --pace real` writes opens again and has lost a second
// at most; a training goes on from its last checkpoint and ends with the bits of one that nobody killed.
// MIEN_KILLS sets how many (default: 12 recordings, 3 trainings).
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "mien/core/random.h"
#include "mien/face/livelink_csv.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"
#include "mien/take/take.h"
#include "tests/app/program.h"
#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

namespace mien::app::test::kill_test {
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

int kills_wanted(int otherwise) {
  const char* wanted = std::getenv("MIEN_KILLS");
  return wanted == nullptr ? otherwise : std::atoi(wanted);
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
  const int wanted = kills_wanted(12);
  int left = wanted;
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
  EXPECT_EQ(killed, wanted);
}

constexpr const char* kToyRecipe =
    "seed = 3\n"
    "[network]\nlayers = 1\nd_model = 32\nheads = 1\nd_head = 32\nffn = 64\nwindow = 40\n"
    "[data]\nseed = 3\nperformers = 2\nvalidation_performers = 1\nseconds = 4\ndevice_seconds = 2\n"
    "[optimiser]\nbatch = 8\nwarm_up_steps = 10\nprecision = \"fp32\"\n"
    "[validation]\nwindows = 8\nevery_steps = 10\n[sampler]\nsteps = [1]\nframes = 120\n[budget]\nsteps = "
    "200\n";

/// Rows of the curve that a training keeps beside its model.
std::size_t rows(const std::string& curve) {
  return static_cast<std::size_t>(std::ranges::count(content(curve), '\n'));
}

TEST(Killed, ATrainingGoesOnFromItsLastCheckpoint) {
  if (!std::filesystem::exists(std::filesystem::path(test::program_path()).parent_path() / "mien-train"))
    GTEST_SKIP() << "no mien-train is built beside mien";
  const Folder folder;
  write(folder / "rig.toml", virt::test::kRig);
  write(folder / "toy.toml", kToyRecipe);
  const auto arguments = [&](const std::string& name) {
    return std::vector<std::string>{
        "train", folder / "toy.toml", "--rig",   folder / "rig.toml", "--threads", "1",
        "--out", folder / name,       "--resume"};
  };
  const Outcome whole = run(arguments("whole.safetensors"));
  ASSERT_EQ(whole.status, 0) << whole.err;

  Random random(20'27);
  const int wanted = kills_wanted(3);
  int killed = 0;
  std::size_t reached = 0;
  while (killed < wanted) {
    const pid_t process = start(arguments("m.safetensors"), folder / "out", folder / "err");
    ASSERT_GT(process, 0);
    // Once it has come further, at any moment of the steps to its next checkpoints, and while it writes them.
    int status = 0;
    pid_t gone = 0;
    while (gone == 0 && rows(folder / "m.csv") <= reached) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      gone = ::waitpid(process, &status, WNOHANG);
    }
    if (gone == 0) {
      std::this_thread::sleep_for(std::chrono::duration<double>(random.uniform(0, 0.15)));
      ::kill(process, SIGKILL);
      ::waitpid(process, &status, 0);
    }
    const bool ended = WIFEXITED(status);
    ASSERT_TRUE(!ended || WEXITSTATUS(status) == 0) << content(folder / "err");
    if (!ended) ++killed;
    if (std::filesystem::exists(folder / "m.safetensors")) {  // It was quicker: once more from the start.
      for (const char* file : {"m.safetensors", "m.csv"}) std::filesystem::remove(folder / file);
      reached = 0;
      continue;
    }
    const std::size_t now = rows(folder / "m.csv");
    EXPECT_GE(now, reached) << "a checkpoint was lost";
    reached = now;
  }
  const Outcome last = run(arguments("m.safetensors"));
  ASSERT_EQ(last.status, 0) << last.err;
  const auto uncut = model::read_model(folder / "whole.safetensors"),
             cut = model::read_model(folder / "m.safetensors");
  ASSERT_TRUE(uncut) << uncut.error().message();
  ASSERT_TRUE(cut) << cut.error().message();
  ASSERT_EQ(cut->network.size(), uncut->network.size());
  for (std::size_t i = 0; i < cut->network.size(); ++i)
    EXPECT_EQ(cut->network[i].values, uncut->network[i].values) << cut->network[i].name;
  std::printf("%d kills of a training\n", killed);
}

}  // namespace
}  // namespace mien::app::test::kill_test
