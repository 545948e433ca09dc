#include "mien/render/gltf_export.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/core/encoding.h"
#include "mien/face/gltf_import.h"
#include "tests/render/ball_face.h"

namespace mien::render::gltf_export_test {
namespace {

using nlohmann::json;

face::Motion nod(double seconds) {
  face::Motion motion;
  motion.name = "nod";
  for (int i = 0; i * 0.05 <= seconds + 1e-9; ++i) {
    face::MotionFrame frame;
    frame.time_s = i * 0.05;
    frame.weights[face::shape("jawOpen")] = static_cast<float>(std::sin(3 * frame.time_s));
    frame.weights[face::shape("eyeLookUp_R")] = 0.5F;
    frame.head = exp_rotation(Vec3(0.3 * std::sin(2 * frame.time_s), 0, 0));
    motion.frames.push_back(frame);
  }
  motion.has_head = true;
  return motion;
}

struct Glb {
  json tree;
  std::vector<std::byte> buffer;
};

Glb open(const std::vector<std::byte>& content) {
  Glb glb;
  ByteReader reader(content);
  EXPECT_EQ(reader.little<std::uint32_t>(), 0x46546C67U);
  EXPECT_EQ(reader.little<std::uint32_t>(), 2U);
  EXPECT_EQ(reader.little<std::uint32_t>(), content.size());
  const auto text_size = reader.little<std::uint32_t>();
  EXPECT_EQ(reader.little<std::uint32_t>(), 0x4E4F534AU);
  const auto text = reader.take(text_size);
  glb.tree = json::parse(reinterpret_cast<const char*>(text.data()),
                         reinterpret_cast<const char*>(text.data()) + text.size());
  const auto size = reader.little<std::uint32_t>();
  EXPECT_EQ(reader.little<std::uint32_t>(), 0x004E4942U);
  const auto bytes = reader.take(size);
  glb.buffer.assign(bytes.begin(), bytes.end());
  EXPECT_TRUE(reader.ok());
  EXPECT_EQ(reader.left(), 0U);
  return glb;
}

/// The floats of a dense accessor.
std::vector<float> floats(const Glb& glb, std::size_t accessor) {
  const json& a = glb.tree["accessors"][accessor];
  const json& view = glb.tree["bufferViews"][a["bufferView"].get<std::size_t>()];
  ByteReader reader(
      std::span(glb.buffer)
          .subspan(view["byteOffset"].get<std::size_t>(), view["byteLength"].get<std::size_t>()));
  std::vector<float> values;
  while (reader.left() > 0) values.push_back(reader.little<float>());
  return values;
}

TEST(Gltf, ComesBackThroughTheImporter) {
  const face::Face face = ball_face();
  const auto content = encode_gltf(face, nullptr, GltfKind::binary);
  ASSERT_TRUE(content.has_value()) << content.error().message();
  const auto head = face::parse_gltf(*content, "ball.glb");
  ASSERT_TRUE(head.has_value()) << head.error().message();
  EXPECT_EQ(head->face.neutral_m.size(), face.neutral_m.size());
  EXPECT_EQ(head->face.triangles.size(), face.triangles.size());
  EXPECT_NEAR(peak_displacement_m(head->face, "jawOpen"), peak_displacement_m(face, "jawOpen"), 1e-7);
  EXPECT_NEAR(peak_displacement_m(head->face, "mouthSmile_L"), peak_displacement_m(face, "mouthSmile_L"),
              1e-7);
  EXPECT_EQ(peak_displacement_m(head->face, "mouthPucker"), 0);
}

/// A ribbon of hair on top of the ball, which no shape moves, and one at its left, which a smile does.
face::Face haired_ball() {
  face::Face face = ball_face();
  face.uv.assign(face.neutral_m.size(), Eigen::Vector2f::Zero());
  face.colour.assign(face.neutral_m.size() + 8, Vec3f(0.4F, 0.3F, 0.2F));
  for (const Vec3f& root : {Vec3f(0, 0.1F, 0), Vec3f(0.1F, 0, 0)}) {
    const auto first = static_cast<std::uint32_t>(face.neutral_m.size());
    for (int k = 0; k < 4; ++k) {
      face.neutral_m.push_back(root + Vec3f(0, k < 2 ? 0.0F : 0.02F, k % 2 == 0 ? 0.0F : 0.005F));
      face.uv.emplace_back(k % 2 == 0 ? 0.0F : 0.25F, k < 2 ? 0.0F : 1.0F);
    }
    face.parts.push_back(
        {"ribbon", face::Material::strands, static_cast<std::uint32_t>(face.triangles.size()), 2});
    face.triangles.push_back({first, first + 1, first + 3});
    face.triangles.push_back({first, first + 3, first + 2});
  }
  face::Shape& smile = face.shapes[face::shape("mouthSmile_L")];
  for (auto i = static_cast<std::uint32_t>(face.neutral_m.size()) - 4; i < face.neutral_m.size(); ++i) {
    smile.vertex.push_back(i);
    smile.delta_m.emplace_back(0.01F, 0.0F, 0.0F);
  }
  return face;
}

TEST(Gltf, HairHasATextureOfStrandsAndNoTargetsWhereNothingMovesIt) {
  const face::Face face = haired_ball();
  const auto content = encode_gltf(face, nullptr, GltfKind::binary).value();
  const Glb glb = open(content);
  json hair;
  for (const json& mesh : glb.tree["meshes"])
    if (mesh["name"] == "hair") hair = mesh;
  ASSERT_TRUE(hair.is_object());
  EXPECT_FALSE(hair.contains("weights"));
  ASSERT_EQ(hair["primitives"].size(), 1U);
  EXPECT_FALSE(hair["primitives"][0].contains("targets"));
  EXPECT_TRUE(hair["primitives"][0]["attributes"].contains("TEXCOORD_0"));
  const json& material = glb.tree["materials"][hair["primitives"][0]["material"].get<std::size_t>()];
  EXPECT_EQ(material["name"], "strands");
  EXPECT_EQ(material["alphaMode"], "MASK");
  EXPECT_TRUE(material["pbrMetallicRoughness"].contains("baseColorTexture"));
  ASSERT_EQ(glb.tree["images"].size(), 1U) << "one texture for all hair";
  EXPECT_EQ(glb.tree["images"][0]["mimeType"], "image/png");
  EXPECT_EQ(glb.tree["samplers"][0]["wrapS"], 10497) << "ribbons go on beyond one unit";

  // Two triangles go with the smile and stay in the face's mesh; all come back as what they were.
  const auto back = face::parse_gltf(content, "ball.glb").value().face;
  EXPECT_EQ(back.triangles.size(), face.triangles.size());
  std::uint32_t strands = 0;
  for (const face::Part& part : back.parts)
    if (part.material == face::Material::strands) strands += part.triangle_count;
  EXPECT_EQ(strands, 4U);
  ASSERT_EQ(back.uv.size(), back.neutral_m.size());
  float widest = 0;
  for (const auto& uv : back.uv) widest = std::max(widest, uv.x());
  EXPECT_EQ(widest, 0.25F);
  ASSERT_EQ(back.colour.size(), back.neutral_m.size()) << "colours of vertices are read";
  for (const face::Part& part : back.parts) {
    if (part.material != face::Material::strands) continue;
    const std::uint32_t vertex = back.triangles[part.first_triangle][0];
    EXPECT_LT((back.colour[vertex] - face.colour.back()).norm(), 1e-4F) << "hair is as dark as it was";
  }
}

TEST(Gltf, PlaysTheMotionAtSixtyFramesASecond) {
  const face::Face face = ball_face();
  const face::Motion motion = nod(1.0);
  const Glb glb = open(encode_gltf(face, &motion, GltfKind::binary).value());
  const json& animation = glb.tree["animations"][0];
  EXPECT_EQ(animation["name"], "nod");
  const auto track = [&](const std::string& node, const std::string& path) -> std::vector<float> {
    for (const json& channel : animation["channels"])
      if (glb.tree["nodes"][channel["target"]["node"].get<std::size_t>()]["name"] == node &&
          channel["target"]["path"] == path)
        return floats(
            glb, animation["samplers"][channel["sampler"].get<std::size_t>()]["output"].get<std::size_t>());
    return {};
  };
  const auto times = floats(glb, animation["samplers"][0]["input"].get<std::size_t>());
  ASSERT_EQ(times.size(), 61U);
  EXPECT_FLOAT_EQ(times[30], 0.5F);

  const face::MotionCurve curve(motion);
  const auto weights = track("face", "weights");
  ASSERT_EQ(weights.size(), 61 * face.shapes.size());
  EXPECT_FLOAT_EQ(weights[37 * face.shapes.size() + face::shape("jawOpen")],
                  curve.at(37.0 / 60).weights[face::shape("jawOpen")]);
  const auto head = track("head", "rotation");
  ASSERT_EQ(head.size(), 4 * 61U);
  EXPECT_NEAR(head[4 * 30], std::sin(0.15 * std::sin(1.0)), 1e-3);
  // Up is a turn about -X; the left eye rests.
  EXPECT_NEAR(track("eye_R", "rotation")[0], std::sin(-0.5 * 0.611 * 0.5), 1e-6);
  EXPECT_FLOAT_EQ(track("eye_L", "rotation")[3], 1);
}

TEST(Gltf, NamesItsTargetsAndBoundsItsPositions) {
  const face::Face face = ball_face();
  const Glb glb = open(encode_gltf(face, nullptr, GltfKind::binary).value());
  const json& mesh = glb.tree["meshes"][0];
  ASSERT_EQ(mesh["extras"]["targetNames"].size(), face.shapes.size());
  EXPECT_EQ(mesh["extras"]["targetNames"][face::shape("jawOpen")], "jawOpen");
  const json& position =
      glb.tree["accessors"][mesh["primitives"][0]["attributes"]["POSITION"].get<std::size_t>()];
  EXPECT_NEAR(position["min"][1].get<double>(), -0.1, 1e-6);
  EXPECT_NEAR(position["max"][1].get<double>(), 0.1, 1e-6);
  EXPECT_FALSE(glb.tree.contains("animations"));
}

TEST(Gltf, HasApplesNamesAndTheirWeights) {
  const face::Face face = ball_face();
  face::Motion motion = nod(0.1);
  for (face::MotionFrame& frame : motion.frames) frame.weights[face::shape("cheekPuff_L")] = 0.5F;
  const Glb glb = open(encode_gltf(face, &motion, GltfKind::binary, GltfNames::arkit).value());
  const json& names = glb.tree["meshes"][0]["extras"]["targetNames"];
  EXPECT_EQ(names.get<std::vector<std::string>>(), face::arkit52().shapes);
  EXPECT_EQ(glb.tree["meshes"][0]["primitives"][0]["targets"].size(), 52U);
  const json& animation = glb.tree["animations"][0];
  const auto weights =
      floats(glb, animation["samplers"][animation["channels"][0]["sampler"].get<std::size_t>()]["output"]
                      .get<std::size_t>());
  const auto puff = static_cast<std::size_t>(std::ranges::find(face::arkit52().shapes, "cheekPuff") -
                                             face::arkit52().shapes.begin());
  EXPECT_FLOAT_EQ(weights[puff], 0.25F) << "the mean of both sides";
  const auto head =
      face::parse_gltf(encode_gltf(face, nullptr, GltfKind::binary, GltfNames::arkit).value(), "ball.glb");
  ASSERT_TRUE(head);
  EXPECT_NEAR(peak_displacement_m(head->face, "mouthSmile_L"), peak_displacement_m(face, "mouthSmile_L"),
              1e-7);
}

TEST(Gltf, IsAnAvatarByVrm) {
  const face::Face face = ball_face();
  face::Motion motion = nod(0.1);
  for (face::MotionFrame& frame : motion.frames) frame.head_position_m = Vec3(0.01, 0, 0);
  const Glb glb = open(encode_gltf(face, &motion, GltfKind::binary, GltfNames::vrm).value());
  EXPECT_EQ(glb.tree["extensionsUsed"], json::array({"VRMC_vrm"}));
  const json& vrm = glb.tree["extensions"]["VRMC_vrm"];
  EXPECT_EQ(vrm["specVersion"], "1.0");
  EXPECT_EQ(vrm["meta"]["licenseUrl"], "https://vrm.dev/licenses/1.0/");
  EXPECT_FALSE(vrm["meta"].contains("allowRedistribution")) << "nobody said whose this face is";

  // Each bone is a node of its own below its parent, the head where a neck ends.
  const json& bones = vrm["humanoid"]["humanBones"];
  const json& nodes = glb.tree["nodes"];
  const auto parent = [&](std::size_t node) {
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (const json& child : nodes[i].value("children", json::array()))
        if (child == node) return i;
    return nodes.size();
  };
  for (const char* bone : {"hips", "spine", "head", "leftUpperLeg", "leftLowerLeg", "leftFoot",
                           "rightUpperLeg", "rightLowerLeg", "rightFoot", "leftUpperArm", "leftLowerArm",
                           "leftHand", "rightUpperArm", "rightLowerArm", "rightHand", "leftEye", "rightEye"})
    ASSERT_TRUE(bones.contains(bone)) << bone;
  std::set<std::size_t> distinct;
  for (const auto& [name, bone] : bones.items()) distinct.insert(bone["node"].get<std::size_t>());
  EXPECT_EQ(distinct.size(), bones.size());
  for (const auto& [bone, above] : std::map<std::string, std::string>{{"leftLowerArm", "leftUpperArm"},
                                                                      {"rightHand", "rightLowerArm"},
                                                                      {"leftUpperLeg", "hips"},
                                                                      {"rightFoot", "rightLowerLeg"},
                                                                      {"spine", "hips"}})
    EXPECT_EQ(parent(bones[bone]["node"].get<std::size_t>()), bones[above]["node"].get<std::size_t>())
        << bone;
  double height_m = 0;
  std::size_t node = bones["head"]["node"].get<std::size_t>();
  for (; node < nodes.size(); node = parent(node))
    if (nodes[node].contains("translation")) height_m += nodes[node]["translation"][1].get<double>();
  EXPECT_NEAR(height_m, 1.58, 1e-5);
  EXPECT_EQ(parent(bones["leftEye"]["node"].get<std::size_t>()), bones["head"]["node"].get<std::size_t>());

  // Expressions bind targets that are there: ARKit's each for itself, VRM's own as sums.
  const json& expressions = vrm["expressions"];
  EXPECT_EQ(expressions["custom"].size(), 52U);
  EXPECT_TRUE(expressions["custom"].contains("EyeBlinkLeft"));
  // Every shape of a preset is a target that is there, both sides of one without a side.
  const std::map<std::string, std::size_t> binds = {
      {"aa", 5},       {"ih", 5},        {"ou", 3},         {"ee", 7},     {"oh", 3},
      {"blink", 2},    {"blinkLeft", 1}, {"blinkRight", 1}, {"happy", 6},  {"angry", 10},
      {"sad", 4},      {"relaxed", 4},   {"surprised", 6},  {"lookUp", 2}, {"lookDown", 2},
      {"lookLeft", 2}, {"lookRight", 2}, {"neutral", 0}};
  EXPECT_EQ(expressions["preset"].size(), binds.size());
  for (const auto& [name, count] : binds)
    EXPECT_EQ(expressions["preset"][name].value("morphTargetBinds", json::array()).size(), count) << name;
  for (const char* kind : {"preset", "custom"})
    for (const auto& [name, expression] : expressions[kind].items())
      for (const json& bound : expression.value("morphTargetBinds", json::array())) {
        const json& owner = nodes[bound["node"].get<std::size_t>()];
        EXPECT_LT(bound["index"].get<std::size_t>(),
                  glb.tree["meshes"][owner["mesh"].get<std::size_t>()]["extras"]["targetNames"].size());
        EXPECT_GT(bound["weight"].get<double>(), 0) << name;
      }
  EXPECT_EQ(vrm["lookAt"]["type"], "bone");
  EXPECT_NEAR(vrm["lookAt"]["offsetFromHeadBone"][2].get<double>(), 0.085, 1e-6);

  // A motion moves the head from its place on the neck.
  std::size_t translations = 0;
  for (const json& channel : glb.tree["animations"][0]["channels"]) {
    if (channel["target"]["path"] != "translation") continue;
    ++translations;
    const auto moved =
        floats(glb, glb.tree["animations"][0]["samplers"][channel["sampler"].get<std::size_t>()]["output"]
                        .get<std::size_t>());
    EXPECT_FLOAT_EQ(moved[0], 0.01F);
    EXPECT_NEAR(moved[1], 0.13, 1e-5);
  }
  EXPECT_EQ(translations, 1U);
}

TEST(Gltf, AnAvatarsHeadSitsOnItsNeckWhereverTheFaceStood) {
  const auto place = [](const face::Face& face) {
    const Glb glb = open(encode_gltf(face, nullptr, GltfKind::binary, GltfNames::vrm).value());
    const json& vrm = glb.tree["extensions"]["VRMC_vrm"];
    return std::pair(glb.tree["nodes"][vrm["humanoid"]["humanBones"]["leftEye"]["node"].get<std::size_t>()]
                             ["translation"][1]
                                 .get<double>(),
                     vrm["lookAt"]["offsetFromHeadBone"][1].get<double>());
  };
  const face::Face face = ball_face();
  face::Face higher = face;
  for (Vec3f& vertex : higher.neutral_m) vertex.y() += 1.4F;
  for (face::Eyeball& eye : higher.eyes) eye.centre_m.y() += 1.4F;
  EXPECT_NEAR(place(higher).first, place(face).first, 1e-5);
  EXPECT_NEAR(place(higher).second, place(face).second, 1e-5);

  face::Face body = face;
  for (Vec3f& vertex : body.neutral_m) vertex *= 8;
  const auto refused = encode_gltf(body, nullptr, GltfKind::binary, GltfNames::vrm);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::bad_usage);
  EXPECT_EQ(encode_gltf(face, nullptr, GltfKind::text, GltfNames::vrm).error().code, ErrorCode::bad_usage);
}

TEST(Gltf, AnAvatarWhoseEyesAreShapesLooksByExpressions) {
  face::Face face = ball_face();
  face.eyes = {};
  const Glb glb = open(encode_gltf(face, nullptr, GltfKind::binary, GltfNames::vrm).value());
  const json& look = glb.tree["extensions"]["VRMC_vrm"]["lookAt"];
  EXPECT_EQ(look["type"], "expression");
  EXPECT_FALSE(look.contains("offsetFromHeadBone")) << "nobody knows where its eyes are";
  EXPECT_EQ(look["rangeMapVerticalUp"]["outputScale"], 1.0);
}

TEST(Gltf, IsTheSameEveryTimeInBothKinds) {
  const face::Face face = ball_face();
  const face::Motion motion = nod(0.3);
  EXPECT_EQ(encode_gltf(face, &motion, GltfKind::binary).value(),
            encode_gltf(face, &motion, GltfKind::binary).value());
  const auto text = encode_gltf(face, &motion, GltfKind::text).value();
  const json tree = json::parse(std::string(reinterpret_cast<const char*>(text.data()), text.size()));
  const Glb glb = open(encode_gltf(face, &motion, GltfKind::binary).value());
  EXPECT_EQ(tree["buffers"][0]["uri"], "data:application/octet-stream;base64," + base64(glb.buffer));
  EXPECT_EQ(tree["accessors"], glb.tree["accessors"]);
}

TEST(Gltf, RefusesWhatNoReaderCouldShow) {
  const face::Face good = ball_face();
  const auto code = [](const face::Face& face, const face::Motion* motion = nullptr) {
    return encode_gltf(face, motion, GltfKind::binary).error().code;
  };
  EXPECT_EQ(code(face::Face{}), ErrorCode::bad_usage);
  face::Face face = good;
  face.neutral_m[3].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(code(face), ErrorCode::out_of_range);
  face = good;
  face.triangles[2][1] = 1'000'000;
  EXPECT_EQ(code(face), ErrorCode::malformed);
  face = good;
  face.shapes[face::shape("jawOpen")].vertex.back() = 1'000'000;
  EXPECT_EQ(code(face), ErrorCode::malformed);
  face = good;
  face.shapes[face::shape("jawOpen")].delta_m[0].y() = std::numeric_limits<float>::infinity();
  EXPECT_EQ(code(face), ErrorCode::out_of_range);
  face = good;
  face.colour.resize(3);
  EXPECT_EQ(code(face), ErrorCode::malformed);
  face = good;
  face.uv.resize(3);
  EXPECT_EQ(code(face), ErrorCode::malformed);
  const face::Motion empty;
  EXPECT_EQ(code(good, &empty), ErrorCode::bad_usage);
  EXPECT_EQ(write_gltf("face.obj", good, nullptr).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(write_gltf("face.vrm", good, nullptr).error().code, ErrorCode::bad_usage) << "no avatar";
}

}  // namespace
}  // namespace mien::render::gltf_export_test
