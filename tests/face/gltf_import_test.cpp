#include "mien/face/gltf_import.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>

#include "mien/builtin_face/load_face.h"
#include "mien/core/bytes.h"
#include "mien/core/files.h"
#include "tests/folder.h"

namespace mien::face::gltf_import_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;

/// A head of six vertices, two eyeballs of three, and the targets that a test asks for. Every part of the
/// text can be changed by a test, so that each wrong input stands alone.
struct Head {
  std::vector<std::string> names = {"jawOpen", "eyeBlinkLeft", "eyeBlinkRight", "browInnerUp", "jawForward"};
  float scale = 1;
  float turn = 1;  ///< -1: it looks along -Z, as VRM 0 does.
  std::string head_node = R"({"name":"Head","mesh":0,"children":[1,2]})";
  std::string extra;  ///< Further members of the root.
  std::string target_names;
  std::function<void(std::string&)> edit = [](std::string&) {};
  std::function<void(std::vector<std::byte>&)> edit_binary = [](std::vector<std::byte>&) {};

  [[nodiscard]] std::vector<Vec3f> positions() const {
    const std::vector<Vec3f> p = {{-0.05F, -0.08F, 0.08F}, {0.05F, -0.08F, 0.08F},  {0, 0.1F, 0.1F},
                                  {0.035F, 0.03F, 0.07F},  {-0.035F, 0.03F, 0.07F}, {0, 0.05F, 0.1F}};
    std::vector<Vec3f> out;
    for (const Vec3f& v : p) out.emplace_back(scale * turn * v.x(), scale * v.y(), scale * turn * v.z());
    return out;
  }
  [[nodiscard]] std::vector<Vec3f> target(std::size_t t) const {
    std::vector<Vec3f> d(6, Vec3f::Zero());
    switch (t % 5) {
      case 0:
        d[0] = d[1] = {0, -0.04F, 0};
        break;
      case 1:
        d[3] = {0, -0.01F, 0};
        break;
      case 2:
        d[4] = {0, -0.01F, 0};
        break;
      case 3:
        d[2] = d[3] = d[4] = {0, 0.01F, 0};
        break;
      default:
        d[0] = d[1] = {0, 0, 0.01F};
    }
    for (Vec3f& v : d) v = {scale * turn * v.x(), scale * v.y(), scale * turn * v.z()};
    return d;
  }

  [[nodiscard]] std::vector<std::byte> glb() const {
    ByteWriter binary;
    std::string views;
    std::string accessors;
    int count = 0;
    const auto add = [&](const std::vector<Vec3f>& rows) {
      views += fmt::format(R"({}{{"buffer":0,"byteOffset":{},"byteLength":{}}})", count > 0 ? "," : "",
                           binary.bytes().size(), rows.size() * 12);
      accessors += fmt::format(R"({}{{"bufferView":{},"componentType":5126,"count":{},"type":"VEC3"}})",
                               count > 0 ? "," : "", count, rows.size());
      for (const Vec3f& v : rows)
        for (int c = 0; c < 3; ++c) binary.little(v[c]);
      return count++;
    };
    add(positions());
    std::string targets;
    std::string quoted;
    for (std::size_t t = 0; t < names.size(); ++t) {
      targets += fmt::format(R"({}{{"POSITION":{}}})", t > 0 ? "," : "", add(target(t)));
      quoted += fmt::format(R"({}"{}")", t > 0 ? "," : "", names[t]);
    }
    const int eye = add({{-0.01F * scale, 0, 0}, {0.01F * scale, 0, 0}, {0, 0.01F * scale, 0}});
    views += fmt::format(R"(,{{"buffer":0,"byteOffset":{},"byteLength":6}})", binary.bytes().size());
    accessors += fmt::format(R"(,{{"bufferView":{},"componentType":5123,"count":3,"type":"SCALAR"}})", count);
    const int index = count++;
    for (const std::uint16_t i : {0, 1, 2}) binary.little(i);
    binary.little(std::uint16_t{0});

    std::string json = fmt::format(
        R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{},)"
        R"({{"name":"eye_a","mesh":1,"translation":[{},{},{}]}},{{"name":"eye_b","mesh":1,"translation":[{},{},{}]}}],)"
        R"("meshes":[{{"name":"Skin","extras":{{"targetNames":[{}]}},"primitives":[{{"attributes":{{"POSITION":0}},"targets":[{}]}}]}},)"
        R"({{"name":"eyes","primitives":[{{"attributes":{{"POSITION":{}}},"indices":{}}}]}}],)"
        R"("accessors":[{}],"bufferViews":[{}],"buffers":[{{"byteLength":{}}}]{}}})",
        head_node, 0.03 * scale * turn, 0.03 * scale, 0.06 * scale * turn, -0.03 * scale * turn, 0.03 * scale,
        0.06 * scale * turn, target_names.empty() ? quoted : target_names, targets, eye, index, accessors,
        views, binary.bytes().size(), extra);
    edit(json);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::vector<std::byte> data(binary.bytes().begin(), binary.bytes().end());
    edit_binary(data);
    ByteWriter out;
    out.append("glTF");
    out.little(std::uint32_t{2});
    out.little(static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + data.size()));
    out.little(static_cast<std::uint32_t>(json.size()));
    out.append("JSON");
    out.append(json);
    out.little(static_cast<std::uint32_t>(data.size()));
    out.append(std::string_view("BIN\0", 4));
    out.append(std::span<const std::byte>(data));
    return out.release();
  }
};

