#include "app/live/page_address.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mien::app::page_address_test {
namespace {

using ::testing::ElementsAre;

const std::vector<std::string> kOwn = {"192.168.1.7", "[2001:db8::7]", "127.0.0.1", "[::1]"};

TEST(PageAddress, AnAddressOfOneInterfaceStaysAsItIs) {
  EXPECT_THAT(openable_addresses("http://127.0.0.1:8740/", kOwn), ElementsAre("http://127.0.0.1:8740/"));
  EXPECT_THAT(openable_addresses("http://[::1]:8740/", kOwn), ElementsAre("http://[::1]:8740/"));
}

TEST(PageAddress, EveryAddressBecomesTheMachinesOwnWithTheToken) {
  EXPECT_THAT(
      openable_addresses("http://0.0.0.0:8740/?token=abcd1234", kOwn),
      ElementsAre("http://192.168.1.7:8740/?token=abcd1234", "http://127.0.0.1:8740/?token=abcd1234"));
  EXPECT_THAT(openable_addresses("http://[::]:1/?token=abcd1234", kOwn),
              ElementsAre("http://192.168.1.7:1/?token=abcd1234", "http://[2001:db8::7]:1/?token=abcd1234",
                          "http://127.0.0.1:1/?token=abcd1234", "http://[::1]:1/?token=abcd1234"));
  EXPECT_THAT(openable_addresses("http://0.0.0.0:8740/", {}), ElementsAre("http://localhost:8740/"));
}

TEST(PageAddress, ThisMachineHasItsLoopbackLast) {
  const std::vector<std::string> own = own_addresses();
  if (own.empty()) GTEST_SKIP() << "this machine has no network at all";
  EXPECT_TRUE(own.back() == "127.0.0.1" || own.back() == "[::1]") << own.back();
}

}  // namespace
}  // namespace mien::app::page_address_test
