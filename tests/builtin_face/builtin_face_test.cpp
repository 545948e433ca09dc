#include "mien/builtin_face/builtin_face.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mien/core/random.h"
#include "mien/core/rotation.h"
#include "mien/core/units.h"

namespace mien::builtin_face::builtin_face_test {
namespace {

std::vector<std::array<std::uint32_t, 3>> triangles_of(const face::Face& face, std::string_view part_name) {
  for (const face::Part& part : face.parts)
    if (part.name == part_name)
      return {face.triangles.begin() + part.first_triangle,
              face.triangles.begin() + part.first_triangle + part.triangle_count};
  return {};
}

const face::Face& default_face() {
  static const face::Face face = make_builtin();
  return face;
}

std::vector<Vec3f> moved(const face::Face& face, const face::BlendshapeWeights& weights,
                         float tongue_out = 0) {
  std::vector<Vec3f> vertices(face.neutral_m.size());
  face::evaluate(face, weights, tongue_out, vertices);
  return vertices;
}

face::BlendshapeWeights only(std::initializer_list<std::pair<std::string_view, float>> values) {
  face::BlendshapeWeights weights;
  for (const auto& [name, value] : values) {
    EXPECT_LT(face::shape_index(name), face::kShapeCount) << name;
    weights[face::shape_index(name)] = value;
  }
  return weights;
}

/// Points spread evenly over the skin within 5 mm of a site, at neutral and moved: each small triangle's
/// centre counts as often as it is large.
struct Patch {
  std::vector<Vec3> from, to;
  double nearest_m = std::numeric_limits<double>::infinity();

  Patch(const face::Face& face, const Vec3& site_m, std::span<const Vec3f> moved_m) {
    constexpr double kSpacing = 0.0005;
    for (const auto& t : triangles_of(face, "skin")) {
      const Vec3 a = face.neutral_m[t[0]].cast<double>(), b = face.neutral_m[t[1]].cast<double>(),
                 c = face.neutral_m[t[2]].cast<double>();
      if ((a - site_m).norm() > 0.025) continue;
      const int n =
          std::max(1, static_cast<int>(std::ceil(std::sqrt((b - a).cross(c - a).norm()) / kSpacing)));
      for (int i = 0; i < n; ++i) {
        for (int j = 0; i + j < n; ++j) {
          const double u = (i + 1.0 / 3) / n, v = (j + 1.0 / 3) / n;
          const Vec3 p = (1 - u - v) * a + u * b + v * c;
          nearest_m = std::min(nearest_m, (p - site_m).norm());
          if ((p - site_m).norm() > 0.005) continue;
          from.push_back(p);
          to.push_back((1 - u - v) * moved_m[t[0]].cast<double>() + u * moved_m[t[1]].cast<double>() +
                       v * moved_m[t[2]].cast<double>());
        }
      }
    }
  }
  [[nodiscard]] Vec3 turn_deg() const { return log_rotation(fit_rotation(from, to)) / kRadPerDeg; }
  [[nodiscard]] double shift_mm() const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < from.size(); ++i) sum += to[i] - from[i];
    return sum.norm() / static_cast<double>(from.size()) * 1000;
  }
  /// How much longer skin becomes along the direction in which it grows most: 1 is not at all.
  [[nodiscard]] double largest_stretch() const {
    Vec3 mean_from = Vec3::Zero(), mean_to = Vec3::Zero();
    for (std::size_t i = 0; i < from.size(); ++i) mean_from += from[i], mean_to += to[i];
    mean_from /= static_cast<double>(from.size());
    mean_to /= static_cast<double>(from.size());
    Mat3 spread = Mat3::Zero(), together = Mat3::Zero();
    for (std::size_t i = 0; i < from.size(); ++i) {
      spread += (from[i] - mean_from) * (from[i] - mean_from).transpose();
      together += (to[i] - mean_to) * (from[i] - mean_from).transpose();
    }
    // The patch is flat: its two greater spreads are its plane.
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(spread);
    const auto plane = eigen.eigenvectors().rightCols<2>();
    const Eigen::Matrix<double, 3, 2> gradient =
        together * plane * eigen.eigenvalues().tail<2>().cwiseInverse().asDiagonal();
    return Eigen::JacobiSVD<Eigen::Matrix<double, 3, 2>>(gradient).singularValues()[0];
  }
};

