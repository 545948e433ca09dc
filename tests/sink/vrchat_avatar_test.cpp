#include "mien/sink/vrchat_avatar.h"

#include <gtest/gtest.h>

namespace mien::sink::vrchat_avatar_test {
namespace {

TEST(VrchatAvatar, ReadsWhatVrchatWrites) {
  const auto avatar = parse_vrchat_avatar(
      "\xEF\xBB\xBF"
      R"({
    "id": "avtr_1", "name": "Fox",
    "parameters": [
      {"name": "FT/v2/JawOpen",
       "input": {"address": "/avatar/parameters/FT/v2/JawOpen", "type": "Float"},
       "output": {"address": "/avatar/parameters/FT/v2/JawOpen", "type": "Float"}},
      {"name": "VelocityX", "output": {"address": "/avatar/parameters/VelocityX", "type": "Float"}},
      {"name": "Hat", "input": {"address": "/avatar/parameters/Hat", "type": "Bool"}, "news": 7},
      {"name": "Mode", "input": {"address": "/avatar/parameters/Mode", "type": "Int"}}
    ]})",
      "fox.json");
  ASSERT_TRUE(avatar) << avatar.error().message();
  EXPECT_EQ(avatar->id, "avtr_1");
  EXPECT_EQ(avatar->name, "Fox");
  using Type = VrchatAvatar::Type;
  EXPECT_EQ(avatar->parameters,
            (std::vector<VrchatAvatar::Parameter>{{"/avatar/parameters/FT/v2/JawOpen", Type::real},
                                                  {"/avatar/parameters/Hat", Type::truth},
                                                  {"/avatar/parameters/Mode", Type::whole}}));
}

TEST(VrchatAvatar, RefusesEachMistakeAlone) {
  const auto code = [](const std::string& json) {
    const auto avatar = parse_vrchat_avatar(json, "x.json");
    EXPECT_FALSE(avatar) << json.substr(0, 80);
    return avatar ? ErrorCode::internal : avatar.error().code;
  };
  const auto with = [](const std::string& parameter) { return R"({"parameters": [)" + parameter + "]}"; };
  EXPECT_EQ(code(""), ErrorCode::malformed);
  EXPECT_EQ(code("{"), ErrorCode::malformed);
  EXPECT_EQ(code("[]"), ErrorCode::malformed);
  EXPECT_EQ(code("{}"), ErrorCode::malformed);
  EXPECT_EQ(code(R"({"parameters": {}})"), ErrorCode::malformed);
  EXPECT_EQ(code(with("7")), ErrorCode::malformed);
  EXPECT_EQ(code(with(R"({"input": 7})")), ErrorCode::malformed);
  EXPECT_EQ(code(with(R"({"input": {"address": "/a"}})")), ErrorCode::malformed);
  EXPECT_EQ(code(with(R"({"input": {"type": "Float"}})")), ErrorCode::malformed);
  EXPECT_EQ(code(with(R"({"input": {"address": 1, "type": "Float"}})")), ErrorCode::malformed);
  EXPECT_EQ(code(with(R"({"input": {"address": "a", "type": "Float"}})")), ErrorCode::malformed);
  EXPECT_EQ(code(with(R"({"input": {"address": "/a\u0000b", "type": "Float"}})")), ErrorCode::malformed);
  EXPECT_EQ(code(with(R"({"input": {"address": "/a", "type": "String"}})")), ErrorCode::unsupported);
  EXPECT_EQ(code(with(R"({"input": {"address": "/)" + std::string(600, 'a') + R"(", "type": "Int"}})")),
            ErrorCode::out_of_range);
  std::string many = "{}";
  for (std::size_t i = 0; i < kMaxAvatarParameters; ++i) many += ",{}";
  EXPECT_EQ(code(with(many)), ErrorCode::out_of_range);
  EXPECT_EQ(code(std::string(100'000, '[')), ErrorCode::out_of_range);
  // Brackets within text do not count.
  EXPECT_TRUE(parse_vrchat_avatar(R"({"name": "[[\"[[", "parameters": []})", "x"));
}

}  // namespace
}  // namespace mien::sink::vrchat_avatar_test