void replace(std::string& text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
}

GltfHead parsed(const Head& head) {
  auto result = parse_gltf(head.glb(), "head.glb");
  EXPECT_TRUE(result) << result.error().message();
  return result ? std::move(*result) : GltfHead{};
}

float peak_cm(const GltfHead& head, std::string_view name) {
  return 100 * peak_displacement_m(head.face, name);
}

TEST(GltfNames, AreReadInEverySpelling) {
  using Shapes = std::vector<std::size_t>;
  for (const char* name : {"eyeBlinkLeft", "EyeBlinkLeft", "eyeBlink_L", "eyeblink_l", "eye_blink_left",
                           "Face.eyeBlink_L", "mesh:EyeBlink-Left", "EYEBLINKLEFT"})
    EXPECT_EQ(shapes_of_name(name), Shapes{shape("eyeBlink_L")}) << name;
  EXPECT_EQ(shapes_of_name("mouthLeft"), Shapes{shape("mouthLeft")});
  EXPECT_EQ(shapes_of_name("jawRight"), Shapes{shape("jawRight")});
  EXPECT_EQ(shapes_of_name("tongueOut"), Shapes{kShapeCount});
  EXPECT_EQ(shapes_of_name("BrowInnerUp"), (Shapes{shape("browInnerUp_L"), shape("browInnerUp_R")}));
  EXPECT_EQ(shapes_of_name("browInnerUp_R"), Shapes{shape("browInnerUp_R")});
  for (const char* name : {"", "Basis", "A", "smile", "eyeBlink", "Fcl_ALL_Joy", "..."})
    EXPECT_TRUE(shapes_of_name(name).empty()) << name;
}

TEST(Gltf, BecomesAFaceOfAllMeshes) {
  const GltfHead head = parsed({});
  const Face& face = head.face;
  EXPECT_EQ(face.name, "head");
  EXPECT_EQ(head.metres_per_unit, 1);
  EXPECT_EQ(face.neutral_m.size(), 12U);
  EXPECT_EQ(face.triangles.size(), 4U);
  ASSERT_EQ(face.parts.size(), 3U);
  EXPECT_EQ(face.parts[0].material, Material::skin);
  EXPECT_EQ(face.parts[1].material, Material::sclera);
  ASSERT_EQ(face.shapes.size(), kShapeCount) << "no tongue";
  for (std::size_t k = 0; k < kShapeCount; ++k) EXPECT_EQ(face.shapes[k].name, kShapeNames[k]);
  EXPECT_NEAR(peak_cm(head, "jawOpen"), 4, 1e-4);
  EXPECT_NEAR(peak_cm(head, "eyeBlink_L"), 1, 1e-4);
  EXPECT_EQ(face.find_shape("eyeBlink_L")->vertex, std::vector<std::uint32_t>{3});
  EXPECT_EQ(peak_cm(head, "mouthFunnel"), 0);
  EXPECT_EQ(head.missing.size(), 53U - 6U);
  EXPECT_EQ(face.region("skin")->vertex.size(), 6U);
  EXPECT_FALSE(face.has_landmarks);
  // The mesh is one and its nodes are two; which is whose shows in where they are.
  EXPECT_EQ(face.eyes[0].first_vertex, 6U);
  EXPECT_EQ(face.eyes[1].first_vertex, 9U);
  EXPECT_TRUE(face.eyes[0].centre_m.isApprox(Vec3f(0.03F, 0.03F, 0.06F), 1e-5F));
}

