#include "mien/modalities/modalities.h"
#include "tests/project_path.h"

#include <gtest/gtest.h>

namespace mien::modalities::modalities_test {
namespace {

TEST(Registry, ARigOfSeveralKindsTakesAFolderOfModels) {
  const sensor::Rig imus = sensor::read_rig(project_path("rigs/default.toml")).value();
  const sensor::Rig both = sensor::read_rig(project_path("rigs/imu_eyewear.toml")).value();
  EXPECT_TRUE(has_window_models(imus));
  EXPECT_FALSE(has_window_models(both));
  const auto file = live_model(imus, "");
  const auto folder = live_model(both, "");
  ASSERT_TRUE(file && folder);
  EXPECT_EQ(file->filename(), "live.safetensors");
  EXPECT_EQ(*folder, file->parent_path());
  EXPECT_EQ(live_model(both, "mine").value(), "mine");
  // The first that is missing is named.
  const auto missing = make_tracker(both, "no/such/folder");
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message().find("no/such/folder: a rig with sensors of several kinds"),
            std::string::npos)
      << missing.error().message();
}

TEST(Registry, RefusesSensorsOfAKindThatItDoesNotKnow) {
  sensor::Rig rig = sensor::read_rig(project_path("rigs/default.toml")).value();
  rig.sensors[3].kind = "camera";
  EXPECT_EQ(live_model(rig, "").error().code, ErrorCode::unsupported);
  EXPECT_EQ(make_tracker(rig, "models").error().code, ErrorCode::unsupported);
  EXPECT_FALSE(has_window_models(rig));
}

}  // namespace
}  // namespace mien::modalities::modalities_test