Vec3 site(std::string_view name) {
  for (const BuiltinSite& s : builtin_sites())
    if (s.name == name) return s.position_m;
  ADD_FAILURE() << "no site " << name;
  return Vec3::Zero();
}

/// The ICT model's figures: peak displacement over the mesh at weight 1, and turn of the skin at the default
/// rig's best site.
struct Kinematics {
  std::string_view shape;  ///< Left or middle.
  double peak_mm;
  std::string_view site;  ///< Empty where no site feels it.
  double turn_deg;
};
constexpr Kinematics kKinematics[] = {
    {"browDown_L", 6.5, "frontalis_L", 9.2},
    {"browInnerUp_L", 6.1, "frontalis_L", 5.0},
    {"browOuterUp_L", 8.6, "frontalis_L", 6.7},
    {"cheekPuff_L", 14.1, "zygomaticus_lower_L", 12.7},
    {"cheekSquint_L", 6.3, "zygomaticus_lower_L", 11.0},
    {"eyeBlink_L", 17.8, "orbicularis_L", 2.6},
    {"eyeLookDown_L", 7.7, "orbicularis_L", 3.8},
    {"eyeLookIn_L", 2.5, "orbicularis_L", 3.3},
    {"eyeLookOut_L", 2.5, "orbicularis_L", 4.5},
    {"eyeLookUp_L", 3.7, "orbicularis_L", 2.0},
    {"eyeSquint_L", 3.7, "orbicularis_L", 3.7},
    {"eyeWide_L", 3.6, "orbicularis_L", 0.7},
    {"jawForward", 11.2, "buccinator_L", 11.4},
    {"jawLeft", 8.9, "buccinator_L", 9.2},
    {"jawOpen", 42.0, "zygomaticus_lower_L", 17.6},
    {"mouthClose", 41.8, "buccinator_L", 22.6},
    {"mouthDimple_L", 8.9, "buccinator_L", 30.6},
    {"mouthFrown_L", 6.1, "buccinator_L", 12.1},
    {"mouthFunnel", 11.7, "zygomaticus_lower_L", 7.0},
    {"mouthLeft", 18.8, "zygomaticus_lower_L", 25.4},
    {"mouthLowerDown_L", 4.6, "mentalis", 3.5},
    {"mouthPress_L", 4.3, "buccinator_L", 4.7},
    {"mouthPucker", 12.4, "zygomaticus_lower_L", 9.3},
    {"mouthRollLower", 14.2, "buccinator_L", 3.0},
    {"mouthRollUpper", 11.6, "zygomaticus_lower_L", 8.1},
    {"mouthShrugLower", 11.3, "mentalis", 12.2},
    {"mouthShrugUpper", 6.2, "", 0.1},
    {"mouthSmile_L", 15.8, "zygomaticus_lower_L", 33.7},
    {"mouthStretch_L", 10.3, "buccinator_L", 18.1},
    {"mouthUpperUp_L", 8.8, "zygomaticus_lower_L", 30.0},
    {"noseSneer_L", 10.3, "zygomaticus_lower_L", 15.3},
};

TEST(BuiltinFace, EveryShapePeaksAsFarAsRealOnes) {
  for (const Kinematics& k : kKinematics) {
    const double peak_mm = face::peak_displacement_m(default_face(), k.shape) * 1000.0;
    EXPECT_NEAR(peak_mm, k.peak_mm, 0.25 * k.peak_mm) << k.shape;
  }
}

TEST(BuiltinFace, SkinTurnsAtTheBestSiteAsRealSkinDoes) {
  for (const Kinematics& k : kKinematics) {
    const auto at_one = moved(default_face(), only({{k.shape, 1.0F}}));
    if (k.site.empty()) {
      for (const BuiltinSite& s : builtin_sites())
        EXPECT_LT(Patch(default_face(), s.position_m, at_one).turn_deg().norm(), 1.5)
            << k.shape << " at " << s.name;
      continue;
    }
    const double turn_deg = Patch(default_face(), site(k.site), at_one).turn_deg().norm();
    EXPECT_NEAR(turn_deg, k.turn_deg, std::max(1.5, 0.25 * k.turn_deg)) << k.shape << " at " << k.site;
  }
}

