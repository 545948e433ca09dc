#include "mien/live/unheard.h"

#include <gtest/gtest.h>

namespace mien::live::unheard_test {
namespace {

session::Report report(std::uint64_t malformed, std::uint64_t refused) {
  session::Report out;
  out.links.resize(2);
  out.malformed = malformed;
  out.refused = refused;
  return out;
}

TEST(Unheard, IsWhatBecameOfWhatCame) {
  EXPECT_EQ(why_unheard({.received = 0}, report(0, 0)), Unheard::silence);
  EXPECT_EQ(why_unheard({.received = 10, .elsewhere = 6}, report(4, 0)), Unheard::elsewhere);
  EXPECT_EQ(why_unheard({.received = 10, .sealed = true}, report(5, 5)), Unheard::not_sealed);
  EXPECT_EQ(why_unheard({.received = 10}, report(0, 10)), Unheard::not_opened);
  EXPECT_EQ(why_unheard({.received = 10}, report(10, 0)), Unheard::unreadable);
  // Of a flood most is dropped before it is read.
  EXPECT_EQ(why_unheard({.received = 1'000'000}, report(10, 0)), Unheard::unreadable);
  EXPECT_EQ(why_unheard({.received = 10}, report(0, 0)), Unheard::no_reference);
}

TEST(Unheard, SoundPacketsOfOthersThanTheReferenceAreTheReasonWhateverCameBeside) {
  session::Report heard = report(100, 100);
  heard.links[1].health.age = std::chrono::milliseconds(5);
  EXPECT_EQ(why_unheard({.received = 210}, heard), Unheard::no_reference);
  session::Report unbound = report(100, 100);
  unbound.unbound.push_back({.device = "02:4D:49:45:4E:07", .announces = {}, .protocol = {}, .age = {}});
  EXPECT_EQ(why_unheard({.received = 210}, unbound), Unheard::no_reference);
}

TEST(Unheard, NamesTheVersionThatIsNotKnown) {
  session::Report newer = report(0, 10);
  newer.unknown_versions = {{.protocol = "mien", .version = 3, .source = "udp://10.0.0.9:1", .count = 2},
                            {.protocol = "livelink", .version = 7, .source = "udp://10.0.0.7:1", .count = 8}};
  const Unheard why = why_unheard({.received = 10}, newer);
  EXPECT_EQ(why, Unheard::other_version);
  EXPECT_EQ(unheard_text(why, newer),
            "udp://10.0.0.7:1 sends livelink packets of version 7, which this program does not know: update "
            "this program, or what sends there");
  newer.refused = 100;
  EXPECT_EQ(why_unheard({.received = 110}, newer), Unheard::not_opened) << "most are sealed";
  newer.links[1].health.age = std::chrono::milliseconds(5);
  EXPECT_EQ(why_unheard({.received = 120}, newer), Unheard::no_reference);
}

}  // namespace
}  // namespace mien::live::unheard_test
