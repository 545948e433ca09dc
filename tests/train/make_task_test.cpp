#include "mien/train/make_task.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "mien/core/files.h"
#include "mien/core/time.h"
#include "mien/face/livelink_csv.h"
#include "tests/folder.h"
#include "tests/project_path.h"
#include "tests/train/toy_data.h"

namespace mien::train::make_task_test {
namespace {

class MakeTask : public testing::Test {
 protected:
  [[nodiscard]] TaskSource source(const std::string& rig) const {
    const std::string path = project_path("rigs/" + rig + ".toml");
    std::string text = *read_text(path);
    return {.where = "r.toml",
            .face = "builtin",
            .rig = *sensor::parse_rig(text, path),
            .rig_text = text,
            .speaker = {},
            .films = folder_ / "films",
            .views = {}};
  }
  [[nodiscard]] static Error refusal(const std::string& recipe, const TaskSource& source) {
    const auto task = make_task(*parse_recipe(recipe, "r.toml"), source, no_progress);
    EXPECT_FALSE(task);
    if (task) return {};
    EXPECT_TRUE(is_bad_input(task.error().code)) << task.error().message();
    EXPECT_EQ(task.error().message().find('\n'), std::string::npos);
    return task.error();
  }

  mien::test::Folder folder_;
  std::string causal_ = toy_causal_recipe(1, "[data]\nperformers = 1\nvalidation_performers = 1\n");
};

TEST_F(MakeTask, TakesThatARecipeAsksForMustBeGiven) {
  const Error error = refusal(causal_ + "[takes]\nshare = 0.3\n", source("default"));
  EXPECT_EQ(error.code, ErrorCode::bad_usage);
  EXPECT_EQ(error.where, "r.toml");
  EXPECT_NE(error.message().find("--takes"), std::string::npos) << error.message();
}

TEST_F(MakeTask, OnlyImusLearnFromTakes) {
  for (const char* rig : {"eyewear", "microphone", "headset"}) {
    TaskSource with_takes = source(rig);
    with_takes.takes = folder_.path();
    EXPECT_NE(refusal(causal_, with_takes).what.find("only IMUs"), std::string::npos) << rig;
    EXPECT_NE(refusal(causal_ + "[takes]\n", source(rig)).what.find("only IMUs"), std::string::npos) << rig;
  }
}

TEST_F(MakeTask, OnlyWearersOfImusPerformRecordings) {
  for (const char* rig : {"eyewear", "microphone", "headset"}) {
    TaskSource with_recorded = source(rig);
    with_recorded.recorded = folder_.path();
    EXPECT_NE(refusal(causal_, with_recorded).what.find("only wearers of IMUs"), std::string::npos) << rig;
  }
  TaskSource unasked = source("default");
  unasked.recorded = folder_.path();
  EXPECT_NE(refusal(causal_, unasked).message().find("recorded_share"), std::string::npos);
}

TEST_F(MakeTask, RemembersWhichRecordingsItIsTrainedOn) {
  face::Motion motion;
  motion.frames.resize(90);
  for (std::size_t i = 0; i < motion.frames.size(); ++i)
    motion.frames[i].time_s = static_cast<double>(i) / kFrameRateHz;
  ASSERT_TRUE(write_file(folder_ / "a.csv", face::format_livelink_csv(motion)));
  TaskSource with_recorded = source("default");
  with_recorded.recorded = folder_.path();
  const std::string recipe =
      toy_causal_recipe(1,
                        "[data]\nperformers = 1\nvalidation_performers = 1\nseconds = 2\ndevice_seconds = 0\n"
                        "recorded_share = 0.5\nrecorded = [\"a.csv\"]\n");
  const auto task = make_task(*parse_recipe(recipe, "r.toml"), with_recorded, no_progress);
  ASSERT_TRUE(task) << task.error().message();
  EXPECT_EQ((*task)->recipe().recorded, std::vector<std::string>{"a.csv"});
}

TEST_F(MakeTask, WithoutTheFolderOfRecordingsAllIsDrawnAndItSaysSo) {
  std::string output;
  TaskSource without = source("default");
  without.tell = [&output](const std::string& line) { output += line; };
  const std::string recipe =
      toy_causal_recipe(1,
                        "[data]\nperformers = 1\nvalidation_performers = 1\nseconds = 2\ndevice_seconds = 0\n"
                        "recorded_share = 0.5\nrecorded = [\"a.csv\"]\n");
  EXPECT_TRUE(make_task(*parse_recipe(recipe, "r.toml"), without, no_progress));
  EXPECT_NE(output.find("--recorded"), std::string::npos) << output;
}

TEST_F(MakeTask, SplitsAreOfTakes) {
  TaskSource splits_alone = source("default");
  splits_alone.splits = folder_ / "splits.toml";
  EXPECT_EQ(refusal(causal_, splits_alone).code, ErrorCode::bad_usage);
}

TEST_F(MakeTask, AFolderWithoutTakesIsRefusedBeforeAnybodyPerforms) {
  TaskSource empty = source("default");
  empty.takes = folder_.path();
  bool performed = false;
  const auto task = make_task(*parse_recipe(causal_, "r.toml"), empty, [&](double, std::string_view what) {
    performed = performed || what.find("perform") != std::string_view::npos;
    return true;
  });
  ASSERT_FALSE(task);
  EXPECT_EQ(task.error().code, ErrorCode::not_found) << task.error().message();
  EXPECT_FALSE(performed);
}

TEST_F(MakeTask, VirtualPerformersAloneNeedNoTakes) {
  std::vector<std::string> told;
  TaskSource virtual_alone = source("default");
  virtual_alone.tell = [&](const std::string& line) { told.push_back(line); };
  const std::string recipe = toy_causal_recipe(
      1, "[data]\nperformers = 1\nvalidation_performers = 1\nseconds = 2\ndevice_seconds = 0\n");
  const auto task = make_task(*parse_recipe(recipe, "r.toml"), virtual_alone, no_progress);
  ASSERT_TRUE(task) << task.error().message();
  EXPECT_TRUE(told.empty());
  EXPECT_FALSE((*task)->recipe().takes_share);
}

}  // namespace
}  // namespace mien::train::make_task_test
