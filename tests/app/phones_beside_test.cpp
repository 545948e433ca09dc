#include "app/live/phones_beside.h"

#include <gmock/gmock.h>

#include <chrono>
#include <string>

namespace mien::app::test::phones_beside_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

session::Report::Unbound heard(const std::string& device, const std::string& protocol = "livelink") {
  return {.device = device,
          .announces = {},
          .protocol = protocol,
          .age = std::chrono::milliseconds(10),
          .source = "udp://192.168.1.9:5005"};
}

TEST(PhonesBeside, TellsOnceOfAPhoneThatNoSensorIsBoundTo) {
  PhonesBeside phones;
  session::Report report;
  EXPECT_THAT(phones.tell(report), IsEmpty());
  report.unbound = {heard("02:4D:49:45:4E:07", "mien"), heard("24:6F:28:11:22:33", "slimevr")};
  EXPECT_THAT(phones.tell(report), IsEmpty()) << "boards wait to be bound, and the page says so";
  report.unbound.push_back(heard("02:4D:49:50:48:01"));
  const auto said = phones.tell(report);
  ASSERT_THAT(said, SizeIs(1));
  EXPECT_THAT(said[0], HasSubstr("02:4D:49:50:48:01 (livelink from udp://192.168.1.9:5005); bind it"));
  EXPECT_THAT(phones.tell(report), IsEmpty());
  report.unbound.push_back(heard("02:4D:49:46:4D:01", "ifacialmocap"));
  EXPECT_THAT(phones.tell(report), SizeIs(1));
}

TEST(PhonesBeside, SaysNothingOfOneThatIsSilentAndManyInOneLine) {
  PhonesBeside phones;
  session::Report report;
  report.unbound = {heard("02:4D:49:50:48:01")};
  report.unbound[0].age = std::chrono::seconds(9);
  EXPECT_THAT(phones.tell(report), IsEmpty());
  for (const char* device : {"02:4D:49:50:48:02", "02:4D:49:50:48:03", "02:4D:49:50:48:0F"})
    report.unbound.push_back(heard(device));
  const auto said = phones.tell(report);
  ASSERT_THAT(said, SizeIs(1));
  EXPECT_THAT(said[0],
              HasSubstr("02:4D:49:50:48:02 (livelink from udp://192.168.1.9:5005) and 2 phones more"));
}

}  // namespace
}  // namespace mien::app::test::phones_beside_test
