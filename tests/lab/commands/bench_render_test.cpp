// `mien bench render` from outside: what it prints, not how fast.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/app/program.h"

namespace mien::app::test::bench_render_test {
namespace {

TEST(BenchRender, SaysWhatFacesStillsAndFilmsTake) {
  const Outcome outcome =
      run({"bench", "render", "--frames", "3", "--strangers", "2", "--face", "builtin,hair=none", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["film"]["frames"], 3);
  EXPECT_GT(json["film"]["median_ms"], 0);
  EXPECT_GT(json["film"]["rays_alone_ms"], 0);
  EXPECT_LE(json["still"]["median_ms"], json["still"]["worst_ms"]);
  EXPECT_GT(json["builtin_face"]["first_ms"], 0);
  EXPECT_GT(json["builtin_face"]["further"]["median_ms"], 0);
}

TEST(BenchRender, AsksForAFaceThatIs) {
  const Outcome outcome = run({"bench", "render", "--face", "builtin:adda"});
  EXPECT_NE(outcome.status, 0);
  EXPECT_NE(outcome.err.find("ada"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace mien::app::test::bench_render_test
