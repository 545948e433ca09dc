#include "mien/face/frame_hash.h"

#include <gtest/gtest.h>

namespace mien::face::frame_hash_test {
namespace {

std::string hash_of(const OutputFrame& frame) {
  FrameHash hash;
  hash.add(frame);
  return hash.hex();
}

TEST(FrameHash, APositionCountsOnlyWhereItIsKnown) {
  OutputFrame frame;
  frame.time = DeviceTime(std::chrono::seconds(1));
  frame.weights[3] = 0.5F;
  // Of sessions recorded before there were positions.
  const std::string before = "db26fa6ceae00d254b24b25f52341d95aaf1582b728b2bf0d0382c60fe0120f2";
  EXPECT_EQ(hash_of(frame), before);
  frame.head_position_m.x() = 0.5F;
  EXPECT_EQ(hash_of(frame), before);
  frame.head_position_known = true;
  const std::string at_half = hash_of(frame);
  EXPECT_NE(at_half, before);
  frame.head_position_m.z() = 0.25F;
  EXPECT_NE(hash_of(frame), at_half);
}

}  // namespace
}  // namespace mien::face::frame_hash_test
