#include "mien/face/ict_import.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>

#include "mien/builtin_face/load_face.h"
#include "mien/core/files.h"
#include "mien/face/ict_cache.h"
#include "tests/project_path.h"

namespace mien::face::ict_import_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr std::size_t kVertices = 26719;

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

/// Text of a mesh of ICT's size: vertices on a grid, one of them moved.
std::string mesh_text(std::size_t moved = kNone, const char* to = "", bool faces = false,
                      std::size_t count = kVertices) {
  std::string text;
  text.reserve(count * 12);
  for (std::size_t v = 0; v < count; ++v)
    text +=
        v == moved ? fmt::format("v {}\n", to) : fmt::format("v {} {} {}\n", v % 30, v / 30 % 30, v / 900);
  if (faces) text += "usemtl M_Face\nf 1/1 2/2 32/3 31/4\nusemtl M_Teeth\nf 17041 17042 17072\n";
  return text;
}

/// A folder with a made-up model: shape k moves vertex k by 1 cm along z.
class IctFolder : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder() = fs::path(::testing::TempDir()) / ("mien_ict_import_test_" + std::to_string(::getpid()));
    fs::remove_all(folder());
    fs::create_directories(model());
    put("generic_neutral_mesh.obj", mesh_text(kNone, "", true));
    for (std::size_t k = 0; k < kShapeCount; ++k)
      put(fmt::format("{}.obj", kShapeNames[k]),
          mesh_text(k, fmt::format("{} {} {}", k % 30, k / 30 % 30, k / 900 + 1).c_str()));
    put("vertex_indices.json", landmarks(68));
  }
  static void TearDownTestSuite() { fs::remove_all(folder()); }

  static fs::path& folder() {
    static fs::path path;
    return path;
  }
  static fs::path model() { return folder() / "FaceXModel"; }
  static void put(const std::string& name, const std::string& text) {
    ASSERT_TRUE(write_file(model() / name, text));
  }
  static std::string landmarks(std::size_t count, int last = 68) {
    std::string text = R"({"idx_to_rigid_verts": [9, 3, 5], "idx_to_landmark_verts": [)";
    for (std::size_t i = 0; i + 1 < count; ++i) text += fmt::format("{},", i + 1);
    return text + fmt::format("{}]}}", last);
  }
  static IctOptions options(bool cache) {
    IctOptions o;
    o.cache = cache;
    o.cache_folder = folder() / "cache";
    return o;
  }
  static fs::path cache() { return cache_path(fs::canonical(model()), options(true)); }
};

TEST_F(IctFolder, BecomesAFaceInMetresAndTriangles) {
  const auto result = import_ict_model(model(), options(false));
  ASSERT_TRUE(result) << result.error().message();
  const Face& face = result->face;
  EXPECT_EQ(face.name, "ict");
  ASSERT_EQ(face.neutral_m.size(), kVertices);
  EXPECT_TRUE(face.neutral_m[931].isApprox(Vec3f(0.01F, 0.01F, 0.01F)));
  EXPECT_EQ(face.triangles.size(), 3U);
  ASSERT_EQ(face.parts.size(), 2U);
  EXPECT_EQ(face.parts[1].name, "teeth_upper");
  EXPECT_EQ(face.parts[1].material, Material::teeth);
  ASSERT_EQ(face.shapes.size(), kShapeCount);
  for (std::size_t k = 0; k < kShapeCount; ++k) {
    const Shape& s = face.shapes[k];
    EXPECT_EQ(s.name, kShapeNames[k]);
    ASSERT_EQ(s.vertex, std::vector<std::uint32_t>{static_cast<std::uint32_t>(k)});
    EXPECT_TRUE(s.delta_m[0].isApprox(Vec3f(0, 0, 0.01F))) << s.name;
  }
  EXPECT_TRUE(face.has_landmarks);
  EXPECT_EQ(face.landmarks[0], 1U);
  EXPECT_EQ(face.landmarks[67], 68U);
  ASSERT_NE(face.region("skin"), nullptr);
  EXPECT_EQ(face.region("skin")->vertex.size(), 9409U);
  ASSERT_NE(face.region("rigid"), nullptr);
  EXPECT_EQ(face.region("rigid")->vertex, (std::vector<std::uint32_t>{3, 5, 9}));
  EXPECT_EQ(face.eyes[0].first_vertex, 21451U);
  EXPECT_EQ(face.eyes[0].vertex_count, 1570U);
  EXPECT_EQ(face.eyes[1].first_vertex, 23021U);
  for (const Eyeball& eye : face.eyes) EXPECT_TRUE(eye.centre_m.allFinite());
}

