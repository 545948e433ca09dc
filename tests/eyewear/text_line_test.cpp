#include "mien/eyewear/text_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace mien::eyewear::text_line_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

Result<TextLine> parsed(std::string_view text) {
  return parse_text_line(std::as_bytes(std::span(text)));
}

std::vector<std::int32_t> values(std::string_view text) {
  const auto line = parsed(text);
  if (!line) {
    ADD_FAILURE() << text << ": " << line.error().message();
    return {};
  }
  const auto* held = std::get_if<TextValues>(&*line);
  if (held == nullptr) return {};
  return {held->values.begin(), held->values.begin() + static_cast<std::ptrdiff_t>(held->count)};
}

TEST(TextLine, TakesWhatSketchesPrint) {
  for (const char* text : {"123,456,1023", "123,456,1023\n", "123,456,1023\r\n", "123\t456\t1023\r\n",
                           "123;456;1023", "123 456 1023", "123, 456, 1023", "123 ,456 ;1023",
                           "  123\t\t456   1023  ", "123,456,1023,", "123,456,1023, \r\n", "123;456;1023;\n"})
    EXPECT_THAT(values(text), ElementsAre(123, 456, 1023)) << text;
  EXPECT_THAT(values("7"), ElementsAre(7));
  EXPECT_THAT(values("-5,0,-1023"), ElementsAre(-5, 0, -1023));
  EXPECT_THAT(values("65535,-65535,007"), ElementsAre(65535, -65535, 7));
}

TEST(TextLine, TakesAsManyAsThereCanBe) {
  std::string text = "1";
  for (std::size_t i = 1; i < kMaxTextValues; ++i) text += ",1";
  EXPECT_EQ(values(text).size(), kMaxTextValues);
  EXPECT_EQ(parsed(text + ",1").error().code, ErrorCode::out_of_range);
}

TEST(TextLine, RefusesWhatIsNoScan) {
  for (const char* text : {"",  "\r\n", "  ",  ",",  ",1",   "1,,2", "1,;2", "1,2,,", "1.5",  "1,a",
                           "a", "1-2",  "--1", "+1", "0x10", "- 1",  "1:2",  "\"1\"", "1\r2", "1\n2"}) {
    const auto line = parsed(text);
    ASSERT_FALSE(line) << text;
    EXPECT_EQ(line.error().code, ErrorCode::malformed) << text;
  }
  for (const char* text : {"65536", "-65536", "99999999999999999999", "1,-99999999999"}) {
    const auto line = parsed(text);
    ASSERT_FALSE(line) << text;
    EXPECT_EQ(line.error().code, ErrorCode::out_of_range) << text;
  }
}

TEST(TextLine, AHeaderSaysWhatTheValuesAre) {
  const auto header = [](std::string_view text) {
    const auto line = parsed(text);
    const auto* held = line ? std::get_if<TextHeader>(&*line) : nullptr;
    EXPECT_NE(held, nullptr) << text;
    return held != nullptr ? *held : TextHeader{.adc_bits = 99};
  };
  EXPECT_EQ(header("# mien"), (TextHeader{.pairs = false, .adc_bits = 0}));
  EXPECT_EQ(header("#mien on off\r\n"), (TextHeader{.pairs = true, .adc_bits = 0}));
  EXPECT_EQ(header("# mien bits 12"), (TextHeader{.pairs = false, .adc_bits = 12}));
  EXPECT_EQ(header(" #  mien  on\toff bits 16 "), (TextHeader{.pairs = true, .adc_bits = 16}));
  for (const char* text : {"# mien on", "# mien off on", "# mien bits", "# mien bits x", "# mien bits 12a",
                           "# mien pairs", "# mien on off 12"})
    EXPECT_EQ(parsed(text).error().code, ErrorCode::malformed) << text;
  for (const char* text : {"# mien bits 7", "# mien bits 17", "# mien bits -10", "# mien bits 99999999999"})
    EXPECT_EQ(parsed(text).error().code, ErrorCode::out_of_range) << text;
}

TEST(TextLine, OtherLinesThatBeginSoAreComments) {
  for (const char* text : {"#", "# a0 a1 a2", "# miens on off", "#MIEN on off"}) {
    const auto line = parsed(text);
    ASSERT_TRUE(line) << text;
    EXPECT_TRUE(std::holds_alternative<TextComment>(*line)) << text;
  }
  EXPECT_THAT(values("# 1,2"), IsEmpty());
}

TEST(TextLine, IsToldFromBytes) {
  const auto is_text = [](std::string_view text) { return is_text_line(std::as_bytes(std::span(text))); };
  EXPECT_TRUE(is_text("1,2\t3; 4~\r\n"));
  EXPECT_TRUE(is_text("ets Jun  8 2016"));
  EXPECT_FALSE(is_text(""));
  EXPECT_FALSE(is_text(std::string_view("1,\0002", 4)));
  EXPECT_FALSE(is_text("1,\x7f"));
  EXPECT_FALSE(is_text("1,\xe9"));
  EXPECT_FALSE(is_text("1\x1b,2"));
}

}  // namespace
}  // namespace mien::eyewear::text_line_test
