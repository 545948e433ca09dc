#include "mien/model/features.h"

#include <gtest/gtest.h>

namespace mien::model::features_test {
namespace {

TEST(Features, MissingValuesBecomeTheMeanAndSaySo) {
  const FeatureLayout layout{.sensors = {"a", "b"}, .presence_flags = true};
  const FeatureNormalisation normalisation{.mean = std::vector<float>(14, 1.0F),
                                           .scale = std::vector<float>(14, 0.5F)};
  const std::vector<float> values = {5, 5, 5, 1, 0, 0, 0, 2, -3, 100, 1, 0, 0, 0};
  std::vector<float> out(layout.width(), 9.0F);
  encode_values(layout, normalisation, values, std::vector<std::uint8_t>{1, 0, 0, 1}, out);
  EXPECT_EQ(out, (std::vector<float>{0, 0, 0, 0, -2, -2, -2, 2, -8, 8, 0, 0, 0, 0, 1, 0, 0, 1}));
}

TEST(Features, TheFaithfulLayoutHasNoFlags) {
  const FeatureLayout layout{.sensors = {"a"}, .presence_flags = false};
  EXPECT_EQ(layout.width(), 7U);
  const FeatureNormalisation normalisation{.mean = std::vector<float>(7, 0.0F),
                                           .scale = std::vector<float>(7, 1.0F)};
  std::vector<float> out(7);
  encode_values(layout, normalisation, std::vector<float>{1, 2, 3, 4, 5, 6, 7},
                std::vector<std::uint8_t>{1, 1}, out);
  EXPECT_EQ(out, (std::vector<float>{1, 2, 3, 4, 5, 6, 7}));
}

}  // namespace
}  // namespace mien::model::features_test