TEST(Gltf, SplitsWhatIsInOnePieceSoThatTheHalvesAddUp) {
  const GltfHead head = parsed({});
  std::vector<Vec3f> both(12);
  BlendshapeWeights weights;
  weights[shape("browInnerUp_L")] = weights[shape("browInnerUp_R")] = 1;
  evaluate(head.face, weights, 0, both);
  for (const std::size_t v : {2U, 3U, 4U})
    EXPECT_NEAR(both[v].y() - head.face.neutral_m[v].y(), 0.01, 1e-6) << v;
  EXPECT_EQ(head.face.find_shape("browInnerUp_L")->vertex, (std::vector<std::uint32_t>{2, 3}));
  EXPECT_NEAR(head.face.find_shape("browInnerUp_L")->delta_m[0].y(), 0.005, 1e-6)
      << "in the middle each has half";
}

TEST(Gltf, ASidesOwnTargetComesBeforeHalfOfOneInOnePiece) {
  Head h;
  h.names = {"browInnerUp", "browInnerUp_L", "jawOpen"};
  const GltfHead head = parsed(h);
  EXPECT_EQ(head.face.find_shape("browInnerUp_L")->vertex, std::vector<std::uint32_t>{3});
}

TEST(Gltf, TheTongueComesLastWhereThereIsOne) {
  Head h;
  h.names.push_back("tongueOut");
  const GltfHead head = parsed(h);
  ASSERT_EQ(head.face.shapes.size(), kShapeCount + 1);
  EXPECT_EQ(head.face.shapes.back().name, "tongueOut");
}

TEST(Gltf, IsBroughtToMetresAndTurnedToTheFront) {
  for (const float scale : {0.01F, 1.0F, 39.37F, 100.0F, 1000.0F, 5.0F}) {
    for (const float turn : {1.0F, -1.0F}) {
      Head h;
      h.scale = scale;
      h.turn = turn;
      const GltfHead head = parsed(h);
      ASSERT_EQ(head.face.neutral_m.size(), 12U);
      const float size = (head.face.neutral_m[2] - head.face.neutral_m[0]).norm();
      EXPECT_NEAR(size, 0.188, 0.03) << scale;
      EXPECT_GT(head.face.neutral_m[3].x(), 0) << "left on +X";
      EXPECT_GT(head.face.neutral_m[2].z(), 0) << "looks along +Z";
      EXPECT_GT(head.face.eyes[0].centre_m.x(), 0);
      EXPECT_EQ(head.metres_per_unit == 1, scale == 1) << scale;
    }
  }
}

TEST(Gltf, NamesOfTheViewersSideAreTold) {
  Head h;
  h.names = {"jawOpen", "eyeBlinkRight", "eyeBlinkLeft", "browInnerUp", "jawForward"};
  EXPECT_THAT(parsed(h).warnings[0], HasSubstr("viewer"));
}

TEST(Gltf, NodesPlaceTurnAndScaleTheirMeshes) {
  Head h;
  // A quarter turn about +X and half the size: y becomes z.
  h.head_node =
      R"({"mesh":0,"rotation":[0.70710678,0,0,0.70710678],"scale":[0.5,0.5,0.5],"translation":[0,1,0]})";
  h.edit = [](std::string& json) { replace(json, "jawForward", "whatever"); };
  const GltfHead head = parsed(h);
  EXPECT_TRUE(head.face.neutral_m[2].isApprox(Vec3f(0, 1 - 0.05F, 0.05F), 1e-4F))
      << head.face.neutral_m[2].transpose();
  EXPECT_NEAR(peak_cm(head, "jawOpen"), 2, 1e-3);
  h.head_node = R"({"mesh":0,"matrix":[1,0,0,0, 0,1,0,0, 0,0,1,0, 0.5,0.25,0,1]})";
  EXPECT_TRUE(parsed(h).face.neutral_m[2].isApprox(Vec3f(0.5F, 0.35F, 0.1F), 1e-5F));
}

