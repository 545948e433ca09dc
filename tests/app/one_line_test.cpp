#include "app/one_line.h"

#include <gtest/gtest.h>

namespace mien::app::one_line_test {
namespace {

TEST(OneLine, LeavesNothingThatATerminalObeys) {
  EXPECT_EQ(one_line("a\x1b[2Jb\r\nc\x7f"), "a?[2Jb  c?");
  EXPECT_EQ(one_line("a\xC2\x9B"
                     "31m"),
            "a?31m");
  EXPECT_EQ(one_line("\xE2\x80\xAE"
                     "gpj.exe"),
            "?gpj.exe")
      << "written from right to left";
  EXPECT_EQ(one_line("J\xC3\xBCrgen \xC2\xB0"), "J\xC3\xBCrgen \xC2\xB0");
}

TEST(OneLine, CutsWhatIsTooLong) {
  EXPECT_EQ(one_line("abcdef", 3), "abc...");
  EXPECT_EQ(one_line("abc", 3), "abc");
  EXPECT_EQ(one_line("\xC3\xBC\xC3\xBC", 1), "\xC3\xBC...") << "no half letters";
  EXPECT_EQ(one_line(""), "");
}

}  // namespace
}  // namespace mien::app::one_line_test
