#include "mien/sensor/sensor_places.h"

#include <gtest/gtest.h>

namespace mien::sensor::sensor_places_test {
namespace {

TEST(SensorPlaces, FindsByNameAndSaysWhatIsMissing) {
  const auto places = sensor_places({"chin", "brow", "cheek"}, {"cheek", "ear", "chin"});
  EXPECT_EQ(places, (std::vector<std::ptrdiff_t>{2, -1, 0}));
  EXPECT_FALSE(none_placed(places));
  EXPECT_TRUE(none_placed(sensor_places({"chin"}, {"ear"})));
}

}  // namespace
}  // namespace mien::sensor::sensor_places_test
