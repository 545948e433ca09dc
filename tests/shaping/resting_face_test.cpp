#include "mien/shaping/resting_face.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mien::shaping::resting_face_test {
namespace {

using face::shape;

TEST(RestingFace, AppliesWhereTheUsualValueIsRest) {
  for (const char* name : {"browDown_L", "browInnerUp_R", "browOuterUp_L", "cheekPuff_R", "cheekSquint_L",
                           "noseSneer_R", "mouthSmile_L", "mouthFrown_R", "eyeWide_L", "eyeSquint_R"})
    EXPECT_EQ(kRestingRules[face::shape_index(name)], RestingRule::rest) << name;
  for (const char* name : {"jawOpen", "jawForward", "mouthClose", "mouthFunnel", "mouthPucker",
                           "mouthPress_L", "mouthLowerDown_R", "eyeLookDown_L"})
    EXPECT_EQ(kRestingRules[face::shape_index(name)], RestingRule::none) << name;
  EXPECT_EQ(kRestingRules[shape("eyeBlink_L")], RestingRule::lids);
  EXPECT_EQ(kRestingRules[shape("eyeBlink_R")], RestingRule::lids);
  // Left as right: a face is treated alike on both sides.
  for (std::size_t i = 0; i < face::kShapeCount; ++i) {
    std::string other(face::kShapeNames[i]);
    if (!other.ends_with("_L")) continue;
    other.back() = 'R';
    EXPECT_EQ(kRestingRules[i], kRestingRules[face::shape_index(other)]) << other;
  }
}

TEST(RestingFace, HasBothFormulas) {
  RestingFace face;
  face.rest[shape("browDown_L")] = 0.2F;  // (0.6 - 0.2) / 0.8 = 0.5
  EXPECT_FLOAT_EQ(face.applied(shape("browDown_L"), 0.6F), 0.5F);
  EXPECT_EQ(face.applied(shape("browDown_L"), 0.1F), 0);
  EXPECT_EQ(face.applied(shape("browDown_L"), 1), 1);
  face.rest[shape("eyeBlink_L")] = 0.3F;
  face.full[shape("eyeBlink_L")] = 0.8F;  // (0.5 - 0.3) / 0.5 = 0.4
  EXPECT_FLOAT_EQ(face.applied(shape("eyeBlink_L"), 0.5F), 0.4F);
  EXPECT_EQ(face.applied(shape("eyeBlink_L"), 0.8F), 1);
  EXPECT_EQ(face.applied(shape("eyeBlink_L"), 0.95F), 1);
  EXPECT_EQ(face.applied(shape("eyeBlink_L"), 0), 0);
  EXPECT_EQ(face.applied(shape("browDown_R"), 0.123F), 0.123F);
}

TEST(RestingFace, IsHeldToItsRanges) {
  RestingFace face;
  face.rest.fill(0.9F);
  face.full.fill(0.1F);
  face.rest[shape("noseSneer_L")] = std::nanf("");
  face.full[shape("eyeBlink_R")] = std::nanf("");
  const RestingFace held = face.within_range();
  EXPECT_EQ(held.rest[shape("browDown_L")], 0.5F);
  EXPECT_EQ(held.full[shape("browDown_L")], 1);
  EXPECT_EQ(held.rest[shape("noseSneer_L")], 0);
  EXPECT_EQ(held.rest[shape("eyeBlink_L")], 0.5F);
  EXPECT_EQ(held.full[shape("eyeBlink_L")], 0.75F);
  EXPECT_EQ(held.full[shape("eyeBlink_R")], 1);
  EXPECT_FALSE(held.changes(shape("jawOpen")));
}

TEST(RestingFace, GoesThroughJson) {
  RestingFace face;
  face.rest[shape("browInnerUp_L")] = 0.1F;
  face.rest[shape("eyeBlink_L")] = 0.37F;
  face.full[shape("eyeBlink_L")] = 0.37F + RestingFace::kLeastRange;
  EXPECT_EQ(parse_resting_face(write_resting_face(face), "test").value(), face);
  EXPECT_EQ(parse_resting_face("{}", "test").value(), RestingFace{});
}

TEST(RestingFace, RefusesWhatIsNone) {
  const auto code = [](const char* text) { return parse_resting_face(text, "test").error().code; };
  for (const char* text : {"", "[]", "{", R"({"rest": 1})", R"({"rest": {"noSuchShape": 0.1}})",
                           R"({"rest": {"browDown_L": null}})", R"({"full": []})", R"({"more": 1})",
                           R"({"rest": {"jawOpen": 0.1}})"})
    EXPECT_EQ(code(text), ErrorCode::malformed) << text;
  for (const char* text : {R"({"rest": {"browDown_L": 0.6}})", R"({"rest": {"browDown_L": -0.1}})",
                           R"({"full": {"browDown_L": 0.9}})", R"({"full": {"eyeBlink_L": 0.2}})",
                           R"({"full": {"eyeBlink_L": 1.1}})"})
    EXPECT_EQ(code(text), ErrorCode::out_of_range) << text;
}

}  // namespace
}  // namespace mien::shaping::resting_face_test