/// Away from the best site, as measured on the ICT model (degrees about x, y and z at weight 1).
TEST(BuiltinFace, SkinAroundGoesAlongAsRealSkinDoes) {
  struct Turn {
    std::string_view shape, site;
    Vec3 deg;
  };
  const Turn turns[] = {
      {"jawOpen", "buccinator_L", {15.5, -1.5, 2.5}},
      {"jawOpen", "buccinator_R", {15.5, 1.5, -2.5}},
      {"mouthSmile_L", "orbicularis_L", {-8, 0.5, 7.5}},
      {"mouthSmile_R", "orbicularis_R", {-8, -0.5, -7.5}},
      {"mouthSmile_L", "orbicularis_R", {0, 0, 0}},
      {"mouthLeft", "mentalis", {-9, 8, -5.5}},
      {"mouthRight", "mentalis", {-9, -8, 5.5}},
      {"eyeBlink_L", "orbicularis_L", {1, 1.5, -1}},
      {"eyeLookDown_L", "orbicularis_L", {-1, -2.5, 2.5}},
      {"browDown_L", "zygomaticus_upper_L", {0, 0, 0}},
  };
  for (const Turn& t : turns) {
    const auto at_one = moved(default_face(), only({{t.shape, 1.0F}}));
    EXPECT_LT((Patch(default_face(), site(t.site), at_one).turn_deg() - t.deg).norm(), 1.0)
        << t.shape << " at " << t.site;
  }
}

/// A turn says little of how the next one adds to it: that is the stretch's doing.
TEST(BuiltinFace, SkinIsStretchedNoMoreThanRealSkinIs) {
  // Largest stretch of the patch at weight 1; ICT's are 1.28, 1.43 and 1.18.
  for (const auto& [shape, at, stretch] :
       {std::tuple{"jawOpen", "zygomaticus_lower_L", 1.28}, std::tuple{"mouthClose", "mentalis", 1.43},
        std::tuple{"mouthPucker", "zygomaticus_lower_L", 1.18}}) {
    const auto at_one = moved(default_face(), only({{shape, 1.0F}}));
    EXPECT_NEAR(Patch(default_face(), site(at), at_one).largest_stretch(), stretch, 0.08) << shape;
  }
}

double distance_mm(std::span<const Vec3f> vertices, const face::Face& face, std::size_t landmark_a,
                   std::size_t landmark_b) {
  return (vertices[face.landmarks[landmark_a]] - vertices[face.landmarks[landmark_b]]).norm() * 1000.0;
}

std::set<std::uint32_t> vertices_of(const face::Face& face, std::string_view part_name) {
  std::set<std::uint32_t> vertices;
  for (const auto& t : triangles_of(face, part_name)) vertices.insert(t.begin(), t.end());
  return vertices;
}

/// The least distance (mm) of the outer skin to the eyeballs' surface; negative inside one.
double clearance_mm(const face::Face& face, std::span<const Vec3f> vertices) {
  double least = std::numeric_limits<double>::infinity();
  for (const face::Eyeball& eye : face.eyes) {
    // The back of the ball gives its radius: no cornea there.
    const float radius = (face.neutral_m[eye.first_vertex + eye.vertex_count - 1] - eye.centre_m).norm();
    for (const std::uint32_t i : vertices_of(face, "skin"))
      least = std::min(least, static_cast<double>((vertices[i] - eye.centre_m).norm() - radius) * 1000);
  }
  return least;
}

std::vector<face::Face> people(int count) {
  std::vector<face::Face> faces;
  Random random(20);
  for (int i = 0; i < count; ++i) faces.push_back(make_builtin(without_hair(random_identity(random))));
  return faces;
}