TEST_F(IctFolder, IsTheSameFromItsCacheAndRebuildsABrokenOne) {
  const auto fresh = import_ict_model(model(), options(false));
  ASSERT_TRUE(fresh);
  const auto same = [&](const IctModel& other) {
    EXPECT_EQ(encode_cache(other, "k"), encode_cache(*fresh, "k"));
  };
  fs::remove(cache());
  ASSERT_TRUE(import_ict_model(model(), options(true)));
  ASSERT_TRUE(fs::exists(cache()));
  const auto good = read_file(cache());
  ASSERT_TRUE(good);

  const auto from_cache = import_ict_model(model(), options(true));
  ASSERT_TRUE(from_cache);
  same(*from_cache);

  std::vector<std::vector<std::byte>> broken = {
      {}, {good->begin(), good->begin() + 100}, *good, *good, *good};
  broken[2][good->size() / 2] ^= std::byte{1};
  broken[3][8] ^= std::byte{1};  // The version, with a checksum that fits.
  broken[4].insert(broken[4].end(), 7, std::byte{0});
  for (const auto& bytes : broken) {
    ASSERT_TRUE(write_file(cache(), bytes));
    const auto rebuilt = import_ict_model(model(), options(true));
    ASSERT_TRUE(rebuilt);
    same(*rebuilt);
    EXPECT_EQ(*read_file(cache()), *good) << "written anew";
  }
}

TEST_F(IctFolder, NoticesThatAMeshHasChanged) {
  ASSERT_TRUE(import_ict_model(model(), options(true)));
  const std::string name(kShapeNames[7]);
  const auto old_text = read_text(model() / (name + ".obj"));
  put(name + ".obj", mesh_text(7, "7 0 3.25"));
  const auto changed = import_ict_model(model(), options(true));
  put(name + ".obj", *old_text);
  ASSERT_TRUE(changed);
  EXPECT_NEAR(changed->face.shapes[7].delta_m[0].z(), 0.0325, 1e-7);
}

TEST_F(IctFolder, GoesOnWithoutACacheThatCannotBeKept) {
  IctOptions o = options(true);
  o.cache_folder = model() / "generic_neutral_mesh.obj" / "below a file";
  EXPECT_TRUE(import_ict_model(model(), o));
}

TEST_F(IctFolder, RefusesEveryBadMeshByName) {
  struct Bad {
    const char* what;
    std::string text;
    ErrorCode code;
  };
  const auto old_text = read_text(model() / "jawOpen.obj");
  for (const Bad& bad :
       {Bad{"empty", "", ErrorCode::truncated},
        Bad{"one vertex short", mesh_text(kNone, "", false, kVertices - 1), ErrorCode::mismatch},
        Bad{"one vertex more", mesh_text(kNone, "", false, kVertices + 1), ErrorCode::mismatch},
        Bad{"cut in a line", old_text->substr(0, old_text->size() / 2) + "v 1 2", ErrorCode::malformed},
        Bad{"not finite", mesh_text(5, "nan 0 0"), ErrorCode::malformed},
        Bad{"a kilometre away", mesh_text(5, "1e5 0 0"), ErrorCode::out_of_range}}) {
    put("jawOpen.obj", bad.text);
    const auto result = import_ict_model(model(), options(false));
    ASSERT_FALSE(result) << bad.what;
    EXPECT_EQ(result.error().code, bad.code) << result.error().message();
    EXPECT_THAT(result.error().where, HasSubstr("jawOpen.obj")) << bad.what;
  }
  fs::remove(model() / "jawOpen.obj");
  EXPECT_EQ(import_ict_model(model(), options(false)).error().code, ErrorCode::not_found);
  put("jawOpen.obj", *old_text);
}

