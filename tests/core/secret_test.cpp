#include "mien/core/secret.h"

#include <gtest/gtest.h>

namespace mien::secret_test {
namespace {

TEST(Secret, IsTheSameOnlyWholly) {
  EXPECT_TRUE(same_secret("abcd1234", "abcd1234"));
  EXPECT_TRUE(same_secret("", ""));
  EXPECT_FALSE(same_secret("abcd1234", "abcd1235"));
  EXPECT_FALSE(same_secret("bbcd1234", "abcd1234"));
  EXPECT_FALSE(same_secret("abcd123", "abcd1234"));
  EXPECT_FALSE(same_secret("", "abcd1234"));
}

}  // namespace
}  // namespace mien::secret_test
