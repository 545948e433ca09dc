#include "mien/face/corrective.h"

#include <gtest/gtest.h>

#include <vector>

namespace mien::face::corrective_test {
namespace {

TEST(Corrective, AddsTheProductOfWhatDrivesIt) {
  const std::vector<Corrective> both = {{.drivers = {{shape("jawOpen"), 0, 1}, {shape("mouthLeft"), 0, 4}},
                                         .vertex = {1},
                                         .delta_m = {{1, 0, 0}}}};
  const auto moved = [&](float jaw, float left) {
    BlendshapeWeights weights;
    weights[shape("jawOpen")] = jaw;
    weights[shape("mouthLeft")] = left;
    std::vector<Vec3f> vertices(2, Vec3f::Zero());
    add_correctives(both, weights, vertices);
    EXPECT_EQ(vertices[0], Vec3f::Zero());
    return vertices[1].x();
  };
  EXPECT_EQ(moved(1, 0), 0);
  EXPECT_EQ(moved(0, 1), 0);
  EXPECT_EQ(moved(-1, 1), 0) << "below where it begins";
  EXPECT_FLOAT_EQ(moved(0.5F, 0.5F), 0.25F);
  EXPECT_FLOAT_EQ(moved(1.2F, 1.1F), 1.1F) << "the jaw ends at 1";
}

TEST(Corrective, MayBeginBeyondAFullShape) {
  const std::vector<Corrective> beyond = {
      {.drivers = {{shape("eyeBlink_L"), 1, 4}}, .vertex = {0}, .delta_m = {{0, 1, 0}}}};
  BlendshapeWeights weights;
  std::vector<Vec3f> vertices(1, Vec3f::Zero());
  weights[shape("eyeBlink_L")] = 1;
  add_correctives(beyond, weights, vertices);
  EXPECT_EQ(vertices[0].y(), 0);
  weights[shape("eyeBlink_L")] = 1.25F;
  add_correctives(beyond, weights, vertices);
  EXPECT_FLOAT_EQ(vertices[0].y(), 0.25F);
}

TEST(Corrective, NoneLeaveTheFaceAsItIs) {
  BlendshapeWeights weights;
  weights[shape("jawOpen")] = 1;
  std::vector<Vec3f> vertices(1, Vec3f(1, 2, 3));
  add_correctives({}, weights, vertices);
  EXPECT_EQ(vertices[0], Vec3f(1, 2, 3));
}

}  // namespace
}  // namespace mien::face::corrective_test
