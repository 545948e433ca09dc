#include "mien/sink/osc_bundles.h"

#include <gtest/gtest.h>

#include "tests/hex.h"
#include "tests/sink/osc_reading.h"

namespace mien::sink::osc_bundles_test {
namespace {

/// Known vectors, two messages in a bundle.
TEST(OscBundles, AreTheKnownBytes) {
  Datagrams out;
  OscBundles bundles(out);
  bundles.add("/VMC/Ext/Blend/Val", "JawOpen", 0.5F);
  bundles.add("/VMC/Ext/Blend/Apply");
  bundles.finish();
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].size(), 88u);
  EXPECT_EQ(hex(out[0]),
            "2362756e646c65000000000000000001"
            "00000024"
            "2f564d432f4578742f426c656e642f56616c00002c7366004a61774f70656e003f000000"
            "0000001c"
            "2f564d432f4578742f426c656e642f4170706c79000000002c000000");
}

TEST(OscBundles, WritesWhatVrchatTakes) {
  Datagrams out;
  OscBundles bundles(out);
  bundles.add("/avatar/parameters/v2/JawOpen", 0.25F);
  bundles.add("/avatar/parameters/v2/JawOpen2", true);
  bundles.finish();
  EXPECT_EQ(hex(out[0].subspan(20, 40)),
            "2f6176617461722f706172616d65746572732f76322f4a61774f70656e0000002c6600003e800000");
  EXPECT_EQ(hex(out[0].subspan(64)),
            "2f6176617461722f706172616d65746572732f76322f4a61774f70656e3200002c540000");
}

TEST(OscBundles, BeginsAnotherBeforeOneIsTooLarge) {
  Datagrams out;
  OscBundles bundles(out);
  const std::string text(97, 'x');
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(bundles.add("/some/address", text.c_str(), osc::int32{i}));
  bundles.finish();
  EXPECT_GT(out.size(), 5u);
  for (std::size_t i = 0; i < out.size(); ++i) {
    EXPECT_LE(out[i].size(), OscBundles::kMaxBytes);
    EXPECT_EQ(out[i].size() % 4, 0u);
    // No room for another of its kind is left, but in the last.
    if (i + 1 < out.size()) {
      EXPECT_GT(out[i].size() + 140, OscBundles::kMaxBytes);
    }
  }
  const auto messages = test::osc_messages(out);
  ASSERT_EQ(messages.size(), 100u);
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(std::get<int>(messages[static_cast<std::size_t>(i)].arguments[1]), i);
}

TEST(OscBundles, LeavesOutWhatFitsNowhere) {
  Datagrams out;
  OscBundles bundles(out);
  const std::string text(1390, 'x');
  EXPECT_FALSE(bundles.add("/a", text.c_str()));
  bundles.finish();
  EXPECT_EQ(out.size(), 0u);
}

}  // namespace
}  // namespace mien::sink::osc_bundles_test
