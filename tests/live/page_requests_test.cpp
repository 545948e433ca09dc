#include "mien/live/page_requests.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "mien/core/files.h"
#include "tests/folder.h"

namespace mien::live::page_requests_test {
namespace {

using testing::HasSubstr;

const char* const kRig = R"(name = "one"  # Mine.
reference = "eye_L"
[[sensor]]
name = "eye_L"
kind = "camera"
site = "eye"
side = "L"
role = "face"
position_m = [0.05, 0.02, 0.1245]
[sensor.camera]
look_at_m = [0.031, 0.042, 0.093]
up = [0.0, 1.0, 0.0]
)";

TEST(PageRequests, ViewsGoIntoTheSessionsRigFileAndNothingElseDoes) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  const std::filesystem::path path = folder / "one.toml";
  ASSERT_TRUE(write_file(path, std::string_view(kRig)));
  const sensor::Rig rig = sensor::read_rig(path).value();
  std::vector<session::Report::Link> links(1);
  links[0].view = {.crop = {0, 0.25, 0.5, 0.5}, .turn_deg = 0, .mirror = true};
  const auto saved = save_views(path, rig, links);
  ASSERT_TRUE(saved) << saved.error().message();
  EXPECT_EQ(nlohmann::json::parse(*saved)["rig"], path.string());
  EXPECT_EQ(read_text(path).value(),
            std::string(kRig).replace(std::string(kRig).find("look_at"), 0,
                                      "crop = [0, 0.25, 0.5, 0.5]\nmirror = true\n"));
}

TEST(PageRequests, ASessionWithoutCamerasOrWithoutAFileSavesNone) {
  const sensor::Rig rig = sensor::parse_rig(kRig, "one").value();
  std::vector<session::Report::Link> links(1);
  EXPECT_EQ(save_views("one.toml", rig, links).error().code, ErrorCode::unsupported);
  links[0].view.emplace();
  const auto refused = save_views({}, rig, links);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr("rig file"));
  EXPECT_EQ(save_views("/nowhere/one.toml", rig, links).error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace mien::live::page_requests_test