TEST_F(IctFolder, RefusesBadIndices) {
  for (const std::string& text :
       {std::string("[1, 2"), std::string("[]"), landmarks(67), landmarks(68, 26719), landmarks(68, -1),
        std::string(R"({"idx_to_landmark_verts": 3})"), std::string(R"({"idx_to_landmark_verts": [1.5]})")}) {
    put("vertex_indices.json", text);
    const auto result = import_ict_model(model(), options(false));
    ASSERT_FALSE(result) << text;
    EXPECT_THAT(result.error().where, HasSubstr("vertex_indices.json"));
  }
  fs::remove(model() / "vertex_indices.json");
  const auto without = import_ict_model(model(), options(false));
  put("vertex_indices.json", landmarks(68));
  ASSERT_TRUE(without);
  EXPECT_EQ(without->face.landmarks[0], 1225U) << "the model's own";
}

TEST_F(IctFolder, StopsWhenAskedAndSaysWhatIsMissing) {
  const auto stopped =
      import_ict_model(model(), options(false), [](double, std::string_view) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
  IctOptions o = options(false);
  o.identities = true;
  EXPECT_THAT(import_ict_model(model(), o).error().where, HasSubstr("identity000.obj"));
  EXPECT_EQ(import_ict_model(folder() / "nowhere", o).error().code, ErrorCode::not_found);
}

TEST_F(IctFolder, IsFoundByLoadFace) {
  ASSERT_EQ(::setenv("XDG_CACHE_HOME", folder().c_str(), 1), 0);
  for (const fs::path& path : {folder(), model()}) {
    const auto face = builtin_face::load_face(path.string());
    ASSERT_TRUE(face) << face.error().message();
    EXPECT_EQ(face->name, "ict");
  }
  EXPECT_TRUE(fs::exists(folder() / "mien")) << "the cache is in XDG_CACHE_HOME/mien";
  EXPECT_EQ(builtin_face::load_face((folder() / "cache").string()).error().code, ErrorCode::not_found);
  EXPECT_EQ(builtin_face::load_face((folder() / "nobody").string()).error().code, ErrorCode::not_found);
  EXPECT_EQ(builtin_face::load_face((model() / "jawOpen.obj").string()).error().code, ErrorCode::unsupported);
}

TEST(LoadFace, KnowsTheBuiltInFaceByName) {
  const auto face = builtin_face::load_face("builtin");
  ASSERT_TRUE(face) << face.error().message();
  EXPECT_EQ(face->shapes.size(), kShapeCount + 1);
  EXPECT_TRUE(face->has_landmarks);
}

TEST(IctCache, AnyShortenedOrAlteredBytesAreNoModel) {
  IctModel model;
  model.face.neutral_m = {{1, 2, 3}, {4, 5, 6}};
  model.face.triangles = {{0, 1, 1}};
  model.face.parts = {{"skin", Material::skin, 0, 1}};
  for (const std::string_view name : kShapeNames)
    model.face.shapes.push_back({std::string(name), {1}, {{1, 1, 1}}});
  model.face.regions = {{"skin", {0, 1}}};
  model.identities = {{"identity000", {{1, 2, 3}, {4, 5, 6}}}};
  const auto bytes = encode_cache(model, "key");
  ASSERT_TRUE(decode_cache(bytes, "key"));
  EXPECT_FALSE(decode_cache(bytes, "other key"));
  for (std::size_t n = 0; n < bytes.size(); ++n) EXPECT_FALSE(decode_cache(std::span(bytes).first(n), "key"));
  for (std::size_t n = 0; n < bytes.size(); n += 3) {
    auto altered = bytes;
    altered[n] ^= std::byte{0x40};
    EXPECT_FALSE(decode_cache(altered, "key")) << n;
  }
  // A made-up cache with a sound checksum is no better than its content.
  model.face.shapes[3].vertex[0] = 2;
  EXPECT_FALSE(decode_cache(encode_cache(model, "key"), "key"));
  model.face.shapes[3].vertex[0] = 1;
  model.face.triangles[0][2] = 2;
  EXPECT_FALSE(decode_cache(encode_cache(model, "key"), "key"));
}

/// The real model, unpacked where MIEN_ICT_FOLDER says.
class RealIct : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!model()) GTEST_SKIP() << "no ICT-FaceKit in " << folder() << " (set MIEN_ICT_FOLDER)";
  }
  static fs::path folder() {
    const char* named = std::getenv("MIEN_ICT_FOLDER");
    return named != nullptr ? named : project_path("../build/ict/FaceXModel");
  }
  static const std::optional<IctModel>& model() {
    static const std::optional<IctModel> read = [] {
      std::optional<IctModel> none;
      if (!fs::exists(folder() / "generic_neutral_mesh.obj")) return none;
      IctOptions o;
      o.identities = true;
      o.cache = false;
      auto result = import_ict_model(folder(), o);
      EXPECT_TRUE(result) << result.error().message();
      return result ? std::optional(std::move(*result)) : none;
    }();
    return read;
  }
};

