#include "mien/gaze/osc.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "mien/core/random.h"
#include "mien/gaze/osc_eyes.h"
#include "tests/gaze/osc_bytes.h"

namespace mien::gaze::osc_test {
namespace {

using test::bundle;
using test::message;

const SaidOfEye& said(const OscEyes& eyes, Dialect dialect, std::size_t eye) {
  return eyes.said[static_cast<std::size_t>(dialect)][eye];
}

/// What one message says, of both eyes.
OscEyes parsed(const std::string& address, const std::vector<float>& numbers) {
  const auto eyes = parse_osc_eyes(message(address, numbers));
  EXPECT_TRUE(eyes) << address << ": " << (eyes ? "" : eyes.error().message());
  return eyes.value_or(OscEyes());
}

struct Counter final : OscListener {
  Result<void> hear(const OscMessage& one) override {
    ++messages;
    last = one;
    return {};
  }
  int messages = 0;
  OscMessage last;
};

TEST(Osc, ReadsEveryTypeThatOscHas) {
  ByteWriter out;
  test::write_text("/all", out);
  test::write_text(",ifhdsSbtcrmTFNI[]", out);
  out.big(std::int32_t{-7});
  out.big(1.5F);
  out.big(std::int64_t{1} << 40U);
  out.big(0.25);
  test::write_text("text", out);
  test::write_text("", out);
  out.big(std::uint32_t{5});
  for (int i = 0; i < 8; ++i) out.little(std::uint8_t{9});
  out.big(std::uint64_t{1});
  for (int i = 0; i < 3; ++i) out.big(std::uint32_t{0});
  Counter counter;
  ASSERT_TRUE(read_osc(out.bytes(), counter));
  EXPECT_EQ(counter.last.count, 17U);
  EXPECT_FALSE(counter.last.numeric);
  EXPECT_EQ(counter.last.numbers[0], -7);
  EXPECT_EQ(counter.last.numbers[1], 1.5);
  EXPECT_EQ(counter.last.numbers[2], 1099511627776.0);
  EXPECT_EQ(counter.last.numbers[3], 0.25);
  for (std::size_t size = 0; size < out.bytes().size(); ++size)
    EXPECT_FALSE(read_osc(out.bytes().first(size), counter)) << size;
}

TEST(Osc, RefusesLengthsThatAreNotThere) {
  Counter counter;
  for (const std::uint32_t length : {0xFFFFFFFFU, 0xFFFFFFFDU, 0x80000000U, 9U}) {
    ByteWriter blob;
    test::write_text("/b", blob);
    test::write_text(",b", blob);
    blob.big(length);
    blob.big(std::uint64_t{0});
    EXPECT_EQ(read_osc(blob.bytes(), counter).error().code, ErrorCode::truncated) << length;
    ByteWriter element;
    test::write_text("#bundle", element);
    element.big(std::uint64_t{1});
    element.big(length);
    element.append(message("/x", {}));
    EXPECT_EQ(read_osc(element.bytes(), counter).error().code, ErrorCode::truncated) << length;
  }
  // A string that goes on to the end and beyond.
  const std::vector<std::byte> endless(64, std::byte{'/'});
  EXPECT_EQ(read_osc(endless, counter).error().code, ErrorCode::truncated);
  EXPECT_EQ(counter.messages, 0);
}

TEST(Osc, RefusesBundlesThatAreTooDeep) {
  std::vector<std::byte> nested = message("/x", {});
  Counter counter;
  for (int depth = 1; depth <= 100; ++depth) {
    nested = bundle({nested});
    const auto read = read_osc(nested, counter);
    EXPECT_EQ(read.has_value(), depth <= kMostBundles) << depth;
    if (!read) {
      EXPECT_EQ(read.error().code, ErrorCode::malformed);
    }
  }
  EXPECT_EQ(counter.messages, kMostBundles);
}

TEST(Osc, RefusesWhatIsNotOsc) {
  Counter counter;
  ByteWriter no_tags, unknown_tag, no_slash, more;
  test::write_text("/x", no_tags);
  test::write_text("f", no_tags);
  test::write_text("/x", unknown_tag);
  test::write_text(",q", unknown_tag);
  test::write_text("x", no_slash);
  test::write_text(",", no_slash);
  more.append(message("/x", {1}));
  more.big(std::uint32_t{0});
  for (const ByteWriter* one : {&no_tags, &unknown_tag, &no_slash, &more})
    EXPECT_EQ(read_osc(one->bytes(), counter).error().code, ErrorCode::malformed);
  EXPECT_EQ(counter.messages, 0);
}

TEST(OscEyes, NativeVectorsAreDirections) {
  // Right, up, ahead: the left eye 45 degrees to the right, the right eye straight up by atan(0.5).
  const OscEyes eyes = parsed("/tracking/eye/LeftRightVec", {1, 0, 1, 0, 0.5F, 1});
  EXPECT_FLOAT_EQ(*said(eyes, Dialect::native, 0).yaw_rad, -0.78539816F);
  EXPECT_EQ(*said(eyes, Dialect::native, 0).pitch_rad, 0);
  EXPECT_EQ(*said(eyes, Dialect::native, 1).yaw_rad, 0);
  EXPECT_FLOAT_EQ(*said(eyes, Dialect::native, 1).pitch_rad, 0.46364760F);
  EXPECT_EQ(eyes.known, 1U);
  // Any length; one for both eyes.
  const OscEyes centre = parsed("/tracking/eye/CenterVecFull", {0, -0.2F, 0.2F});
  EXPECT_FLOAT_EQ(*said(centre, Dialect::native, 1).pitch_rad, -0.78539816F);
}

TEST(OscEyes, NativeDegreesPointDownAndRight) {
  const OscEyes eyes = parsed("/tracking/eye/LeftRightPitchYaw", {10, 20, -30, -40});
  EXPECT_FLOAT_EQ(*said(eyes, Dialect::native, 0).pitch_rad, -0.17453293F);
  EXPECT_FLOAT_EQ(*said(eyes, Dialect::native, 0).yaw_rad, -0.34906585F);
  EXPECT_FLOAT_EQ(*said(eyes, Dialect::native, 1).pitch_rad, 0.52359878F);
  EXPECT_FLOAT_EQ(*said(eyes, Dialect::native, 1).yaw_rad, 0.69813170F);
  EXPECT_FLOAT_EQ(*said(parsed("/tracking/eye/EyesClosedAmount", {0.25F}), Dialect::native, 0).openness,
                  0.75F);
}

TEST(OscEyes, ParametersOfBothGenerationsAndOfBaballonia) {
  // A coordinate of 0.5 is atan(0.5); x is to the right.
  constexpr float kHalf = 0.46364760F;
  for (const char* address : {"/avatar/parameters/v2/EyeLeftX", "/avatar/parameters/FT/v2/EyeLeftX"}) {
    const OscEyes eyes = parsed(address, {0.5F});
    EXPECT_FLOAT_EQ(*said(eyes, Dialect::v2, 0).yaw_rad, -kHalf);
    EXPECT_EQ(said(eyes, Dialect::v2, 1), SaidOfEye());
  }
  EXPECT_FLOAT_EQ(*said(parsed("/avatar/parameters/v2/EyeRightY", {0.5F}), Dialect::v2, 1).pitch_rad, kHalf);
  EXPECT_FLOAT_EQ(*said(parsed("/avatar/parameters/v2/EyeLidLeft", {0.375F}), Dialect::v2, 0).openness, 0.5F);
  EXPECT_EQ(*said(parsed("/avatar/parameters/v2/EyeLidLeft", {1}), Dialect::v2, 0).openness, 1);
  EXPECT_FLOAT_EQ(*said(parsed("/avatar/parameters/v2/PupilDiameterRight", {0.4F}), Dialect::v2, 1).pupil_mm,
                  4);
  EXPECT_FLOAT_EQ(*said(parsed("/avatar/parameters/LeftEyeX", {-0.5F}), Dialect::v1, 0).yaw_rad, kHalf);
  const OscEyes both = parsed("/avatar/parameters/EyesY", {-0.5F});
  EXPECT_FLOAT_EQ(*said(both, Dialect::v1, 0).pitch_rad, -kHalf);
  EXPECT_FLOAT_EQ(*said(both, Dialect::v1, 1).pitch_rad, -kHalf);
  const std::string lid = "/avatar/parameters/RightEyeLidExpandedSqueeze";
  EXPECT_FLOAT_EQ(*said(parsed(lid, {0.4F}), Dialect::v1, 1).openness, 0.5F);
  EXPECT_EQ(*said(parsed(lid, {-1}), Dialect::v1, 1).openness, 0);
  EXPECT_FLOAT_EQ(*said(parsed("/leftEyeX", {0.5F}), Dialect::baballonia, 0).yaw_rad, -kHalf);
  EXPECT_FLOAT_EQ(*said(parsed("/RightEyeLid", {0.25F}), Dialect::baballonia, 1).openness, 0.25F);
}

TEST(OscEyes, OtherAddressesAreCountedAndNoErrors) {
  ByteWriter word;
  test::write_text("/avatar/change", word);
  test::write_text(",s", word);
  test::write_text("avtr", word);
  const auto eyes = parse_osc_eyes(bundle({word.release(), message("/avatar/parameters/v2/JawOpen", {0.5F}),
                                           message("/avatar/parameters/v2/EyeLeftX", {0}),
                                           message("/avatar/parameters/xv2/EyeLeftX", {0})}));
  ASSERT_TRUE(eyes);
  EXPECT_EQ(eyes->known, 1U);
  EXPECT_EQ(eyes->unknown, 3U);
}

TEST(OscEyes, RefusesWrongTypesAndNumbers) {
  ByteWriter text;
  test::write_text("/avatar/parameters/v2/EyeLeftX", text);
  test::write_text(",s", text);
  test::write_text("0.5", text);
  EXPECT_EQ(parse_osc_eyes(text.bytes()).error().code, ErrorCode::malformed);
  const auto code = [](const char* address, const std::vector<float>& numbers) {
    return parse_osc_eyes(message(address, numbers)).error().code;
  };
  EXPECT_EQ(code("/avatar/parameters/v2/EyeLeftX", {}), ErrorCode::malformed);
  EXPECT_EQ(code("/avatar/parameters/v2/EyeLeftX", {0, 0}), ErrorCode::malformed);
  EXPECT_EQ(code("/tracking/eye/LeftRightVec", {0, 0, 1}), ErrorCode::malformed);
  EXPECT_EQ(code("/tracking/eye/LeftRightPitchYaw", {0, 91, 0, 0}), ErrorCode::out_of_range);
  EXPECT_EQ(code("/LeftEyeX", {std::numeric_limits<float>::quiet_NaN()}), ErrorCode::out_of_range);
  EXPECT_EQ(code("/LeftEyeX", {std::numeric_limits<float>::infinity()}), ErrorCode::out_of_range);
}

TEST(OscEyes, WhatNoEyeCanDoSaysThatItIsNotSeen) {
  EXPECT_TRUE(said(parsed("/avatar/parameters/v2/EyeLeftY", {621}), Dialect::v2, 0).lost[1]);
  EXPECT_FALSE(said(parsed("/avatar/parameters/v2/EyeLeftY", {1}), Dialect::v2, 0).lost[1]);
  const OscEyes eyes = parsed("/tracking/eye/LeftRightVec", {0, 621, 1, 0, 0, 1});
  EXPECT_TRUE(said(eyes, Dialect::native, 0).lost[0]);
  EXPECT_FALSE(said(eyes, Dialect::native, 1).lost[0]);
  EXPECT_TRUE(said(parsed("/tracking/eye/CenterVec", {0, 0, -1}), Dialect::native, 0).lost[0]);
}

TEST(OscEyes, RandomBytesBehindAnAddressNeverHarm) {
  Random random(3);
  const auto head = message("/tracking/eye/LeftRightVec", {});
  for (int i = 0; i < 20'000; ++i) {
    std::vector<std::byte> bytes(random.below(120));
    for (auto& b : bytes) b = std::byte{static_cast<unsigned char>(random.bits() & 255U)};
    std::copy_n(head.begin(), std::min(bytes.size(), head.size()), bytes.begin());
    static_cast<void>(parse_osc_eyes(bytes));
  }
}

}  // namespace
}  // namespace mien::gaze::osc_test
