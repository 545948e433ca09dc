#include "mien/headset/http_answer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace mien::headset::response_head_test {
namespace {

using namespace std::string_literals;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kBoard =
    "HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace;boundary=123456789000000000000987654321\r\n"
    "Transfer-Encoding: chunked\r\nAccess-Control-Allow-Origin: *\r\nX-Framerate: 60\r\n";

TEST(ResponseHead, OfACameraIsTaken) {
  EXPECT_EQ(parse_response_head(kBoard), ResponseHead{.chunked = true});
  for (const char* head :
       {"HTTP/1.0 200 OK\nContent-type: multipart/x-mixed-replace",
        "HTTP/1.1 200\r\n"
        "CONTENT-TYPE:Multipart/X-Mixed-Replace ; boundary=\"a b\"\r\ncontent-encoding: identity\r\n"})
    EXPECT_EQ(parse_response_head(head), ResponseHead{}) << head;
}

TEST(ResponseHead, OfAnythingElseIsRefusedWithWhatToDo) {
  const std::string type = "Content-Type: multipart/x-mixed-replace\r\n";
  struct Case {
    std::string head;
    ErrorCode code;
    const char* words;
  };
  const std::vector<Case> cases = {
      {"HTTP/1.1 401 Unauthorized\r\nWWW-Authenticate: Basic\r\n", ErrorCode::unsupported, "password off"},
      {"HTTP/1.1 403 Forbidden\r\n", ErrorCode::unsupported, "password off"},
      {"HTTP/1.1 302 Found\r\nLocation: http://10.0.0.1/\r\n", ErrorCode::unsupported,
       "redirects are not followed"},
      {"HTTP/1.1 301 Moved\r\n", ErrorCode::unsupported, "(301)"},
      {"HTTP/1.1 404 Not Found\r\n", ErrorCode::unsupported, "http://HOST:PORT/PATH"},
      {"HTTP/1.1 503 Busy\r\n", ErrorCode::unsupported, "503"},
      {"HTTP/1.1 100 Continue\r\n", ErrorCode::unsupported, "100"},
      {"HTTP/1.1 206 Partial\r\n" + type, ErrorCode::unsupported, "206"},
      {"HTTP/2 200 OK\r\n" + type, ErrorCode::malformed, "no answer of a camera"},
      {"HTTP/1.1 2000 OK\r\n" + type, ErrorCode::malformed, "no answer of a camera"},
      {"HTTP/1.1 -20 OK\r\n" + type, ErrorCode::malformed, "no answer of a camera"},
      {"HTTP/1.1 20", ErrorCode::malformed, "no answer of a camera"},
      {"RTSP/1.0 200 OK\r\n", ErrorCode::malformed, "no answer of a camera"},
      {"", ErrorCode::malformed, "no answer of a camera"},
      {"HTTP/1.1 200 OK\r\n", ErrorCode::unsupported, "does not say what"},
      {"HTTP/1.1 200 OK\r\nContent-Type: image/jpeg\r\n", ErrorCode::unsupported, "MJPEG stream"},
      {"HTTP/1.1 200 OK\r\nContent-Type: text/html; charset=utf-8\r\n", ErrorCode::unsupported, "text/html"},
      {"HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replaced\r\n", ErrorCode::unsupported,
       "no stream"},
      {"HTTP/1.1 200 OK\r\n" + type + type, ErrorCode::malformed, "twice"},
      {"HTTP/1.1 200 OK\r\n" + type + "Transfer-Encoding: gzip, chunked\r\n", ErrorCode::unsupported, "gzip"},
      {"HTTP/1.1 200 OK\r\n" + type + "Content-Encoding: gzip\r\n", ErrorCode::unsupported,
       "compression off"},
      {"HTTP/1.1 200 OK\r\n" + type + " folded\r\n", ErrorCode::malformed, "no header"},
      {"HTTP/1.1 200 OK\r\n" + type + "no colon\r\n", ErrorCode::malformed, "no header"},
      {"HTTP/1.1 200 OK\r\n" + type + ": no name\r\n", ErrorCode::malformed, "no header"},
      {"HTTP/1.1 200 OK\r\n" + type + "X: \x1b[2J\r\n", ErrorCode::malformed, "no header"},
      {"HTTP/1.1 200 OK\r\n" + type + "X: \0\r\n"s, ErrorCode::malformed, "no header"},
      {"HTTP/1.1 200 OK\r\n" + type + "X: " + std::string(9000, 'x'), ErrorCode::out_of_range, "8192"},
  };
  for (const Case& one : cases) {
    const auto head = parse_response_head(one.head);
    ASSERT_FALSE(head) << one.head;
    EXPECT_EQ(head.error().code, one.code) << one.head;
    EXPECT_THAT(head.error().message(), HasSubstr(one.words));
    EXPECT_THAT(head.error().message(), Not(HasSubstr("\x1b")));
    EXPECT_FALSE(head.error().fix.empty());
  }
}

}  // namespace
}  // namespace mien::headset::response_head_test