TEST(Gltf, ReadsSparseTargetsAndTargetsWithoutData) {
  Head h;
  h.edit = [](std::string& json) {
    // jawOpen's accessor (1) loses its view and moves one vertex by the first three floats of the positions.
    replace(
        json, R"({"bufferView":1,"componentType":5126,"count":6,"type":"VEC3"})",
        R"({"componentType":5126,"count":6,"type":"VEC3","sparse":{"count":1,)"
        R"("indices":{"bufferView":7,"byteOffset":2,"componentType":5123},"values":{"bufferView":0,"byteOffset":0}}})");
    replace(json, R"({"bufferView":2,"componentType":5126,"count":6,"type":"VEC3"})",
            R"({"componentType":5126,"count":6,"type":"VEC3"})");
  };
  const GltfHead head = parsed(h);
  const Shape& jaw = *head.face.find_shape("jawOpen");
  ASSERT_EQ(jaw.vertex, std::vector<std::uint32_t>{1}) << "the index list's second number";
  EXPECT_TRUE(jaw.delta_m[0].isApprox(Vec3f(-0.05F, -0.08F, 0.08F)));
  EXPECT_EQ(peak_cm(head, "eyeBlink_L"), 0);
}

TEST(Gltf, PrimitivesThatShareTheirVerticesKeepThemShared) {
  Head h;
  h.edit = [](std::string& json) {
    // The skin's primitive once more, with another material and three indices of its own.
    const std::size_t first = json.find(R"({"attributes":{"POSITION":0})");
    const std::size_t end = json.find("]}]}", first) + 2;
    std::string again = json.substr(first, end - first);
    replace(again, R"("targets")", R"("indices":7,"material":0,"targets")");
    json.insert(end, "," + again);
    replace(json, R"("scene":0)", R"("materials":[{"name":"teeth"}],"scene":0)");
  };
  const GltfHead head = parsed(h);
  EXPECT_EQ(head.face.neutral_m.size(), 12U);
  EXPECT_EQ(head.face.triangles.size(), 5U);
  EXPECT_EQ(head.face.parts[1].material, Material::teeth);
  EXPECT_NEAR(peak_cm(head, "jawOpen"), 4, 1e-4);
  EXPECT_EQ(head.face.region("skin")->vertex.size(), 6U);
}

TEST(Gltf, VrmClipsNameWhatTargetsDoNot) {
  Head h;
  h.target_names = R"("Fcl_1","Fcl_2","Fcl_3","Fcl_4","Fcl_5")";
  h.extra =
      R"(,"extensions":{"VRM":{"blendShapeMaster":{"blendShapeGroups":[)"
      R"({"name":"JawOpen","binds":[{"mesh":0,"index":0,"weight":50},{"mesh":0,"index":4,"weight":100}]},)"
      R"({"name":"Joy","binds":[{"mesh":0,"index":3,"weight":100}]},{"name":"EyeBlinkLeft"},7]}}})";
  const GltfHead vrm0 = parsed(h);
  EXPECT_TRUE(vrm0.face.find_shape("jawOpen")->delta_m[0].isApprox(Vec3f(0, -0.02F, 0.01F)));
  h.extra = R"(,"extensions":{"VRMC_vrm":{"expressions":{"custom":{)"
            R"("JawOpen":{"morphTargetBinds":[{"node":0,"index":0,"weight":0.25}]},"x":3}}}})";
  EXPECT_NEAR(peak_cm(parsed(h), "jawOpen"), 1, 1e-4);
}

