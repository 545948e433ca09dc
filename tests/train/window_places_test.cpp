#include "mien/train/window_places.h"

#include <gtest/gtest.h>

#include <array>

namespace mien::train::window_places_test {
namespace {

TEST(WindowPlaces, AreThoseWhereAWindowFits) {
  EXPECT_EQ(WindowPlaces({10, 3, 12}, 4).count(), 7u + 0u + 9u);
  EXPECT_EQ(WindowPlaces({3, 2}, 4).count(), 0u);
  EXPECT_TRUE(WindowPlaces({3, 2}, 4).even(5).empty());
}

TEST(WindowPlaces, AreDrawnEvenly) {
  const WindowPlaces places({5, 3, 6}, 4);  // 2, 0 and 3.
  Random random(1);
  std::array<int, 5> drawn{};
  for (int i = 0; i < 5000; ++i) {
    const WindowPlaces::Place place = places.draw(random);
    ASSERT_TRUE((place.sequence == 0 && place.first < 2) || (place.sequence == 2 && place.first < 3));
    ++drawn[place.sequence == 0 ? place.first : 2 + place.first];
  }
  for (const int times : drawn) EXPECT_NEAR(times, 1000, 150);
}

TEST(WindowPlaces, EvenOnesDoNotLieOverEachOther) {
  const auto all = WindowPlaces({10, 3, 12}, 4).even(100);
  ASSERT_EQ(all.size(), 2u + 3u);
  EXPECT_EQ(all[1].first, 4u);
  EXPECT_EQ(all[2].sequence, 2u);
  const auto two = WindowPlaces({10, 3, 12}, 4).even(2);
  ASSERT_EQ(two.size(), 2u);
  EXPECT_EQ(two[0].sequence, 0u);
  EXPECT_EQ(two[1].sequence, 2u);
}

}  // namespace
}  // namespace mien::train::window_places_test
