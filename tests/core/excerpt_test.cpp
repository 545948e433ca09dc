#include "mien/core/excerpt.h"

#include <gtest/gtest.h>

#include "mien/core/utf8.h"

namespace mien::excerpt_test {
namespace {

TEST(Excerpt, LeavesPrintableTextAsItIs) {
  for (const char* text : {"", "jawOpen",
                           "Kiefer \xC3\xB6"
                           "ffnen",
                           "\xE9\xA1\x8E", "\xF0\x9F\x99\x82 it's \"x\""})
    EXPECT_EQ(excerpt(text), text);
}

TEST(Excerpt, ObeysNothingThatATerminalWould) {
  EXPECT_EQ(excerpt("\x1b]0;pwned\x07"), "?]0;pwned?");
  EXPECT_EQ(excerpt(std::string_view("a\0b\x7F", 4)), "a?b?");
  EXPECT_EQ(excerpt("one\ntwo\r\n\tthree"), "one two   three");
  EXPECT_EQ(excerpt("\xC2\x9B"
                    "31m"),
            "?31m")
      << "a control sequence in one character";
  EXPECT_EQ(excerpt("\xE2\x80\xAE"
                    "gpj.exe"),
            "?gpj.exe")
      << "written from right to left";
  EXPECT_EQ(excerpt("\xFF\xFE"
                    "a\xC3"),
            "??a?")
      << "no UTF-8";
}

TEST(Excerpt, CutsByLetters) {
  const std::string forty(40, 'x');
  EXPECT_EQ(excerpt(forty), forty);
  EXPECT_EQ(excerpt(forty + "y"), forty + "...");
  EXPECT_EQ(excerpt(std::string(10'000, '\x01')), std::string(40, '?') + "...");
  std::string wide;
  for (int i = 0; i < 41; ++i) wide += "\xC3\xB6";
  EXPECT_EQ(excerpt(wide).size(), 83U);
  EXPECT_TRUE(is_utf8(excerpt(wide)));
  EXPECT_EQ(excerpt("abc", 2), "ab...");
}

TEST(Excerpt, AWholeTextKeepsItsLength) {
  const std::string line = std::string(100, 'x') + "\x1b[2J" + std::string(100, 'y');
  EXPECT_EQ(without_controls(line), std::string(100, 'x') + "?[2J" + std::string(100, 'y'));
}

}  // namespace
}  // namespace mien::excerpt_test
