#include "lab/peak.h"

#include <gtest/gtest.h>

namespace mien::lab::peak_test {
namespace {

// How fast is this machine's affair; that something was measured is ours.
TEST(Peak, IsMoreThanNothing) {
  EXPECT_GT(peak_gflops(), 0);
  EXPECT_GT(read_gb_s(100'000), 0);
  EXPECT_GT(read_gb_s(1), 0);
}

}  // namespace
}  // namespace mien::lab::peak_test
