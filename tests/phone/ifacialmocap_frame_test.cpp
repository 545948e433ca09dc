#include "mien/phone/ifacialmocap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <string_view>

#include "mien/face/profile.h"

namespace mien::phone::test::ifacialmocap_frame_test {
namespace {

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text));
}

ErrorCode refusal(std::string_view text) {
  const auto parsed = parse_ifacialmocap(bytes_of(text));
  return parsed ? ErrorCode::internal : parsed.error().code;
}

float weight(const IFacialMocapFrame& frame, std::string_view name) {
  return frame.face.weights[face::arkit_index(name)];
}

TEST(IFacialMocapFrame, BothVersionsAreRead) {
  for (const char* text :
       {"trackingStatus&1|mouthSmile_R&25|jawLeft&5|tongueOut&100|=head#10,-20,5,0.1,0.2,-0.3|rightEye#1,2,0|"
        "leftEye#1,2,0|",
        "mouthSmile_R-25|jawLeft-5|tongueOut-100|=head#10,-20,5,0.1,0.2,-0.3|rightEye#1,2,0|leftEye#1,2,0|",
        "mouthSmileRight&25|jawLeft&5|tongueOut&100|head#10,-20,5,0.1,0.2,-0.3|"}) {
    ASSERT_TRUE(is_ifacialmocap(bytes_of(text))) << text;
    const auto frame = parse_ifacialmocap(bytes_of(text));
    ASSERT_TRUE(frame) << text << frame.error().message();
    EXPECT_TRUE(frame->tracked);
    EXPECT_TRUE(is_sound(frame->face));
    EXPECT_EQ(frame->face.told(), 3U);
    EXPECT_EQ(weight(*frame, "mouthSmileRight"), 0.25F);
    EXPECT_EQ(weight(*frame, "jawLeft"), 0.05F);
    EXPECT_EQ(weight(*frame, "tongueOut"), 1);
    EXPECT_EQ(weight(*frame, "jawOpen"), kUntold);
    ASSERT_TRUE(frame->face.head);
    EXPECT_TRUE(frame->face.head->position_known);
    EXPECT_FLOAT_EQ(frame->face.head->position_m.z(), -0.3F);
  }
}

TEST(IFacialMocapFrame, AHeadAt0HasNoPlace) {
  const auto frame = parse_ifacialmocap(bytes_of("jawOpen&5|=head#0,0,0,0,0,0|"));
  ASSERT_TRUE(frame && frame->face.head);
  EXPECT_FALSE(frame->face.head->position_known);
}

TEST(IFacialMocapFrame, ItsPhoneMaySeeNoFace) {
  const auto frame = parse_ifacialmocap(bytes_of("trackingStatus&0|jawOpen&5|"));
  ASSERT_TRUE(frame);
  EXPECT_FALSE(frame->tracked);
  EXPECT_TRUE(parse_ifacialmocap(bytes_of("trackingStatus&0|")));
}

TEST(IFacialMocapFrame, WhatItDoesNotKnowIsPassedOverAndWhatIsBeyondIsHeld) {
  const auto frame = parse_ifacialmocap(
      bytes_of("browInnerUp_L&7|jawOpen&130|eyeBlink_L&-3|earWiggle&99|what|fm3_x&1|ts:5|"));
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->face.told(), 2U);
  EXPECT_EQ(weight(*frame, "jawOpen"), 1);
  EXPECT_EQ(weight(*frame, "eyeBlinkLeft"), 0);
}

TEST(IFacialMocapFrame, DamageIsRefused) {
  EXPECT_EQ(refusal(""), ErrorCode::malformed);
  EXPECT_EQ(refusal("|||"), ErrorCode::malformed);
  EXPECT_EQ(refusal("earWiggle&99|"), ErrorCode::malformed);
  EXPECT_EQ(refusal("what|3&4|"), ErrorCode::malformed);
  EXPECT_EQ(refusal("jawOpen&5|=head#1,2,3|"), ErrorCode::malformed);
  EXPECT_EQ(refusal("jawOpen&5|=head#1,2,3,4,5,6,7|"), ErrorCode::malformed);
  EXPECT_EQ(refusal("jawOpen&nan|"), ErrorCode::out_of_range);
  EXPECT_EQ(refusal("jawOpen&inf|"), ErrorCode::out_of_range);
  EXPECT_EQ(refusal("jawOpen&|"), ErrorCode::out_of_range);
  EXPECT_EQ(refusal("jawOpen&1e9|"), ErrorCode::out_of_range);
  EXPECT_EQ(refusal("jawOpen&5|=head#0,0,0,1000,0,0|"), ErrorCode::out_of_range);
  EXPECT_EQ(refusal(std::string(3000, '|')), ErrorCode::out_of_range);
}

TEST(IFacialMocapFrame, OtherLanguagesAreNotTakenForIt) {
  for (const char* text :
       {"", "jawOpen", "jawOpen&5", "MNIM\x01-5|", "/tracking&1|", "12,13,14|", "jawOpen&x|",
        "{\"jawOpen\": 5}|", "iFacialMocap_sahuasouryya9218sauhuiayeta91555dy3719"})
    EXPECT_FALSE(is_ifacialmocap(bytes_of(text))) << text;
}

}  // namespace
}  // namespace mien::phone::test::ifacialmocap_frame_test
