// Pictures of the built-in face's paint, and what an asset with them is.
#include "mien/render/face_textures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "mien/builtin_face/builtin_face.h"
#include "mien/builtin_face/person.h"
#include "mien/builtin_face/skin_marks.h"
#include "mien/core/bytes.h"
#include "mien/face/gltf_import.h"
#include "mien/render/gltf_export.h"
#include "mien/render/skin_detail.h"
#include "mien/render/tone.h"
#include "tests/render/ball_face.h"

namespace mien::render::face_textures_test {
namespace {

using Eigen::Vector2f;
using face::Material;

/// Of one identity, laid out, with its marks.
struct Person {
  explicit Person(const std::string& name) {
    const auto parameters = builtin_face::find_person(name)->parameters;
    face = builtin_face::make_builtin(parameters);
    builtin_face::lay_out_textures(face);
    marks = builtin_face::skin_marks(parameters, face);
  }
  [[nodiscard]] FaceTextures bake(int side_px) const {
    return bake_textures(face, SurfacePaint(face, marks), side_px).value();
  }
  face::Face face;
  face::SkinMarks marks;
};

const Person& fair() {
  static const Person person("builtin:ada,hair=none");
  return person;
}

Material material_of(const face::Face& face, std::size_t triangle) {
  for (const face::Part& part : face.parts)
    if (triangle >= part.first_triangle && triangle < std::size_t{part.first_triangle} + part.triangle_count)
      return part.material;
  return Material::other;
}

float twice_area(const std::array<Vector2f, 3>& uv) {
  const Vector2f a = uv[1] - uv[0], b = uv[2] - uv[0];
  return a.x() * b.y() - a.y() * b.x();
}

TEST(TextureLayout, ShowsEveryPlaceOnceAndNoneTurnedOver) {
  const face::Face& face = fair().face;
  constexpr int kSide = 1024;
  std::vector<int> shown(kSide * kSide);
  std::size_t turned = 0, beyond = 0, all = 0;
  for (std::size_t t = 0; t < face.triangles.size(); ++t) {
    if (!is_textured(material_of(face, t))) continue;
    ++all;
    const auto uv = uv_of(face, face.triangles[t]);
    for (const Vector2f& corner : uv) beyond += corner.minCoeff() < 0 || corner.maxCoeff() > 1 ? 1 : 0;
    const float area = twice_area(uv);
    if (!(area < 0)) {
      // The caps behind the eyeballs, which nobody sees.
      EXPECT_EQ(material_of(face, t), Material::sclera) << t;
      ++turned;
      continue;
    }
    const Vector2f low = uv[0].cwiseMin(uv[1]).cwiseMin(uv[2]) * kSide,
                   high = uv[0].cwiseMax(uv[1]).cwiseMax(uv[2]) * kSide;
    for (int y = static_cast<int>(low.y()); y <= std::min(kSide - 1, static_cast<int>(high.y())); ++y)
      for (int x = static_cast<int>(low.x()); x <= std::min(kSide - 1, static_cast<int>(high.x())); ++x) {
        const Vector2f p = Vector2f(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F) / kSide;
        float least = 1;
        for (std::size_t k = 0; k < 3; ++k)
          least = std::min(least, twice_area({uv[(k + 1) % 3], uv[(k + 2) % 3], p}) / area);
        if (least > 1e-3F) ++shown[static_cast<std::size_t>(y * kSide + x)];
      }
  }
  EXPECT_EQ(beyond, 0U);
  EXPECT_GT(all, 10000U);
  EXPECT_LT(turned, all / 100);
  EXPECT_EQ(std::ranges::count_if(shown, [](int n) { return n > 1; }), 0) << "two places share a texel";
  EXPECT_GT(std::ranges::count(shown, 1), kSide * kSide * 8 / 10) << "most of the picture is used";
}

TEST(TextureLayout, GivesTheFaceMoreRoomThanTheBackOfTheHead) {
  const face::Face& face = fair().face;
  double front_px = 0, front_m2 = 0, back_px = 0, back_m2 = 0;
  for (std::size_t t = 0; t < face.triangles.size(); ++t) {
    if (material_of(face, t) != Material::skin) continue;
    const auto& [a, b, c] = face.triangles[t];
    const Vec3f& p = face.neutral_m[a];
    const bool front = std::abs(p.x()) < 0.045F && p.z() > 0.05F && p.y() > -0.06F && p.y() < 0.06F;
    if (!front && p.z() > -0.03F) continue;
    const double m2 = 0.5 * (face.neutral_m[b] - p).cross(face.neutral_m[c] - p).norm();
    const double px = 0.5 * std::abs(twice_area(uv_of(face, face.triangles[t])));
    (front ? front_px : back_px) += px;
    (front ? front_m2 : back_m2) += m2;
  }
  EXPECT_GT(front_px / front_m2, 1.5 * back_px / back_m2);
}

TEST(FaceTextures, AreThePaintAtThePlaceOfTheSkinThatTheyShow) {
  const face::Face& face = fair().face;
  const SurfacePaint paint(face, fair().marks);
  constexpr int kSide = 512;
  const FaceTextures baked = fair().bake(kSide);
  // The texel about the middle of the lips' larger triangles, which are without fine patterns.
  std::size_t compared = 0;
  for (std::size_t t = 0; t < face.triangles.size(); ++t) {
    const Material material = material_of(face, t);
    if (material != Material::lips) continue;
    const auto uv = uv_of(face, face.triangles[t]);
    if (!(twice_area(uv) * kSide * kSide < -3)) continue;
    const Vector2f middle = (uv[0] + uv[1] + uv[2]) / 3 * kSide;
    const auto x = static_cast<std::size_t>(middle.x()), y = static_cast<std::size_t>(middle.y());
    const auto mean = [&](const std::vector<Vec3f>& of) {
      return Vec3f((of[face.triangles[t][0]] + of[face.triangles[t][1]] + of[face.triangles[t][2]]) / 3);
    };
    const Vec3f own = mean(face.colour);
    const Surface s = paint.at(mean(face.neutral_m), material, &own, {.footprint_m = 0.8e-3F});
    const Rgb wanted = to_srgb(s.albedo);
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(baked.albedo[3 * (y * kSide + x) + c], wanted[c], 10) << t;
    EXPECT_NEAR(baked.roughness[3 * (y * kSide + x) + 1], 255 * s.roughness, 8);
    EXPECT_EQ(baked.roughness[3 * (y * kSide + x) + 2], 0) << "no metal";
    ++compared;
  }
  EXPECT_GT(compared, 20U);
}

TEST(FaceTextures, PoresTiltTheNormalOnSkinAndNotOnEyes) {
  constexpr int kSide = 1024;
  const FaceTextures baked = fair().bake(kSide);
  const face::Face& face = fair().face;
  double skin = 0, eye = 0;
  std::size_t skins = 0, eyes = 0;
  for (std::size_t t = 0; t < face.triangles.size(); ++t) {
    const Material material = material_of(face, t);
    if (!is_textured(material)) continue;
    const auto uv = uv_of(face, face.triangles[t]);
    if (!(twice_area(uv) < 0)) continue;
    const Vector2f middle = (uv[0] + uv[1] + uv[2]) / 3 * kSide;
    const std::size_t i = static_cast<std::size_t>(middle.y()) * kSide + static_cast<std::size_t>(middle.x());
    const double tilt = std::hypot(baked.normal[3 * i] - 127.5, baked.normal[3 * i + 1] - 127.5);
    if (material == Material::skin && face.neutral_m[face.triangles[t][0]].z() > 0.06F) skin += tilt, ++skins;
    if (material == Material::iris) eye += tilt, ++eyes;
  }
  EXPECT_GT(skin / static_cast<double>(skins), 2.0);
  EXPECT_LT(eye / static_cast<double>(eyes), 1.0);
}

TEST(FaceTextures, AStubbledChinIsDarkerThanAShavenOneAndAForeheadIsNot) {
  const Person bearded("builtin:ada,hair=none,beard=1");
  constexpr int kSide = 512;
  face::SkinMarks stubble = bearded.marks;
  stubble.moles.clear();
  for (Vector2f& amount : stubble.amount) amount.x() = 0;
  const auto baked = [&](const face::SkinMarks& marks) {
    return bake_textures(bearded.face, SurfacePaint(bearded.face, marks), kSide).value().albedo;
  };
  const auto with = baked(stubble), without = baked({});
  double chin = 0;
  std::size_t roots = 0;
  for (std::size_t t = 0; t < bearded.face.triangles.size(); ++t) {
    if (material_of(bearded.face, t) != Material::skin) continue;
    const std::uint32_t i = bearded.face.triangles[t][0];
    const Vector2f at = bearded.face.uv[i] * (kSide - 1);
    const std::size_t texel =
        3 * (static_cast<std::size_t>(at.y()) * kSide + static_cast<std::size_t>(at.x()));
    const int darker = without[texel + 1] - with[texel + 1];
    if (stubble.amount[i].y() > 0.9F) {
      chin += darker;
      ++roots;
    }
    const bool forehead = bearded.face.neutral_m[i].y() > 0.04F && bearded.face.neutral_m[i].z() > 0.05F;
    EXPECT_TRUE(!forehead || darker == 0) << darker;
  }
  EXPECT_GT(chin / static_cast<double>(roots), 0.5);
}

TEST(FaceTextures, RefusesALayoutThatLiesOnItselfOrLeavesThePicture) {
  face::Face face = ball_face();
  const SurfacePaint paint(face);
  face.uv.assign(face.neutral_m.size(), Vector2f::Zero());
  for (std::size_t i = 0; i < face.uv.size(); ++i)
    face.uv[i] = Vector2f(0.5F, 0.5F) + 4 * Vector2f(face.neutral_m[i].x(), -face.neutral_m[i].y());
  EXPECT_EQ(bake_textures(face, paint, 128).error().code, ErrorCode::bad_usage) << "eyes lie on the skin";
  for (Vector2f& uv : face.uv) uv *= 3;
  EXPECT_EQ(bake_textures(face, paint, 128).error().code, ErrorCode::bad_usage) << "it leaves the picture";
  face.uv[3].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(bake_textures(face, paint, 128).error().code, ErrorCode::bad_usage);
}

TEST(FaceTextures, HaveAnySideAndRefuseWhatDoesNotFit) {
  const SurfacePaint paint(fair().face, fair().marks);
  for (const int side : {1, 3, 37}) EXPECT_EQ(fair().bake(side).albedo.size(), 3U * side * side);
  EXPECT_EQ(bake_textures(fair().face, paint, 0).error().code, ErrorCode::out_of_range);
  EXPECT_EQ(bake_textures(fair().face, paint, kLargestTexture + 1).error().code, ErrorCode::out_of_range);
  face::Face face = fair().face;
  face.uv.pop_back();
  EXPECT_EQ(bake_textures(face, paint, 8).error().code, ErrorCode::malformed);
  face::SkinMarks short_of_one = fair().marks;
  short_of_one.amount.pop_back();
  EXPECT_EQ(bake_textures(fair().face, SurfacePaint(fair().face, short_of_one), 8).error().code,
            ErrorCode::malformed);
}

TEST(SkinDetail, DotsCoverAsMuchWhateverAPixelShows) {
  // Mean over a plane that goes through cubes at every height, for pixels from none to several cubes.
  const auto mean = [](auto cover, float footprint_m) {
    double sum = 0;
    constexpr int kSide = 400;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x)
        sum += cover(Vec3f(1.7e-4F * static_cast<float>(x), 1.3e-4F * static_cast<float>(y),
                           0.9e-4F * static_cast<float>(x + y)),
                     footprint_m);
    return sum / (kSide * kSide);
  };
  const auto freckles = [](const Vec3f& p, float at) { return freckle_cover(p, 3, 0.8F, at); };
  const auto stubble = [](const Vec3f& p, float at) { return stubble_cover(p, 3, 0.8F, at); };
  for (const float footprint_m : {0.2e-3F, 0.5e-3F, 1e-3F, 2e-3F, 4e-3F, 8e-3F}) {
    EXPECT_NEAR(mean(freckles, footprint_m), mean(freckles, 0), 0.35 * mean(freckles, 0)) << footprint_m;
    EXPECT_NEAR(mean(stubble, footprint_m), mean(stubble, 0), 0.35 * mean(stubble, 0)) << footprint_m;
  }
}

nlohmann::json tree_of(const std::vector<std::byte>& glb) {
  std::uint32_t size = 0;
  std::memcpy(&size, glb.data() + 12, 4);
  const char* text = reinterpret_cast<const char*>(glb.data()) + 20;
  return nlohmann::json::parse(text, text + size);
}

TEST(TexturedGltf, HasItsPicturesAndSaysNoColourTwice) {
  const auto glb = encode_gltf(fair().face, nullptr, GltfKind::binary, GltfNames::arkit,
                               {.side_px = 64, .beside = false, .marks = fair().marks})
                       .value();
  const nlohmann::json tree = tree_of(glb);
  std::size_t jpegs = 0;
  for (const auto& image : tree["images"]) jpegs += image["mimeType"] == "image/jpeg" ? 1 : 0;
  EXPECT_EQ(jpegs, 3U);
  std::set<std::string> pictured;
  for (const auto& mesh : tree["meshes"])
    for (const auto& primitive : mesh["primitives"]) {
      const auto& material = tree["materials"][primitive["material"].get<std::size_t>()];
      const std::string name = material["name"];
      const auto& attributes = primitive["attributes"];
      const bool has = material["pbrMetallicRoughness"].contains("metallicRoughnessTexture");
      EXPECT_EQ(attributes.contains("COLOR_0"), !has) << name << ": a reader would multiply them";
      EXPECT_EQ(attributes.contains("_COLOR_0"), has) << name;
      if (!has) continue;
      pictured.insert(name);
      EXPECT_TRUE(attributes.contains("TEXCOORD_0")) << name;
      EXPECT_EQ(material.contains("normalTexture"), name == "skin" || name == "lips") << name;
      EXPECT_TRUE(name != "skin" || attributes.contains("TANGENT"));
    }
  EXPECT_EQ(pictured, (std::set<std::string>{"skin", "lips", "sclera", "iris", "pupil"}));
  // What our own importer reads is the face that was written: its shapes and its colours.
  const auto back = face::parse_gltf(glb, "ada.glb").value();
  EXPECT_NEAR(face::peak_displacement_m(back.face, "jawOpen"),
              face::peak_displacement_m(fair().face, "jawOpen"), 1e-6);
  ASSERT_EQ(back.face.colour.size(), back.face.neutral_m.size());
  double most = 0;
  for (std::size_t i = 0; i < back.face.neutral_m.size(); i += 97) {
    double nearest = 1;
    for (std::size_t k = 0; k < fair().face.neutral_m.size(); ++k)
      if ((fair().face.neutral_m[k] - back.face.neutral_m[i]).squaredNorm() < 1e-12F)
        nearest = std::min(nearest, static_cast<double>(
                                        (fair().face.colour[k] - back.face.colour[i]).cwiseAbs().maxCoeff()));
    most = std::max(most, nearest);
  }
  EXPECT_LT(most, 0.5) << "white, where its picture has the colour, would be as pale as 1";
}

TEST(TexturedGltf, NoTriangleGoesTheLongWayRoundBehindTheSeam) {
  const auto glb = encode_gltf(fair().face, nullptr, GltfKind::binary, GltfNames::ict,
                               {.side_px = 0, .beside = true, .marks = {}})
                       .value();
  const nlohmann::json tree = tree_of(glb);
  for (const auto& image : tree.value("images", nlohmann::json::array()))
    EXPECT_EQ(image["mimeType"], "image/png") << "strands; pictures of the skin lie beside it";
  std::uint32_t text = 0;
  std::memcpy(&text, glb.data() + 12, 4);
  const std::byte* buffer = glb.data() + 28 + text;
  std::size_t seen = 0;
  for (const auto& mesh : tree["meshes"])
    for (const auto& primitive : mesh["primitives"]) {
      const auto& material = tree["materials"][primitive["material"].get<std::size_t>()];
      if (material["name"] != "skin") continue;
      EXPECT_EQ(material["extras"]["albedo"], "face_albedo.jpg");
      EXPECT_TRUE(primitive["attributes"].contains("COLOR_0")) << "until the picture is there";
      const auto bytes = [&](const nlohmann::json& accessor) {
        return buffer + tree["bufferViews"][accessor["bufferView"].get<std::size_t>()]["byteOffset"]
                            .get<std::size_t>();
      };
      const auto& corners = tree["accessors"][primitive["indices"].get<std::size_t>()];
      const auto& uvs = tree["accessors"][primitive["attributes"]["TEXCOORD_0"].get<std::size_t>()];
      const std::byte *at = bytes(corners), *uv = bytes(uvs);
      for (std::size_t t = 0; t < corners["count"].get<std::size_t>() / 3; ++t) {
        float low = 2, high = -1;
        for (std::size_t k = 0; k < 3; ++k) {
          std::uint32_t i = 0;
          float u = 0;
          std::memcpy(&i, at + 4 * (3 * t + k), 4);
          std::memcpy(&u, uv + 8 * i, 4);
          low = std::min(low, u);
          high = std::max(high, u);
        }
        EXPECT_LE(high - low, 0.5F) << t;
        ++seen;
      }
    }
  EXPECT_GT(seen, 10000U);
}

TEST(TexturedGltf, AFaceWithoutALayoutIsRefused) {
  EXPECT_EQ(encode_gltf(ball_face(), nullptr, GltfKind::binary, GltfNames::ict,
                        {.side_px = 64, .beside = false, .marks = {}})
                .error()
                .code,
            ErrorCode::bad_usage);
}

}  // namespace
}  // namespace mien::render::face_textures_test
