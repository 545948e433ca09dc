#include "mien/shaping/centre.h"

#include <gtest/gtest.h>

namespace mien::shaping::centre_test {
namespace {

TEST(Centre, GoesThroughJson) {
  Centre centre;
  centre.rest[3] = 0.1f;
  centre.rest[52] = 0.5f;
  centre.yaw_rad = -0.123456789;
  EXPECT_EQ(parse_centre(write_centre(centre), "test").value(), centre);
  EXPECT_EQ(parse_centre("{}", "test").value(), Centre{});
  EXPECT_EQ(write_centre(centre).find("position"), std::string::npos);
  centre.position_m = {0.1, -0.25, 10};
  EXPECT_EQ(parse_centre(write_centre(centre), "test").value(), centre);
}

TEST(Centre, RefusesWhatIsNoCentre) {
  const auto code = [](const char* text) { return parse_centre(text, "test").error().code; };
  for (const char* text :
       {"", "[]", "{", "nonsense", R"({"yaw_rad": "a"})", R"({"rest": 1})",
        R"({"rest": {"noSuchShape": 0.1}})", R"({"rest": {"jawOpen": null}})", R"({"more": 1})",
        R"({"yaw_rad": 1e999})", R"({"position_m": 1})", R"({"position_m": [0, 1]})",
        R"({"position_m": [0, 1, "2"]})", R"({"position_m": [0, 1, 2, 3]})"})
    EXPECT_EQ(code(text), ErrorCode::malformed) << text;
  for (const char* text : {R"({"yaw_rad": 4})", R"({"position_m": [0, 10.5, 0]})",
                           R"({"rest": {"jawOpen": 0.6}})", R"({"rest": {"jawOpen": -0.1}})"})
    EXPECT_EQ(code(text), ErrorCode::out_of_range) << text;
}

}  // namespace
}  // namespace mien::shaping::centre_test
