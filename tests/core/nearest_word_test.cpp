#include "mien/core/nearest_word.h"

#include <gtest/gtest.h>

namespace mien::nearest_word_test {
namespace {

const std::vector<std::string> kKnown = {"smile", "studio", "soft"};

TEST(NearestWord, TakesAThirdOfTheLettersWrong) {
  EXPECT_EQ(nearest_word("smiel", kKnown), "smile");
  EXPECT_EQ(nearest_word("studoi", kKnown), "studio");
  EXPECT_EQ(nearest_word("sof", kKnown), "soft");
  EXPECT_EQ(nearest_word("infrared", kKnown), "");
  EXPECT_EQ(nearest_word("", kKnown), "");
}

TEST(NearestWord, EndsAMessageOrAddsNothing) {
  EXPECT_EQ(did_you_mean("smiel", kKnown), "; did you mean smile?");
  EXPECT_EQ(did_you_mean("infrared", kKnown), "");
}

}  // namespace
}  // namespace mien::nearest_word_test