TEST(BuiltinFace, IsACompleteFace) {
  const face::Face& face = default_face();
  const std::size_t n = face.neutral_m.size();
  EXPECT_EQ(face.name, "builtin");
  EXPECT_GE(n, 6000U);
  EXPECT_LE(n, 20000U);
  ASSERT_EQ(face.colour.size(), n);
  for (std::size_t i = 0; i < n; ++i) {
    EXPECT_TRUE(face.neutral_m[i].allFinite()) << i;
    EXPECT_TRUE((face.colour[i].array() >= 0).all() && (face.colour[i].array() <= 1).all()) << i;
  }
  for (const auto& t : face.triangles)
    for (const std::uint32_t v : t) ASSERT_LT(v, n);
  std::uint32_t next = 0;
  for (const face::Part& part : face.parts) {
    EXPECT_EQ(part.first_triangle, next) << part.name;
    EXPECT_GT(part.triangle_count, 0U) << part.name;
    next += part.triangle_count;
  }
  EXPECT_EQ(next, face.triangles.size());
  ASSERT_EQ(face.shapes.size(), face::kShapeCount + 1);
  for (std::size_t k = 0; k < face.shapes.size(); ++k) {
    const face::Shape& shape = face.shapes[k];
    EXPECT_EQ(shape.name, k < face::kShapeCount ? face::kShapeNames[k] : "tongueOut");
    ASSERT_EQ(shape.vertex.size(), shape.delta_m.size());
    EXPECT_FALSE(shape.vertex.empty()) << shape.name;
    EXPECT_TRUE(std::ranges::is_sorted(shape.vertex, std::less_equal<>{}) || shape.vertex.size() < 2)
        << shape.name;
    EXPECT_EQ(std::ranges::adjacent_find(shape.vertex), shape.vertex.end()) << shape.name;
    EXPECT_LT(shape.vertex.back(), n);
    for (const Vec3f& d : shape.delta_m) EXPECT_TRUE(d.allFinite()) << shape.name;
  }
  for (const char* name : {"skin", "lips", "jaw", "nose", "forehead", "brow_L", "brow_R", "lid_L", "lid_R",
                           "cheek_L", "cheek_R", "eye_L", "eye_R"}) {
    const face::Region* region = face.region(name);
    ASSERT_NE(region, nullptr) << name;
    EXPECT_GT(region->vertex.size(), 20U) << name;
    EXPECT_TRUE(std::ranges::is_sorted(region->vertex)) << name;
  }
}

TEST(BuiltinFace, HasTheSizeAndTheAxesOfAHead) {
  const face::Face& face = default_face();
  Vec3f low = face.neutral_m[0], high = low;
  for (const char* name : {"skin", "ears"})
    for (const std::uint32_t i : vertices_of(face, name)) {
      low = low.cwiseMin(face.neutral_m[i]);
      high = high.cwiseMax(face.neutral_m[i]);
    }
  EXPECT_NEAR(high.x(), 0.09, 0.012);
  EXPECT_NEAR(low.x(), -high.x(), 1e-6);
  EXPECT_NEAR(high.y(), 0.145, 0.015);
  EXPECT_NEAR(low.y(), -0.19, 0.01);
  EXPECT_NEAR(high.z(), 0.13, 0.003);
  EXPECT_TRUE(face.eyes[0].centre_m.isApprox(Vec3f(0.032F, 0.036F, 0.0845F), 0.02F));
  EXPECT_TRUE(face.eyes[1].centre_m.isApprox(Vec3f(-0.032F, 0.036F, 0.0845F), 0.02F));
  // The right jaw first, the chin in the middle, the nose's tip foremost; lips between nose and chin.
  const auto at = [&](std::size_t i) { return face.neutral_m[face.landmarks[i]]; };
  EXPECT_LT(at(0).x(), -0.05);
  EXPECT_GT(at(16).x(), 0.05);
  for (const std::size_t i : {8, 27, 28, 29, 30, 33, 51, 57, 62, 66}) EXPECT_NEAR(at(i).x(), 0, 1e-6) << i;
  for (std::size_t i = 1; i < 15; ++i) EXPECT_LT(at(i).x(), at(i + 1).x()) << i;
  EXPECT_NEAR(at(30).z(), high.z(), 0.002);
  EXPECT_GT(at(33).y(), at(51).y());
  EXPECT_GT(at(51).y(), at(62).y());
  EXPECT_GE(at(62).y(), at(66).y());
  EXPECT_GT(at(66).y(), at(57).y());
  EXPECT_GT(at(57).y(), at(8).y());
  EXPECT_EQ(std::set(face.landmarks.begin(), face.landmarks.end()).size(), 68U);
}

