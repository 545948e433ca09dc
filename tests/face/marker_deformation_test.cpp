#include "mien/face/marker_deformation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mien/builtin_face/builtin_face.h"

namespace mien::face::marker_deformation_test {
namespace {

/// A marker on each of the built-in face's landmarks of brows, nose and lips.
struct Marked {
  Face face = builtin_face::make_builtin({});
  Eigen::VectorXd at_m;
  std::vector<std::uint32_t> vertices;

  Marked() {
    for (std::size_t i = 17; i < 60; i += 2)
      if (i < 36 || i >= 48) vertices.push_back(face.landmarks[i]);
    at_m.resize(static_cast<Eigen::Index>(3 * vertices.size()));
    for (std::size_t m = 0; m < vertices.size(); ++m)
      at_m.segment<3>(static_cast<Eigen::Index>(3 * m)) = face.neutral_m[vertices[m]].cast<double>();
  }
};

const Marked& marked() {
  static const Marked made;
  return made;
}

TEST(MarkerDeformation, StillMarkersMoveNothing) {
  const auto deformation = MarkerDeformation::create(marked().face, marked().at_m);
  ASSERT_TRUE(deformation) << deformation.error().message();
  std::vector<Vec3f> moved(marked().face.neutral_m.size());
  deformation->apply(marked().face, marked().at_m, moved);
  EXPECT_EQ(moved, marked().face.neutral_m);
}

TEST(MarkerDeformation, EveryMarkerTakesItsSkinAlongAndFarSkinStays) {
  const Face& face = marked().face;
  const MarkerDeformation deformation = MarkerDeformation::create(face, marked().at_m).value();
  BlendshapeWeights smile;
  smile[shape("mouthSmile_L")] = smile[shape("browInnerUp_R")] = 1;
  std::vector<Vec3f> truth(face.neutral_m.size()), moved(face.neutral_m.size());
  evaluate(face, smile, 0, truth);
  Eigen::VectorXd markers = marked().at_m;
  for (std::size_t m = 0; m < marked().vertices.size(); ++m)
    markers.segment<3>(static_cast<Eigen::Index>(3 * m)) = truth[marked().vertices[m]].cast<double>();
  deformation.apply(face, markers, moved);
  for (const std::uint32_t v : marked().vertices) EXPECT_LT((moved[v] - truth[v]).norm(), 0.0005F);
  // Between the markers it is nearer to the smile than the still face is.
  double error = 0, still = 0;
  for (const std::uint32_t v : face.region("skin")->vertex) {
    error += static_cast<double>((moved[v] - truth[v]).squaredNorm());
    still += static_cast<double>((face.neutral_m[v] - truth[v]).squaredNorm());
  }
  EXPECT_LT(error, 0.4 * still);
  const auto back = *std::ranges::min_element(face.region("skin")->vertex, {},
                                              [&](std::uint32_t v) { return face.neutral_m[v].z(); });
  EXPECT_EQ(moved[back], face.neutral_m[back]);
}

TEST(MarkerDeformation, RefusesWhatItCannotHold) {
  const Face& face = marked().face;
  EXPECT_FALSE(MarkerDeformation::create(face, Eigen::VectorXd()));
  EXPECT_FALSE(MarkerDeformation::create(face, marked().at_m.head(4)));
  EXPECT_FALSE(MarkerDeformation::create(face, marked().at_m, 0));
  Eigen::VectorXd nan = marked().at_m;
  nan[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(MarkerDeformation::create(face, nan));
  Face bare = face;
  bare.regions.clear();
  EXPECT_FALSE(MarkerDeformation::create(bare, marked().at_m));
}

}  // namespace
}  // namespace mien::face::marker_deformation_test