TEST_F(RealIct, IsWhatItsMeasuredTableSays) {
  const Face& face = model()->face;
  // Peak displacement at weight 1 in cm, measured on the model by other means; both sides alike.
  const std::map<std::string, double> peak_cm = {
      {"jawOpen", 4.20},     {"mouthClose", 4.18},  {"mouthLeft", 1.88},      {"mouthRight", 1.88},
      {"eyeBlink", 1.78},    {"mouthSmile", 1.58},  {"mouthRollLower", 1.42}, {"cheekPuff", 1.41},
      {"mouthPucker", 1.24}, {"mouthFunnel", 1.17}, {"mouthRollUpper", 1.16}, {"mouthShrugLower", 1.13},
      {"jawForward", 1.12},  {"noseSneer", 1.03},   {"mouthStretch", 1.03},   {"jawLeft", 0.89},
      {"jawRight", 0.89},    {"mouthDimple", 0.89}, {"mouthUpperUp", 0.88},   {"browOuterUp", 0.86},
      {"eyeLookDown", 0.77}, {"browDown", 0.65},    {"cheekSquint", 0.63},    {"mouthShrugUpper", 0.62},
      {"mouthFrown", 0.61},  {"browInnerUp", 0.61}, {"mouthLowerDown", 0.46}, {"mouthPress", 0.43},
      {"eyeSquint", 0.37},   {"eyeLookUp", 0.37},   {"eyeWide", 0.36},        {"eyeLookOut", 0.25},
      {"eyeLookIn", 0.25}};
  for (const Shape& s : face.shapes) {
    std::string stem = s.name;
    if (stem.ends_with("_L") || stem.ends_with("_R")) stem.resize(stem.size() - 2);
    ASSERT_TRUE(peak_cm.contains(stem)) << stem;
    EXPECT_NEAR(100 * peak_displacement_m(face, s.name), peak_cm.at(stem), 0.0051) << s.name;
  }
  const auto distance_m = [&](std::size_t a, std::size_t b) {
    return (face.neutral_m[face.landmarks[a]] - face.neutral_m[face.landmarks[b]]).norm();
  };
  EXPECT_NEAR(distance_m(48, 54), 0.0507, 0.0001) << "mouth corners";
  EXPECT_NEAR(distance_m(0, 16), 0.1473, 0.0001) << "jaw";
  EXPECT_NEAR(distance_m(36, 45), 0.0892, 0.0001) << "outer eye corners";
  EXPECT_LT(face.neutral_m[face.landmarks[0]].x(), 0) << "landmark 0 is on the performer's right";
}