TEST(BuiltinFace, SkinIsOneSurfaceOpenOnlyAtNeckAndBehindTheLids) {
  const face::Face& face = default_face();
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const std::string_view part : {"skin", "lips", "mouth", "lids"})
    for (const auto& t : triangles_of(face, part))
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_TRUE(edges.emplace(t[k], t[(k + 1) % 3]).second)
            << "an edge with two triangles on one side, in " << part;
  const std::set<std::uint32_t> lids = vertices_of(face, "lids");
  for (const auto& [a, b] : edges)
    if (!edges.contains({b, a})) {
      EXPECT_TRUE(face.neutral_m[a].y() < -0.17F || lids.contains(a))
          << "a hole at " << face.neutral_m[a].transpose();
    }
}

TEST(BuiltinFace, RestsWithLipsClosedAndEyesOpen) {
  const face::Face& face = default_face();
  for (const auto& [up, low] : {std::pair{61, 67}, {62, 66}, {63, 65}})
    EXPECT_LT(distance_mm(face.neutral_m, face, up, low), 0.7);
  for (const auto& [up, low] : {std::pair{37, 41}, {38, 40}, {43, 47}, {44, 46}})
    EXPECT_GT(distance_mm(face.neutral_m, face, up, low), 7);
}

TEST(BuiltinFace, LidsMeetWhenTheyCloseAndOnlyOnTheirSide) {
  const face::Face& face = default_face();
  const auto left = moved(face, only({{"eyeBlink_L", 1.0F}}));
  EXPECT_LT(distance_mm(left, face, 43, 47), 0.8);
  EXPECT_LT(distance_mm(left, face, 44, 46), 0.8);
  EXPECT_GT(distance_mm(left, face, 37, 41), 7);
  const auto right = moved(face, only({{"eyeBlink_R", 1.0F}}));
  EXPECT_LT(distance_mm(right, face, 37, 41), 0.8);
}

TEST(BuiltinFace, SkinNeverSinksIntoTheEyeballs) {
  const face::Face& face = default_face();
  EXPECT_GT(clearance_mm(face, face.neutral_m), 0.5);
  for (const std::string_view name : face::kShapeNames)
    for (const float w : {0.5F, 1.0F})
      EXPECT_GT(clearance_mm(face, moved(face, only({{name, w}}))), 0.3) << name << " at " << w;
  EXPECT_GT(
      clearance_mm(face,
                   moved(face, only({{"eyeBlink_L", 1.0F}, {"mouthSmile_L", 1.0F}, {"browDown_L", 1.0F}}))),
      0.3);
}

TEST(BuiltinFace, MouthCloseSealsTheLipsOfADroppedJaw) {
  const face::Face& face = default_face();
  const auto open = moved(face, only({{"jawOpen", 1.0F}}));
  EXPECT_GT(distance_mm(open, face, 62, 66), 25);
  for (const float w : {0.3F, 0.6F, 1.0F}) {
    const auto sealed = moved(face, only({{"jawOpen", w}, {"mouthClose", w}}));
    EXPECT_LT(distance_mm(sealed, face, 62, 66), 0.8);
    EXPECT_LT(distance_mm(sealed, face, 61, 67), 0.8);
    const Vec3f chin = sealed[face.landmarks[8]] - face.neutral_m[face.landmarks[8]];
    EXPECT_LT(chin.y(), -0.02F * w) << "the jaw stays down";
  }
}