TEST(Gltf, ASkinAtRestPlacesItsVertices) {
  Head h;
  // All vertices hang on node 1 (an eye, at 0.03 0.03 0.06) without inverse bind matrices: they move there.
  h.edit = [](std::string& json) {
    replace(json, R"("mesh":0,)", R"("mesh":0,"skin":0,"translation":[9,9,9],)");
    replace(json, R"("attributes":{"POSITION":0})",
            R"("attributes":{"POSITION":0,"JOINTS_0":8,"WEIGHTS_0":9})");
    replace(json, R"("nodes":[{)", R"("skins":[{"joints":[3]}],"nodes":[{)");
    replace(json, R"(],"meshes")", R"(,{"translation":[0.25,0,0]}],"meshes")");
    replace(json, R"("scenes":[{"nodes":[0]}])", R"("scenes":[{"nodes":[0,3]}])");
    // Weights of nothing at all: sparse accessors without values are zero, so the node itself places the
    // mesh.
    replace(
        json, R"(],"bufferViews")",
        R"(,{"componentType":5123,"count":6,"type":"VEC4"},{"componentType":5126,"count":6,"type":"VEC4",)"
        R"("sparse":{"count":1,"indices":{"bufferView":7,"componentType":5123},"values":{"bufferView":10}}}],"bufferViews")");
    replace(
        json, R"(],"buffers")",
        R"(,{"buffer":0,"byteOffset":0,"byteLength":0},{"buffer":0,"byteOffset":0,"byteLength":0},{"buffer":1,"byteLength":16}],"buffers")");
    replace(json, R"("buffers":[)", R"("buffers":[)");
    const std::size_t end = json.rfind("]");
    json.insert(
        end, R"(,{"byteLength":16,"uri":"data:application/octet-stream;base64,AACAPwAAAAAAAAAAAAAAAA=="})");
  };
  const GltfHead head = parsed(h);
  ASSERT_EQ(head.face.neutral_m.size(), 12U);
  const Vec3f p = Head{}.positions()[0];
  EXPECT_TRUE((head.face.neutral_m[0] / static_cast<float>(head.metres_per_unit))
                  .isApprox(p + Vec3f(0.25F, 0, 0), 1e-4F))
      << "vertex 0 hangs on the joint, not on its node";
}

struct BadGltf {
  const char* what;
  std::function<void(std::string&)> edit;
  ErrorCode code;
};

class GltfRefuses : public ::testing::TestWithParam<BadGltf> {};

TEST_P(GltfRefuses, InOneLine) {
  Head head;
  head.edit = GetParam().edit;
  const auto result = parse_gltf(head.glb(), "bad.glb");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, GetParam().code) << result.error().message();
  EXPECT_EQ(result.error().message().find('\n'), std::string::npos);
}

BadGltf with(const char* what, std::string from, std::string to, ErrorCode code = ErrorCode::malformed) {
  return {what, [from = std::move(from), to = std::move(to)](std::string& json) { replace(json, from, to); },
          code};
}

INSTANTIATE_TEST_SUITE_P(
    Gltf, GltfRefuses,
    ::testing::Values(
        BadGltf{"not_json", [](std::string& json) { json = "nothing"; }, ErrorCode::malformed},
        BadGltf{"empty_json", [](std::string& json) { json = "{}"; }, ErrorCode::malformed},
        BadGltf{"deep", [](std::string& json) { json = std::string(100000, '['); }, ErrorCode::malformed},
        with("deep_extras", R"("scene":0)",
             R"("extras":)" + std::string(5000, '[') + std::string(5000, ']') + R"(,"scene":0)"),
        with("no_names", R"("targetNames")", R"("otherNames")", ErrorCode::not_found),
        with("compressed", R"("scene":0)", R"("extensionsRequired":["KHR_draco_mesh_compression"],"scene":0)",
             ErrorCode::unsupported),
        with("huge_count", R"("count":6)", R"("count":4000000000)", ErrorCode::malformed),
        with("count_beyond_view", R"("count":6)", R"("count":7)", ErrorCode::truncated),
        with("view_beyond_buffer", R"("byteLength":72)", R"("byteLength":720000)", ErrorCode::truncated),
        with("view_offset_huge", R"("byteOffset":0,"byteLength":72)",
             R"("byteOffset":4294967295,"byteLength":72)", ErrorCode::truncated),
        with("wrong_type", R"("count":6,"type":"VEC3")", R"("count":6,"type":"VEC2")"),
        with("target_of_another_size", R"({"bufferView":1,"componentType":5126,"count":6)",
             R"({"bufferView":1,"componentType":5126,"count":5)"),
        with("index_beyond", R"("indices":7)", R"("indices":0)"),
        with("accessor_beyond", R"("POSITION":0)", R"("POSITION":99)"),
        with("mesh_beyond", R"("mesh":1)", R"("mesh":9)"),
        with("child_beyond", R"("children":[1,2])", R"("children":[1,77])"),
        with("huge_transform", R"("name":"Head")", R"("name":"Head","scale":[1e30,1,1])",
             ErrorCode::out_of_range),
        with("positions_without_data", R"({"bufferView":0,"componentType":5126)", R"({"componentType":5126)"),
        with("buffer_too_long", R"("buffers":[{"byteLength":)", R"("buffers":[{"byteLength":9)"),
        with("buffer_elsewhere", R"("buffers":[{)", R"("buffers":[{"uri":"/etc/hostname",)")),
    [](const auto& one) { return std::string(one.param.what); });

