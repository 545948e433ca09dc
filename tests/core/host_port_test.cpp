#include "mien/core/host_port.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mien::host_port_test {
namespace {

using ::testing::HasSubstr;

TEST(HostPort, TakesHostAndPortApart) {
  struct Case {
    const char* text;
    const char* host;
    std::optional<std::uint16_t> port;
  };
  for (const Case& c :
       {Case{"127.0.0.1:8740", "127.0.0.1", 8740}, Case{"studio.local:0", "studio.local", 0},
        Case{"studio", "studio", {}}, Case{"[::1]:65535", "::1", 65535},
        Case{"[fe80::1%eth0]", "fe80::1%eth0", {}}, Case{":5005", "", 5005}, Case{"", "", {}}}) {
    const auto parsed = parse_host_port(c.text);
    ASSERT_TRUE(parsed) << c.text << ": " << parsed.error().message();
    EXPECT_EQ(parsed->host, c.host) << c.text;
    EXPECT_EQ(parsed->port, c.port) << c.text;
    EXPECT_EQ(host_of(c.text), c.host);
  }
}

TEST(HostPort, RefusesEachMistakeAlone) {
  const std::pair<const char*, const char*> mistakes[] = {
      {"a:65536", "no number"}, {"a:", "no number"},   {"a:1x", "no number"}, {"a:-1", "no number"},
      {"a:+1", "no number"},    {"a: 1", "no number"}, {"::1:5", "brackets"}, {"a:1:2", "brackets"},
      {"[::1", "not closed"},   {"[", "not closed"},   {"[::1]5", "between"}, {"[::1]:", "no number"}};
  for (const auto& [text, part] : mistakes) {
    const auto parsed = parse_host_port(text);
    ASSERT_FALSE(parsed) << text;
    EXPECT_EQ(parsed.error().code, ErrorCode::bad_usage) << text;
    EXPECT_THAT(parsed.error().message(), HasSubstr(part)) << text;
  }
}

TEST(HostPort, KnowsThisMachineByNamesThatNobodyElseCanHave) {
  for (const char* host : {"localhost", "127.0.0.1", "127.1.2.3", "::1"})
    EXPECT_TRUE(is_loopback(host)) << host;
  for (const char* host : {"", "127", "127.evil.example", "127.0.0.1.evil.example", "localhost.evil.example",
                           "Localhost.", "[::1]", "::2", "0.0.0.0", "192.168.1.7"})
    EXPECT_FALSE(is_loopback(host)) << host;
}

}  // namespace
}  // namespace mien::host_port_test
