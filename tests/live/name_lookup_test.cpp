#include "mien/live/name_lookup.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "tests/network.h"

namespace mien::live::name_lookup_test {
namespace {

namespace asio = boost::asio;
using mien::test::run_until;

TEST(NameLookup, ANumberIsAnsweredWithoutAsking) {
  asio::io_context network;
  NameLookup lookup(network, [](const std::string&, std::uint16_t) -> NameLookup::Answer {
    ADD_FAILURE() << "nobody is to be asked";
    return {};
  });
  for (const std::string number : {"192.168.1.7", "::1"}) {
    std::vector<asio::ip::tcp::endpoint> found;
    lookup.find(number, 81, [&](const NameLookup::Answer& answer) { found = answer.found; });
    ASSERT_TRUE(run_until(network, [&] { return !found.empty(); }));
    EXPECT_EQ(found.front(), asio::ip::tcp::endpoint(asio::ip::make_address(number), 81));
  }
}

TEST(NameLookup, TheSystemKnowsThisMachine) {
  asio::io_context network;
  NameLookup lookup(network);
  bool loopback = false;
  lookup.find("localhost", 81, [&](const NameLookup::Answer& answer) {
    for (const auto& one : answer.found) loopback = loopback || one.address().is_loopback();
  });
  EXPECT_TRUE(run_until(network, [&] { return loopback; }));
}

TEST(NameLookup, SaysWhatTheAnswerIsAndAsksAgain) {
  asio::io_context network;
  std::atomic<int> asked = 0;
  NameLookup lookup(network, [&asked](const std::string& host, std::uint16_t port) {
    EXPECT_EQ(host, "nobody");
    EXPECT_EQ(port, 82);
    ++asked;
    return NameLookup::Answer{asio::error::host_not_found, {}};
  });
  for (int i = 1; i <= 2; ++i) {
    boost::system::error_code error;
    lookup.find("nobody", 82, [&](const NameLookup::Answer& answer) { error = answer.error; });
    EXPECT_TRUE(run_until(network, [&] { return error == asio::error::host_not_found; }));
    EXPECT_EQ(asked, i);
  }
}

TEST(NameLookup, WhileNobodyAnswersNobodyElseIsAskedAndWhoLeavesDoesNotWait) {
  asio::io_context network;
  // Shared with a thread that outlives what started it.
  const auto over = std::make_shared<std::atomic<bool>>(false);
  const auto asked = std::make_shared<std::atomic<int>>(0);
  const auto ask = [over, asked](const std::string&, std::uint16_t port) {
    ++*asked;
    over->wait(false);
    return NameLookup::Answer{{}, {{asio::ip::address_v4::loopback(), port}}};
  };
  NameLookup stays(network, ask);
  int first = 0, second = 0;
  stays.find("slow", 80, [&](const auto&) { ++first; });
  {
    NameLookup leaves(network, ask);
    leaves.find("slow", 80, [](const auto&) { ADD_FAILURE() << "who asked is gone"; });
    ASSERT_TRUE(run_until(network, [&] { return *asked == 2; }));
  }
  stays.find("slow", 80, [&](const auto&) { ++second; });
  *over = true;
  over->notify_all();
  EXPECT_TRUE(run_until(network, [&] { return second == 1; }));
  EXPECT_EQ(first, 0) << "the answer is for who asked last";
  EXPECT_EQ(*asked, 2);
}

}  // namespace
}  // namespace mien::live::name_lookup_test