TEST(BuiltinFace, LowerTeethGoWithTheJawAndUpperOnesStay) {
  const face::Face& face = default_face();
  const auto open = moved(face, only({{"jawOpen", 1.0F}}));
  for (const std::uint32_t i : vertices_of(face, "teeth_upper")) EXPECT_EQ(open[i], face.neutral_m[i]);
  double front_teeth = 0;
  for (const std::uint32_t i : vertices_of(face, "teeth_lower"))
    front_teeth = std::max(front_teeth, static_cast<double>(face.neutral_m[i].y() - open[i].y()) * 1000);
  EXPECT_GT(front_teeth, 25);
  const auto tongue = moved(face, {}, 1);
  float tip = 0, lips = 0;
  for (const std::uint32_t i : vertices_of(face, "tongue")) tip = std::max(tip, tongue[i].z());
  for (const std::uint32_t i : vertices_of(face, "lips")) lips = std::max(lips, tongue[i].z());
  EXPECT_GT(tip, lips + 0.003F) << "the tongue is out";
}

TEST(BuiltinFace, RightShapesAreMirrorImagesOfLeftOnes) {
  const face::Face& face = default_face();
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    if (!face::kShapeNames[k].ends_with("_L")) continue;
    const auto left = moved(face, only({{face::kShapeNames[k], 1.0F}}));
    const auto right = moved(face, only({{face::kShapeNames[k + 1], 1.0F}}));
    // The landmarks mirror each other in pairs: brows, eyes and mouth corners say enough.
    for (const auto& [r, l] :
         {std::pair{17, 26}, {21, 22}, {37, 44}, {38, 43}, {40, 47}, {48, 54}, {50, 52}, {58, 56}, {5, 11}}) {
      Vec3f a = left[face.landmarks[static_cast<std::size_t>(l)]];
      a.x() = -a.x();
      EXPECT_LT((a - right[face.landmarks[static_cast<std::size_t>(r)]]).norm(), 1e-6F)
          << face::kShapeNames[k];
    }
  }
}

TEST(BuiltinFace, ShapesOfTheMiddleAreSymmetric) {
  const face::Face& face = default_face();
  for (const std::string_view name :
       {"jawForward", "jawOpen", "mouthClose", "mouthFunnel", "mouthPucker", "mouthRollLower",
        "mouthRollUpper", "mouthShrugLower", "mouthShrugUpper"}) {
    const auto vertices = moved(face, only({{name, 1.0F}}));
    for (const auto& [r, l] : {std::pair{31, 35}, {48, 54}, {50, 52}, {58, 56}, {60, 64}, {5, 11}, {7, 9}}) {
      Vec3f left = vertices[face.landmarks[static_cast<std::size_t>(l)]];
      left.x() = -left.x();
      EXPECT_LT((left - vertices[face.landmarks[static_cast<std::size_t>(r)]]).norm(), 1e-5F) << name;
    }
  }
}

TEST(BuiltinFace, ShapesDoWhatTheirNamesSay) {
  const face::Face& face = default_face();
  const auto goes = [&](std::string_view shape, std::size_t landmark) {
    const auto vertices = moved(face, only({{shape, 1.0F}}));
    return Vec3f((vertices[face.landmarks[landmark]] - face.neutral_m[face.landmarks[landmark]]) * 1000);
  };
  EXPECT_LT(goes("browDown_L", 23).y(), -3);
  EXPECT_GT(goes("browInnerUp_L", 22).y(), 3);
  EXPECT_GT(goes("browOuterUp_L", 25).y(), 3);
  EXPECT_GT(goes("mouthSmile_L", 54).y(), 4);
  EXPECT_GT(goes("mouthSmile_L", 54).x(), 4);
  EXPECT_LT(goes("mouthSmile_L", 48).norm(), 1);
  EXPECT_LT(goes("mouthFrown_L", 54).y(), -3);
  EXPECT_GT(goes("mouthStretch_L", 54).x(), 5);
  EXPECT_GT(goes("mouthLeft", 62).x(), 10);
  EXPECT_LT(goes("mouthRight", 62).x(), -10);
  EXPECT_GT(goes("jawLeft", 8).x(), 5);
  EXPECT_LT(goes("jawRight", 8).x(), -5);
  EXPECT_GT(goes("jawForward", 8).z(), 8);
  EXPECT_LT(goes("jawOpen", 8).y(), -20);
  EXPECT_LT(goes("mouthPucker", 54).x(), -6);
  EXPECT_GT(goes("mouthPucker", 51).z(), 5);
  EXPECT_GT(goes("mouthFunnel", 51).z(), 5);
  EXPECT_LT(goes("mouthRollLower", 57).z(), -1);
  EXPECT_LT(goes("mouthRollUpper", 51).z(), -1);
  EXPECT_GT(goes("mouthUpperUp_L", 52).y(), 4);
  EXPECT_LT(goes("mouthLowerDown_L", 56).y(), -2);
  EXPECT_GT(goes("mouthShrugUpper", 51).y(), 3);
  EXPECT_GT(goes("mouthShrugLower", 57).y(), 3);
  EXPECT_GT(goes("noseSneer_L", 35).y(), 3);
  EXPECT_LT(goes("eyeLookDown_L", 43).y(), -3);
  EXPECT_GT(goes("eyeLookUp_L", 43).y(), 1);
  EXPECT_GT(goes("eyeWide_L", 43).y(), 1);
  EXPECT_GT(goes("eyeSquint_L", 47).y(), 0.8);
}