TEST(Gltf, IsCalledDamagedInOurWords) {
  const auto refusal = [](const std::string& from, const std::string& to) {
    Head head;
    head.edit = [&](std::string& json) { replace(json, from, to); };
    const auto result = parse_gltf(head.glb(), "bad.glb");
    return result ? std::string() : result.error().message();
  };
  EXPECT_THAT(refusal(R"("scene":0)", R"("scene":!)"),
              MatchesRegex("bad.glb: its JSON is broken at line 1, column [0-9]+; export it again, or .*"));
  EXPECT_THAT(
      refusal(R"("count":6)", R"("count":"6")"),
      MatchesRegex("bad.glb: it is damaged, or no sound glTF \\(.*count.*\\); export it again, or .*"));
}

TEST(Gltf, RefusesNumbersThatAreNotFinite) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e30F}) {
    Head head;
    head.edit_binary = [bad](std::vector<std::byte>& data) {
      const auto raw = std::bit_cast<std::array<std::byte, 4>>(bad);
      std::ranges::copy(raw, data.begin() + 16);
    };
    const auto result = parse_gltf(head.glb(), "bad.glb");
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::out_of_range);
  }
}

TEST(Gltf, RefusesEveryTruncation) {
  const auto whole = Head{}.glb();
  for (std::size_t n = 0; n < whole.size(); ++n)
    EXPECT_FALSE(parse_gltf(std::span(whole).first(n), "cut.glb")) << n << " of " << whole.size();
}

TEST(Gltf, ANodeThatIsItsOwnChildIsTakenOnce) {
  Head head;
  head.head_node = R"({"mesh":0,"children":[0,1,2]})";
  EXPECT_EQ(parsed(head).face.neutral_m.size(), 12U);
}

TEST(Gltf, FilesAreReadFromItsOwnFolderOnly) {
  const mien::test::Folder folder;
  fs::create_directories(folder / "inside");
  const auto glb = Head{}.glb();
  // Taken apart: the JSON with its buffer named, and the binary chunk beside it.
  ByteReader reader{std::span(glb).subspan(12)};
  const auto json_bytes = reader.take(reader.little<std::uint32_t>() + 4).subspan(4);
  const std::string json(reinterpret_cast<const char*>(json_bytes.data()), json_bytes.size());
  const auto binary = reader.take(reader.little<std::uint32_t>() + 4).subspan(4);
  ASSERT_TRUE(write_file(folder / "inside" / "head.bin", binary));
  ASSERT_TRUE(write_file(folder / "outside.bin", binary));
  for (const auto& [uri, works] :
       {std::pair{"head.bin", true}, std::pair{"../outside.bin", false}, std::pair{"missing.bin", false}}) {
    std::string text = json;
    replace(text, R"("buffers":[{)", fmt::format(R"("buffers":[{{"uri":"{}",)", uri));
    ASSERT_TRUE(write_file(folder / "inside" / "head.gltf", text));
    const auto head = import_gltf(folder / "inside" / "head.gltf");
    EXPECT_EQ(head.has_value(), works) << uri;
    if (!works) {
      EXPECT_THAT(head.error().message(),
                  HasSubstr("head.gltf: a file that it names is not in its folder ("));
    }
    EXPECT_EQ(builtin_face::load_face((folder / "inside" / "head.gltf").string()).has_value(), works) << uri;
  }
  EXPECT_EQ(import_gltf(folder / "nothing.glb").error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace mien::face::gltf_import_test
