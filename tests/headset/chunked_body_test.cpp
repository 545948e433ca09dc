#include "mien/headset/http_answer.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "mien/core/bytes.h"

namespace mien::headset::chunked_body_test {
namespace {

/// What comes out of a body that comes in so many bytes at a time; an error's code stands in `code`.
std::string content_of(std::string_view body, std::size_t piece, std::optional<ErrorCode>& code) {
  ChunkedBody chunks;
  std::string out;
  code.reset();
  for (auto bytes = std::as_bytes(std::span(body)); !bytes.empty();) {
    auto some = bytes.first(std::min(piece, bytes.size()));
    bytes = bytes.subspan(some.size());
    while (!some.empty()) {
      const auto content = chunks.read(some);
      if (!content) {
        code = content.error().code;
        return out;
      }
      out += as_text(*content);
    }
  }
  return out;
}

TEST(ChunkedBody, GivesItsContent) {
  const std::string body = "5\r\nhello\r\n1;name=value\r\n \r\n00A\r\n0123456789\r\n5\nworld\n";
  for (std::size_t piece = 1; piece < body.size(); ++piece) {
    std::optional<ErrorCode> code;
    EXPECT_EQ(content_of(body, piece, code), "hello 0123456789world");
    EXPECT_FALSE(code);
  }
}

TEST(ChunkedBody, EndsWithItsLastChunk) {
  std::optional<ErrorCode> code;
  EXPECT_EQ(content_of("5\r\nhello\r\n0\r\n\r\n", 100, code), "hello");
  EXPECT_EQ(code, ErrorCode::not_found);
}

TEST(ChunkedBody, RefusesEachWrongFrame) {
  for (const std::string body :
       {"x\r\nhello", "\r\nhello", "-1\r\nhello", "0x5\r\nhello", "5hello\r\n", "10000000\r\n",
        "5\r\nhello!\r\n", "5\r\nhello5\r\n", " 5\r\nhello", "+5\r\nhello"}) {
    std::optional<ErrorCode> code;
    static_cast<void>(content_of(body, 3, code));
    EXPECT_EQ(code, ErrorCode::malformed) << body;
  }
  std::optional<ErrorCode> code;
  static_cast<void>(content_of("5;" + std::string(1000, 'x'), 7, code));
  EXPECT_EQ(code, ErrorCode::malformed);
}

}  // namespace
}  // namespace mien::headset::chunked_body_test
