#include "mien/headset/feature_record.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "mien/sensor/payload.h"
#include "tests/hex.h"

namespace mien::headset::feature_record_test {
namespace {

using Bytes = std::vector<std::byte>;

FeatureRecord record_of(std::optional<std::uint16_t> sensor) {
  FeatureRecord record;
  record.statistics = {.mean = 0.5F,
                       .saturated = 0.25F,
                       .black = 0,
                       .sharpness = 1.5F,
                       .p2 = 0.125F,
                       .p98 = 1,
                       .hash = 0x0102030405060708U};
  record.jpeg_bytes = 4400;
  record.sensor = sensor;
  return record;
}

Bytes bytes_of(const FeatureRecord& record, const std::vector<float>& features) {
  Bytes out(1000);
  const auto size = write_feature_record(record, features, out);
  EXPECT_TRUE(size);
  out.resize(size.value_or(0));
  return out;
}

TEST(FeatureRecord, ReadsWhatItWrites) {
  const std::vector<float> features = {1.0F, -2.5F, 0.0F};
  for (const auto& [sensor, numbers] : {std::pair(std::optional<std::uint16_t>(3), features),
                                        std::pair(std::optional<std::uint16_t>(), std::vector<float>())}) {
    const Bytes bytes = bytes_of(record_of(sensor), numbers);
    EXPECT_EQ(bytes.size(), feature_record_bytes(numbers.size()));
    EXPECT_TRUE(is_feature_record(bytes));
    const auto back = parse_feature_record(bytes);
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(back->statistics, record_of(sensor).statistics);
    EXPECT_EQ(back->jpeg_bytes, 4400U);
    EXPECT_EQ(back->sensor, sensor);
    ASSERT_EQ(back->count(), numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) EXPECT_EQ(back->feature(i), numbers[i]);
  }
}

// docs/reference/take.md has these bytes.
TEST(FeatureRecord, HasTheBytesThatTheDocsShow) {
  EXPECT_EQ(hex(bytes_of(record_of(3), {1.0F, -2.5F})),
            "4d4e4652"
            "01"
            "00"
            "0300"
            "02000000"
            "30110000"
            "0000003f"
            "0000803e"
            "00000000"
            "0000c03f"
            "0000003e"
            "0000803f"
            "0807060504030201"
            "0000803f"
            "000020c0");
}

TEST(FeatureRecord, RefusesWhatNoReducerWrites) {
  const Bytes sound = bytes_of(record_of(3), {1.0F, -2.5F});
  const auto refused = [&](std::size_t at, std::vector<unsigned> values, ErrorCode code) {
    Bytes bytes = sound;
    for (std::size_t i = 0; i < values.size(); ++i) bytes[at + i] = static_cast<std::byte>(values[i]);
    const auto parsed = parse_feature_record(bytes);
    return !parsed && parsed.error().code == code;
  };
  EXPECT_TRUE(refused(0, {0xFF, 0xD8}, ErrorCode::malformed));
  EXPECT_TRUE(refused(4, {2}, ErrorCode::unsupported));
  EXPECT_TRUE(refused(5, {1}, ErrorCode::malformed));
  EXPECT_TRUE(refused(6, {0, 1}, ErrorCode::out_of_range)) << "a rig has 256 sensors";
  EXPECT_TRUE(refused(6, {0xFF, 0xFF}, ErrorCode::malformed)) << "features of no camera";
  EXPECT_TRUE(refused(8, {3}, ErrorCode::malformed)) << "a length that lies";
  EXPECT_TRUE(refused(8, {0xFF, 0xFF, 0xFF, 0xFF}, ErrorCode::malformed));
  EXPECT_TRUE(refused(12, {0, 0, 0, 0}, ErrorCode::out_of_range)) << "a picture without bytes";
  EXPECT_TRUE(refused(12, {0, 0, 0, 1}, ErrorCode::out_of_range));
  EXPECT_TRUE(refused(16, {0, 0, 0xC0, 0x7F}, ErrorCode::out_of_range)) << "NaN";
  EXPECT_TRUE(refused(16, {0, 0, 0, 0x40}, ErrorCode::out_of_range)) << "a share of 2";
  EXPECT_TRUE(refused(28, {0, 0, 0x80, 0x7F}, ErrorCode::out_of_range)) << "infinitely sharp";
  EXPECT_TRUE(refused(52, {0, 0, 0x80, 0x7F}, ErrorCode::out_of_range)) << "a feature";
  for (std::size_t size = 0; size < sound.size(); ++size)
    EXPECT_FALSE(parse_feature_record(std::span(sound).first(size))) << size;
  Bytes longer = sound;
  longer.push_back({});
  EXPECT_FALSE(parse_feature_record(longer));
}

TEST(FeatureRecord, WritesNothingThatItDoesNotRead) {
  Bytes out(1000);
  const std::vector<float> features = {1.0F};
  EXPECT_TRUE(write_feature_record(record_of(3), features, out));
  EXPECT_FALSE(write_feature_record(record_of({}), features, out));
  EXPECT_FALSE(write_feature_record(record_of(3), {}, out));
  EXPECT_FALSE(write_feature_record(record_of(256), features, out));
  EXPECT_FALSE(write_feature_record(record_of(3), features, std::span(out).first(51)));
  EXPECT_FALSE(
      write_feature_record(record_of(3), std::vector<float>{std::numeric_limits<float>::quiet_NaN()}, out));
  Bytes large(1U << 20U);
  EXPECT_FALSE(write_feature_record(record_of(3), std::vector<float>(kMostFeatures + 1), large));
  FeatureRecord record = record_of(3);
  record.jpeg_bytes = sensor::kMaxPayload + 1;
  EXPECT_FALSE(write_feature_record(record, features, out));
}

}  // namespace
}  // namespace mien::headset::feature_record_test
