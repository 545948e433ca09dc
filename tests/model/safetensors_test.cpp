#include "mien/model/safetensors.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "mien/core/bytes.h"

namespace mien::model::safetensors_test {
namespace {

std::vector<std::byte> file_of(const std::string& header, std::size_t data_bytes, std::uint64_t claimed = 0) {
  ByteWriter writer;
  writer.little(claimed != 0 ? claimed : static_cast<std::uint64_t>(header.size()));
  writer.append(header);
  for (std::size_t i = 0; i < data_bytes; ++i) writer.little(std::uint8_t{0});
  return writer.release();
}

void expect_refused(const std::string& header, std::size_t data_bytes, ErrorCode code,
                    std::uint64_t claimed = 0) {
  const auto parsed = parse_safetensors(file_of(header, data_bytes, claimed), "test");
  ASSERT_FALSE(parsed) << header;
  EXPECT_EQ(parsed.error().code, code) << header << " " << parsed.error().message();
  EXPECT_EQ(parsed.error().where, "test");
}

TEST(Safetensors, RoundTripsExactly) {
  const TensorFile file{.tensors = {{.name = "b", .shape = {2, 3}, .values = {1, -2, 3.5F, 1e-30F, 0, -0.0F}},
                                    {.name = "a", .shape = {}, .values = {7}},
                                    {.name = "empty", .shape = {0, 4}, .values = {}}},
                        .metadata = {{"text", "two\nlines \"quoted\""}, {"empty", ""}}};
  const auto bytes = write_safetensors(file);
  EXPECT_EQ(bytes, write_safetensors(file));
  const auto back = parse_safetensors(bytes, "test");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->metadata, file.metadata);
  ASSERT_EQ(back->tensors.size(), 3U);
  EXPECT_EQ(back->tensors[0], file.tensors[0]);
  EXPECT_EQ(back->tensors[1], file.tensors[1]);
}

TEST(Safetensors, Bf16RoundsToNearestEven) {
  // 1 + 2^-8 lies halfway between two bf16 numbers and goes to the even one; 1 + 3 * 2^-8 likewise, upwards.
  const TensorFile file{
      .tensors = {{.name = "x", .shape = {4}, .values = {1.00390625F, 1.01171875F, -3.140625F, 0}}},
      .metadata = {}};
  const auto back = parse_safetensors(write_safetensors(file, TensorType::bf16), "test");
  ASSERT_TRUE(back);
  EXPECT_EQ(back->tensors[0].values, (std::vector<float>{1.0F, 1.015625F, -3.140625F, 0}));
}

TEST(Safetensors, ReadsHeadersWithSpacesAndAnyOrder) {
  const auto parsed = parse_safetensors(
      file_of(
          R"({"y":{"data_offsets":[4,8],"shape":[1],"dtype":"F32"},"x":{"dtype":"BF16","shape":[1,2],"data_offsets":[0,4]}}   )",
          8),
      "test");
  ASSERT_TRUE(parsed) << parsed.error().message();
  EXPECT_EQ(parsed->tensors[0].name, "x");
  EXPECT_EQ(parsed->tensors[1].name, "y");
}

TEST(Safetensors, RefusesWhatTheFormatForbids) {
  const auto x = [](const std::string& rest) { return R"({"x":{"dtype":"F32",)" + rest + "}}"; };
  expect_refused("{}", 4, ErrorCode::malformed);                                      // bytes of no tensor
  expect_refused("", 0, ErrorCode::malformed);                                        // no header
  expect_refused(" {}", 0, ErrorCode::malformed);                                     // must begin with {
  expect_refused("{\"x\":", 0, ErrorCode::malformed);                                 // broken JSON
  expect_refused("{}", 0, ErrorCode::truncated, 1000);                                // header cut short
  expect_refused("{}", 0, ErrorCode::malformed, kMaxHeaderBytes + 1);                 // absurd header
  expect_refused(x(R"("shape":[2],"data_offsets":[0,8])"), 4, ErrorCode::truncated);  // data cut short
  expect_refused(x(R"("shape":[3],"data_offsets":[0,8])"), 8,
                 ErrorCode::malformed);  // shape and bytes differ
  expect_refused(x(R"("shape":[2],"data_offsets":[8,0])"), 8, ErrorCode::malformed);    // backwards
  expect_refused(x(R"("shape":[-2],"data_offsets":[0,8])"), 8, ErrorCode::malformed);   // negative
  expect_refused(x(R"("shape":[2.0],"data_offsets":[0,8])"), 8, ErrorCode::malformed);  // not whole
  expect_refused(x(R"("shape":[2],"data_offsets":[0,8,9])"), 8, ErrorCode::malformed);  // three offsets
  expect_refused(x(R"("shape":[2])"), 8, ErrorCode::malformed);                         // no place
  expect_refused(x(R"("data_offsets":[0,4])"), 4, ErrorCode::malformed);                // no shape
  expect_refused(x(R"("shape":[4294967296,4294967296,2],"data_offsets":[0,0])"), 0,
                 ErrorCode::malformed);  // overflow
  expect_refused(R"({"x":{"dtype":"I64","shape":[1],"data_offsets":[0,8]}})", 8, ErrorCode::unsupported);
  expect_refused(R"({"x":{"dtype":"F32","dtype":"F32","shape":[1],"data_offsets":[0,4]}})", 4,
                 ErrorCode::malformed);
  const std::string one = R"("x":{"dtype":"F32","shape":[1],"data_offsets":[0,4]})";
  expect_refused("{" + one + "," + one + "}", 4, ErrorCode::malformed);  // a name twice
  expect_refused("{" + one + R"(,"y":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}})", 4,
                 ErrorCode::malformed);
  expect_refused("{" + one + R"(,"y":{"dtype":"F32","shape":[1],"data_offsets":[8,12]}})", 12,
                 ErrorCode::malformed);
  expect_refused(R"({"__metadata__":{"a":{}}})", 0, ErrorCode::malformed);
  expect_refused(R"({"x":)" + std::string(100'000, '['), 0, ErrorCode::malformed);  // deep
  EXPECT_FALSE(parse_safetensors({}, "test"));
}

TEST(Safetensors, RefusesNumbersThatAreNotFinite) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    const auto parsed = parse_safetensors(
        write_safetensors({.tensors = {{.name = "x", .shape = {2}, .values = {1, bad}}}, .metadata = {}}),
        "test");
    ASSERT_FALSE(parsed);
    EXPECT_EQ(parsed.error().code, ErrorCode::out_of_range);
  }
}

TEST(Safetensors, EveryTruncationIsRefused) {
  const auto bytes = write_safetensors(
      {.tensors = {{.name = "x", .shape = {5}, .values = {1, 2, 3, 4, 5}}}, .metadata = {{"a", "b"}}});
  for (std::size_t n = 0; n < bytes.size(); ++n)
    EXPECT_FALSE(parse_safetensors(std::span(bytes).first(n), "test")) << n;
}

}  // namespace
}  // namespace mien::model::safetensors_test
