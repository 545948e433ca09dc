#include "mien/face/gaze_targets.h"

#include <gmock/gmock.h>

#include <string>

namespace mien::face::gaze_targets_test {
namespace {

TEST(GazeTargets, AreFiveByTheirNames) {
  std::vector<std::string> names;
  for (const GazeTarget& target : gaze_targets()) {
    names.emplace_back(target.name);
    EXPECT_FALSE(target.prompt.empty()) << target.name;
  }
  EXPECT_THAT(names, testing::ElementsAre("look ahead", "look left", "look right", "look up", "look down"));
  EXPECT_GT(gaze_targets()[1].direction_rad.x(), 0) << "yaw is to the performer's left";
  EXPECT_GT(gaze_targets()[3].direction_rad.y(), 0) << "pitch is upwards";
}

/// What a prompt says is what is so.
TEST(GazeTargets, ArePromptedInDegrees) {
  for (const GazeTarget& target : gaze_targets()) {
    const float degrees = target.direction_rad.cwiseAbs().maxCoeff() * 57.29578F;
    const std::string said = std::to_string(static_cast<int>(degrees + 0.5F)) + " degrees";
    EXPECT_EQ(target.prompt.find(said) != std::string_view::npos, degrees > 0) << target.prompt;
  }
}

}  // namespace
}  // namespace mien::face::gaze_targets_test
