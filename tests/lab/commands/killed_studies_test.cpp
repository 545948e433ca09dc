// Studies by short trainings that are killed go on where they were, to the same figures.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <thread>

#include "lab/imu/short_training.h"
#include "mien/sensor/rig.h"
#include "tests/app/program.h"
#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

namespace mien::app::test::killed_studies_test {
namespace {

/// A study by short trainings that is killed as soon as a training has left a file with each of `endings`,
/// and goes on after each, ends with the `figures` of one that nobody killed, and leaves nothing half done.
void expect_goes_on(const Folder& folder, const std::vector<std::string>& study, const std::string& figures,
                    const char* key, const std::vector<const char*>& endings) {
  const auto arguments = [&](const char* out) {
    std::vector<std::string> all = study;
    all.insert(all.end(), {"--out", folder / out});
    return all;
  };
  const Outcome whole = run(arguments("whole"));
  ASSERT_EQ(whole.status, 0) << whole.err;

  const auto has = [&](const char* ending) {
    std::error_code code;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "cut/trainings", code))
      if (const std::string name = entry.path().filename().string();
          name.ends_with(ending) && !name.starts_with("data-"))
        return true;
    return false;
  };
  for (const char* ending : endings) {
    const pid_t process = start(arguments("cut"), folder / "out", folder / "err");
    ASSERT_GT(process, 0);
    int status = 0;
    pid_t gone = 0;
    while (gone == 0 && !has(ending)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      gone = ::waitpid(process, &status, WNOHANG);
    }
    ASSERT_EQ(gone, 0) << "it ended before it could be killed: " << content(folder / "err");
    ::kill(process, SIGKILL);
    ::waitpid(process, &status, 0);
  }
  const Outcome last = run(arguments("cut"));
  ASSERT_EQ(last.status, 0) << last.err;
  const std::string expected = content(folder / ("whole/" + figures));
  EXPECT_NE(expected.find(key), std::string::npos);
  EXPECT_EQ(content(folder / ("cut/" + figures)), expected);
  EXPECT_FALSE(has(".checkpoint") || has(".part"));
  for (const auto& entry : std::filesystem::directory_iterator(folder / "cut/trainings"))
    EXPECT_FALSE(entry.path().filename().string().starts_with("data-")) << entry.path();
}

bool trainer_is_there() {
  return std::filesystem::exists(std::filesystem::path(program_path()).parent_path() / "mien-train");
}

TEST(KilledStudies, AnAblationGoesOnToTheSameFigures) {
  if (!trainer_is_there()) GTEST_SKIP() << "no mien-train is built beside mien";
  const Folder folder;
  write(folder / "rig.toml", virt::test::kRig);
  expect_goes_on(folder,
                 {"study", "ablation", "--rig", folder / "rig.toml", "--rows", "third_of_people", "--seeds",
                  "1", "--steps", "10", "--performers", "10", "--people", "1", "--no-shipped"},
                 "ablation.json", "pve_mm_by_seed_and_person", {".checkpoint", ".safetensors"});
}

TEST(KilledStudies, AStudyOfPlacementGoesOnToTheSameFigures) {
  if (!trainer_is_there()) GTEST_SKIP() << "no mien-train is built beside mien";
  const Folder folder;
  // Few candidates: sets of five are trained, and no eleven.
  const sensor::Rig few = *lab::rig_with_sensors(
      *sensor::read_rig(project_path("rigs/default.toml")),
      std::vector<std::string>{"frontalis_R", "frontalis_L", "zygomaticus_upper_R", "zygomaticus_upper_L",
                               "buccinator_R", "buccinator_L", "mentalis"});
  write(folder / "rig.toml", sensor::write_rig(few));
  expect_goes_on(folder,
                 {"study", "placement", "--rig", folder / "rig.toml", "--sensors", "5", "--grid", "20",
                  "--quick", "--seeds", "1", "--steps", "10", "--performers", "10", "--people", "2"},
                 "placement.json", "greedy-five", {".checkpoint"});
}

}  // namespace
}  // namespace mien::app::test::killed_studies_test