TEST_F(RealIct, HasEyesThatTurnWithinTheirSockets) {
  const Face& face = model()->face;
  std::array<Vec3f, 2> mean;
  for (std::size_t e = 0; e < 2; ++e) {
    const Eyeball& eye = face.eyes[e];
    mean[e] = Vec3f::Zero();
    for (std::uint32_t v = eye.first_vertex; v < eye.first_vertex + eye.vertex_count; ++v)
      mean[e] += face.neutral_m[v] / static_cast<float>(eye.vertex_count);
    EXPECT_NEAR(mean[e].x(), e == 0 ? 0.03195 : -0.03195, 1e-4);
    EXPECT_NEAR(mean[e].y(), 0.03616, 1e-4);
    EXPECT_NEAR(mean[e].z(), 0.08441, 1e-4);
    // The centre is that of the ball, so a turned eye stays where it was: within 1.5 mm of its own sphere.
    for (std::uint32_t v = eye.first_vertex; v < eye.first_vertex + 770; ++v)
      EXPECT_NEAR((face.neutral_m[v] - eye.centre_m).norm(), 0.0155, 0.0026);
    EXPECT_GT(mean[e].z(), eye.centre_m.z());
  }
  EXPECT_NEAR((mean[0] - mean[1]).norm(), 0.0639, 0.0001) << "pupil distance";
}

TEST_F(RealIct, PartsAndRegionsAreWhatTheySay) {
  const Face& face = model()->face;
  std::size_t covered = 0;
  for (const Part& part : face.parts) {
    EXPECT_EQ(part.first_triangle, covered) << part.name;
    EXPECT_GT(part.triangle_count, 0U);
    covered += part.triangle_count;
  }
  EXPECT_EQ(covered, face.triangles.size());
  EXPECT_EQ(face.triangles.size(), 25836U * 2 + 548U);
  for (const char* name : {"skin", "lips", "brow_L", "brow_R", "eye_L", "eye_R", "nose", "mouth", "jaw",
                           "rigid", "narrow_face", "eyeball_L", "teeth_upper"}) {
    ASSERT_NE(face.region(name), nullptr) << name;
    EXPECT_FALSE(face.region(name)->vertex.empty()) << name;
    EXPECT_TRUE(std::ranges::is_sorted(face.region(name)->vertex)) << name;
  }
  const auto mean_x = [&](const char* name) {
    double sum = 0;
    for (const std::uint32_t v : face.region(name)->vertex) sum += face.neutral_m[v].x();
    return sum / static_cast<double>(face.region(name)->vertex.size());
  };
  EXPECT_GT(mean_x("brow_L"), 0.02);
  EXPECT_LT(mean_x("brow_R"), -0.02);
  EXPECT_GT(mean_x("eye_L"), 0.02);
  EXPECT_NEAR(mean_x("lips"), 0, 0.001);
}

TEST_F(RealIct, MakesOtherPeopleWithTheSameExpressions) {
  ASSERT_EQ(model()->identities.size(), 100U);
  const std::array<float, 3> coefficients = {1.5F, -1, 0.5F};
  const Face other = with_identity(*model(), coefficients);
  double moved = 0;
  for (std::size_t v = 0; v < other.neutral_m.size(); ++v)
    moved = std::max<double>(moved, (other.neutral_m[v] - model()->face.neutral_m[v]).norm());
  EXPECT_GT(moved, 0.002);
  EXPECT_LT(moved, 0.1);
  EXPECT_EQ(other.shapes[26].delta_m, model()->face.shapes[26].delta_m);
  EXPECT_NE(other.eyes[0].centre_m, model()->face.eyes[0].centre_m);
  EXPECT_EQ(with_identity(*model(), {}).neutral_m, model()->face.neutral_m);
}

}  // namespace
}  // namespace mien::face::ict_import_test
