#include "mien/sink/ws_admission.h"

#include <gtest/gtest.h>

#include <string>

namespace mien::sink::ws_admission_test {
namespace {

TEST(WsAdmission, LetsProgramsAndPagesOfThisMachineIn) {
  EXPECT_EQ(judge_upgrade("/", std::nullopt, "127.0.0.1:8741", ""), Admission::admitted);
  for (const char* origin :
       {"http://localhost:8740", "http://127.0.0.1", "https://127.1.2.3:9", "http://[::1]:8740"})
    EXPECT_EQ(judge_upgrade("/", origin, "127.0.0.1:8741", ""), Admission::admitted) << origin;
}

TEST(WsAdmission, KeepsPagesOfOthersOut) {
  for (const char* origin : {"http://evil.example", "null", "", "http://", "file://",
                             "http://localhost.evil.example", "http://127.0.0.1.evil.example",
                             "http://evil.example:8741", "http://192.168.1.7", "http://[::2]", "http://["})
    EXPECT_EQ(judge_upgrade("/", origin, "127.0.0.1:8741", ""), Admission::foreign_origin) << origin;
  // A name that was made to mean this machine asks for its own host; without a token that says nothing.
  EXPECT_EQ(judge_upgrade("/", "http://evil.example:8741", "evil.example:8741", ""),
            Admission::foreign_origin);
}

TEST(WsAdmission, WantsItsToken) {
  const std::string token = "abcd1234";
  for (const char* target : {"/?token=abcd1234", "/a/b?x=1&token=abcd1234", "/?token=abcd1234&token=no"}) {
    EXPECT_EQ(judge_upgrade(target, std::nullopt, "a", token), Admission::admitted) << target;
    EXPECT_EQ(judge_upgrade(target, "http://studio:8741", "studio:8741", token), Admission::admitted);
    EXPECT_EQ(judge_upgrade(target, "http://evil.example", "studio:8741", token), Admission::foreign_origin);
  }
  for (const char* target :
       {"/", "/?token=", "/?token=abcd1235", "/?token=abcd12345", "/?tokens=abcd1234", "/token=abcd1234"})
    EXPECT_EQ(judge_upgrade(target, std::nullopt, "a", token), Admission::no_token) << target;
}

TEST(WsAdmission, KnowsWhatATokenIs) {
  EXPECT_TRUE(is_token("abcdEFGH-._~09"));
  EXPECT_FALSE(is_token("short"));
  EXPECT_FALSE(is_token("has a blank"));
  EXPECT_FALSE(is_token("percent%20"));
  EXPECT_FALSE(is_token(std::string(129, 'a')));
}

}  // namespace
}  // namespace mien::sink::ws_admission_test