TEST(BuiltinFace, SitesLieOnItsSkin) {
  for (const BuiltinSite& s : builtin_sites()) {
    const Patch patch(default_face(), s.position_m, default_face().neutral_m);
    EXPECT_LT(patch.nearest_m, 0.0006) << s.name;
    EXPECT_GT(patch.from.size(), 100U) << s.name;
  }
}

TEST(BuiltinFace, SameParametersGiveTheSameBits) {
  Random random(5);
  const BuiltinParameters parameters = random_identity(random);
  const face::Face a = make_builtin(parameters), b = make_builtin(parameters);
  EXPECT_EQ(a.neutral_m, b.neutral_m);
  for (std::size_t k = 0; k < a.shapes.size(); ++k) EXPECT_EQ(a.shapes[k].delta_m, b.shapes[k].delta_m);
  BuiltinParameters other = parameters;
  other.asymmetry_seed += 2;
  EXPECT_NE(make_builtin(other).neutral_m, a.neutral_m);
}

TEST(BuiltinFace, EachIdentityNumberDoesWhatItsNameSays) {
  struct Case {
    const char* what;
    double BuiltinParameters::*number;
    std::size_t a, b;  ///< Landmarks whose distance grows.
  };
  const Case cases[] = {{"head_width", &BuiltinParameters::head_width, 0, 16},
                        {"face_length", &BuiltinParameters::face_length, 27, 8},
                        {"jaw_width", &BuiltinParameters::jaw_width, 4, 12},
                        {"chin_size", &BuiltinParameters::chin_size, 27, 8},
                        {"nose_length", &BuiltinParameters::nose_length, 27, 30},
                        {"nose_width", &BuiltinParameters::nose_width, 31, 35},
                        {"eye_spacing", &BuiltinParameters::eye_spacing, 39, 42},
                        {"eye_size", &BuiltinParameters::eye_size, 42, 45},
                        {"mouth_width", &BuiltinParameters::mouth_width, 48, 54},
                        {"lip_fullness", &BuiltinParameters::lip_fullness, 51, 57},
                        {"brow_height", &BuiltinParameters::brow_height, 24, 44},
                        {"jaw_angle", &BuiltinParameters::jaw_angle, 3, 13},
                        {"face_fullness", &BuiltinParameters::face_fullness, 4, 12},
                        {"chin_width", &BuiltinParameters::chin_width, 7, 9},
                        {"nose_tip", &BuiltinParameters::nose_tip, 30, 8},
                        {"alar_width", &BuiltinParameters::alar_width, 31, 35},
                        {"philtrum_length", &BuiltinParameters::philtrum_length, 33, 51},
                        {"eye_slant", &BuiltinParameters::eye_slant, 45, 54},
                        {"lid_opening", &BuiltinParameters::lid_opening, 44, 46}};
  const face::Face& plain = default_face();
  for (const Case& c : cases) {
    BuiltinParameters parameters;
    parameters.*c.number = 2;
    const face::Face more = make_builtin(parameters);
    parameters.*c.number = -2;
    const face::Face less = make_builtin(parameters);
    const double middle = distance_mm(plain.neutral_m, plain, c.a, c.b);
    EXPECT_GT(distance_mm(more.neutral_m, more, c.a, c.b), middle + 0.4) << c.what;
    EXPECT_LT(distance_mm(less.neutral_m, less, c.a, c.b), middle - 0.4) << c.what;
    parameters.*c.number = 50;
    const face::Face far = make_builtin(parameters);
    parameters.*c.number = 3;
    EXPECT_EQ(far.neutral_m, make_builtin(parameters).neutral_m) << c.what << " is held to 3";
  }
}

