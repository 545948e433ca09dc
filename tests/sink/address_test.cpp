#include "mien/sink/address.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mien::sink::address_test {
namespace {

using ::testing::HasSubstr;

TEST(Address, TakesItsPartsApart) {
  const auto a = parse_address("LiveLink://192.168.1.7:11111?subject=Ann%20B&rate=30");
  ASSERT_TRUE(a) << a.error().message();
  EXPECT_EQ(a->scheme, "livelink");
  EXPECT_EQ(a->host, "192.168.1.7");
  EXPECT_EQ(a->port, 11111);
  EXPECT_EQ(a->path, "");
  ASSERT_NE(a->option("subject"), nullptr);
  EXPECT_EQ(*a->option("subject"), "Ann B");
  EXPECT_EQ(a->option("colour"), nullptr);
  EXPECT_EQ(*a->whole_option("rate", 60, 1, 60), 30);
  EXPECT_EQ(*a->whole_option("other", 60, 1, 60), 60);
  EXPECT_EQ(a->endpoint(1), "192.168.1.7:11111");
}

TEST(Address, TakesIpv6NamesPathsAndFiles) {
  const auto v6 = parse_address("vmc://[fe80::1%eth0]:39540");
  ASSERT_TRUE(v6) << v6.error().message();
  EXPECT_EQ(v6->host, "fe80::1%eth0");
  EXPECT_EQ(v6->port, 39540);
  EXPECT_EQ(parse_address("vmc://[::1]")->endpoint(39539), "[::1]:39539");
  const auto ws = parse_address("ws://studio.local/face/one?token=abcdefgh");
  ASSERT_TRUE(ws) << ws.error().message();
  EXPECT_EQ(ws->host, "studio.local");
  EXPECT_EQ(ws->port, 0);
  EXPECT_EQ(ws->path, "/face/one");
  const auto csv = parse_address("csv:/tmp/a take:1.csv?rate=30");
  ASSERT_TRUE(csv) << csv.error().message();
  EXPECT_EQ(csv->path, "/tmp/a take:1.csv");
  EXPECT_EQ(csv->host, "");
}

TEST(Address, RefusesEachMistakeAlone) {
  const std::pair<std::string, const char*> mistakes[] = {
      {"", "kind"},
      {"127.0.0.1:11111", "kind"},
      {"live link://a", "kind"},
      {"livelink:", "no host"},
      {"livelink:/a", "no host"},
      {"livelink://", "no host"},
      {"livelink://:11111", "no host"},
      {"livelink://a:0", "no port"},
      {"livelink://a:65536", "no number"},
      {"livelink://a:", "no number"},
      {"livelink://a:1x", "no number"},
      {"livelink://a:-1", "no number"},
      {"livelink://::1:5", "brackets"},
      {"livelink://[::1", "not closed"},
      {"livelink://[::1]5", "between"},
      {"livelink://a?rate", "no option"},
      {"livelink://a?=5", "no option"},
      {"livelink://a?rate=1&rate=2", "twice"},
      {"livelink://a?subject=%4", "broken %"},
      {"livelink://a?subject=%zz", "broken %"},
      {"livelink://a?subject=%00", "broken %"},
      {"livelink://a\n", "control"},
      {"csv:", "no file"},
      {"livelink://" + std::string(kMaxAddressBytes, 'a'), "longer"},
  };
  for (const auto& [text, why] : mistakes) {
    const auto address = parse_address(text);
    ASSERT_FALSE(address) << text;
    EXPECT_THAT(address.error().message(), HasSubstr(why)) << text;
    EXPECT_TRUE(is_bad_input(address.error().code)) << text;
  }
}

TEST(Address, ChecksOptions) {
  const auto a = parse_address("livelink://a?rate=fast&colour=red");
  ASSERT_TRUE(a);
  EXPECT_FALSE(a->whole_option("rate", 60, 1, 60));
  EXPECT_THAT(a->expect_options({"rate", "subject"}).error().message(), HasSubstr("rate, subject"));
  EXPECT_TRUE(a->expect_options({"rate", "colour"}));
  EXPECT_EQ(parse_address("livelink://a?rate=61")->whole_option("rate", 60, 1, 60).error().code,
            ErrorCode::out_of_range);
}

}  // namespace
}  // namespace mien::sink::address_test
