#include "mien/performer/lines.h"

#include <gtest/gtest.h>

#include <set>

namespace mien::performer::lines_test {
namespace {

TEST(Lines, FourLanguagesWithLinesThatCloseTheLips) {
  ASSERT_EQ(reading_languages().size(), 4U);
  for (const ReadingLanguage& language : reading_languages()) {
    std::size_t bilabials = 0;
    for (const std::string_view line : language.lines)
      for (const char letter : line) bilabials += std::string_view("pbm").contains(letter) ? 1 : 0;
    EXPECT_GE(bilabials, 10U) << language.voice;
  }
}

TEST(Lines, InventedOnesDifferAndAreTheSameForTheSameSeed) {
  for (std::size_t l = 0; l <= kNoLanguage; ++l) {
    Random random(5), again(5);
    std::set<std::string> lines;
    for (int i = 0; i < 50; ++i) {
      const std::string line = invented_line(l, random);
      EXPECT_EQ(line, invented_line(l, again));
      EXPECT_GE(line.size(), 8U);
      EXPECT_TRUE(line.ends_with('.') || line.ends_with('?'));
      EXPECT_EQ(line.find("  "), std::string::npos) << line;
      lines.insert(line);
    }
    EXPECT_EQ(lines.size(), 50U);
  }
}

TEST(Lines, OfNoLanguageAreInPlainLettersAndAskNothing) {
  ASSERT_EQ(reading_languages().size(), kNoLanguage);
  Random random(7);
  for (int i = 0; i < 200; ++i)
    for (const char letter : invented_line(kNoLanguage, random))
      EXPECT_TRUE((letter >= 'a' && letter <= 'z') || letter == ' ' || letter == ',' || letter == '.');
}

}  // namespace
}  // namespace mien::performer::lines_test