TEST(BuiltinFace, CheeksFillAsTheirNumbersSay) {
  const auto nearest_vertex = [](const Vec3& p) {
    const auto& vertices = default_face().neutral_m;
    std::size_t best = 0;
    for (std::size_t i = 0; i < vertices.size(); ++i)
      if ((vertices[i].cast<double>() - p).norm() < (vertices[best].cast<double>() - p).norm()) best = i;
    return best;
  };
  const std::size_t bone = nearest_vertex(site("zygomaticus_upper_L")),
                    cheek = nearest_vertex(site("buccinator_L"));
  BuiltinParameters bony, full;
  bony.cheekbones = full.cheek_fullness = 2;
  EXPECT_GT(make_builtin(bony).neutral_m[bone].x(), default_face().neutral_m[bone].x() + 0.0008F);
  EXPECT_GT(make_builtin(full).neutral_m[cheek].x(), default_face().neutral_m[cheek].x() + 0.0015F);
}

TEST(BuiltinFace, EveryoneHasRoundEyesClosingLidsAndClosedLips) {
  for (const face::Face& face : people(12)) {
    for (std::size_t e = 0; e < 2; ++e) {
      const face::Eyeball &eye = face.eyes[e], &plain = default_face().eyes[e];
      ASSERT_EQ(eye.vertex_count, plain.vertex_count);
      const auto radius = [](const face::Face& f, const face::Eyeball& ball, std::uint32_t i) {
        return (f.neutral_m[ball.first_vertex + i] - ball.centre_m).norm();
      };
      const float scale = radius(face, eye, 0) / radius(default_face(), plain, 0);
      for (std::uint32_t i = 0; i < eye.vertex_count; ++i)
        EXPECT_NEAR(radius(face, eye, i), scale * radius(default_face(), plain, i), 2e-6);
    }
    EXPECT_GT(clearance_mm(face, face.neutral_m), 0.4);
    const auto shut = moved(face, only({{"eyeBlink_L", 1.0F}, {"eyeBlink_R", 1.0F}}));
    EXPECT_GT(clearance_mm(face, shut), 0.3);
    for (const auto& [up, low] : {std::pair{37, 41}, {38, 40}, {43, 47}, {44, 46}})
      EXPECT_LT(distance_mm(shut, face, up, low), 0.9);
    EXPECT_LT(distance_mm(face.neutral_m, face, 62, 66), 0.5);
  }
}

TEST(BuiltinFace, PeopleDifferAndAreNotQuiteSymmetric) {
  const std::vector<face::Face> faces = people(6);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const auto& [a, b] =
        std::pair{faces[i].neutral_m[faces[i].landmarks[48]], faces[i].neutral_m[faces[i].landmarks[54]]};
    EXPECT_GT((a - Vec3f(-b.x(), b.y(), b.z())).norm(), 1e-4F);
    for (std::size_t j = 0; j < i; ++j) {
      double mean_mm = 0;
      for (std::size_t v = 0; v < faces[i].neutral_m.size(); ++v)
        mean_mm += (faces[i].neutral_m[v] - faces[j].neutral_m[v]).norm() * 1000.0 /
                   static_cast<double>(faces[i].neutral_m.size());
      EXPECT_GT(mean_mm, 1.0);
    }
  }
}

}  // namespace
}  // namespace mien::builtin_face::builtin_face_test
