#include "mien/virtual/headset/watched_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "mien/builtin_face/builtin_face.h"

namespace mien::virt::watched_parts_test {
namespace {

/// Looks along -z at a square of points, 40 mm wide, at 60 mm.
render::Lens lens() {
  return render::make_lens({0, 0, 0.06F}, Vec3f::Zero(), Vec3f::UnitY(), 1.2F, 0, 64, 64);
}

struct Square {
  Square() {
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x)
        points_m.emplace_back(0.005F * (static_cast<float>(x) - 3.5F),
                              0.005F * (static_cast<float>(y) - 3.5F), 0.0F);
    watched.resize(points_m.size());
    std::iota(watched.begin(), watched.end(), 0U);
  }
  std::vector<Vec3f> points_m;
  std::vector<std::uint32_t> watched;
  std::vector<std::uint8_t> picture = std::vector<std::uint8_t>(64 * 64, 100);
  [[nodiscard]] double hidden(const HidingMesh& thing = {}) const {
    return hidden_share(watched, points_m, thing, lens(), picture);
  }
};

TEST(WatchedParts, APlateHidesWhatIsBehindIt) {
  const Square square;
  EXPECT_EQ(square.hidden(), 0);
  // To the right of the middle, half-way, as far behind the face, and behind the camera.
  for (const auto& [z_m, hidden] : {std::pair(0.03F, 0.5), std::pair(-0.03F, 0.0), std::pair(0.09F, 0.0)}) {
    const std::vector<Vec3f> plate_m = {{0, -1, z_m}, {1, -1, z_m}, {1, 1, z_m}, {0, 1, z_m}};
    const std::vector<std::array<std::uint32_t, 3>> front = {{0, 1, 2}, {0, 2, 3}},
                                                    back = {{2, 1, 0}, {3, 2, 0}};
    EXPECT_EQ(square.hidden({plate_m, front}), hidden) << z_m;
    EXPECT_EQ(square.hidden({plate_m, back}), hidden) << z_m;
  }
}

TEST(WatchedParts, WhiteAndBlackShowNothing) {
  Square square;
  std::fill_n(square.picture.begin(), square.picture.size() / 2, std::uint8_t{255});
  EXPECT_EQ(square.hidden(), 0.5);
  std::fill(square.picture.begin() + 64 * 32, square.picture.end(), std::uint8_t{0});
  EXPECT_EQ(square.hidden(), 1);
}

TEST(WatchedParts, WhatLeavesTheViewIsHidden) {
  Square square;
  for (Vec3f& point_m : square.points_m) point_m.x() += 1;
  EXPECT_EQ(square.hidden(), 1);
  square.watched.clear();
  EXPECT_EQ(square.hidden(), 0) << "a view that is there for nothing misses nothing";
}

TEST(WatchedParts, AreOfTheRegionAndInView) {
  const face::Face face = builtin_face::make_builtin();
  const Vec3f mouth_m = face.neutral_m[face.landmarks[62]];
  const render::Lens before =
      render::make_lens(mouth_m + Vec3f(0, 0, 0.06F), mouth_m, Vec3f::UnitY(), 1, 0, 64, 64);
  const auto watched = watched_vertices(face, true, before);
  EXPECT_EQ(watched.size(), 48U);
  EXPECT_TRUE(std::ranges::is_sorted(watched));
  for (const std::uint32_t v : watched) EXPECT_LT((face.neutral_m[v] - mouth_m).head<2>().norm(), 0.08F);
  const render::Lens behind =
      render::make_lens(mouth_m + Vec3f(0, 0, 0.06F), mouth_m + Vec3f(0, 0, 1), Vec3f::UnitY(), 1, 0, 64, 64);
  EXPECT_TRUE(watched_vertices(face, true, behind).empty());
}

}  // namespace
}  // namespace mien::virt::watched_parts_test
