#include "mien/core/utf8.h"

#include <gtest/gtest.h>

namespace mien::utf8_test {
namespace {

TEST(Utf8, TakesWellFormedText) {
  for (const std::string_view text : {std::string_view(""), std::string_view("plain\0text", 10),
                                      std::string_view("\x7F"), std::string_view("\xC2\x80 \xDF\xBF"),
                                      std::string_view("\xE0\xA0\x80 \xED\x9F\xBF \xEE\x80\x80 \xEF\xBF\xBF"),
                                      std::string_view("\xF0\x90\x80\x80 \xF4\x8F\xBF\xBF")})
    EXPECT_TRUE(is_utf8(text)) << text;
}

TEST(Utf8, RefusesAnythingElse) {
  for (const std::string_view text :
       {"\x80", "\xBF", "\xC0\x80", "\xC1\xBF", "\xC2", "\xC2g", "\xE0\x9F\xBF", "\xE1\x80", "\xED\xA0\x80",
        "\xE1\x80g", "\xF0\x8F\xBF\xBF", "\xF0\x90\x80", "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xFF",
        "a\xFE"})
    EXPECT_FALSE(is_utf8(text)) << text.size();
}

}  // namespace
}  // namespace mien::utf8_test
