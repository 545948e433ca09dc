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

/// A rig of a sensor and a microphone, and a session of it that wants to hear and has frames.
struct UnheardMicrophoneTest : ::testing::Test {
  UnheardMicrophoneTest() {
    rig.sensors.resize(2);
    rig.sensors[0].name = "mentalis";
    rig.sensors[1].name = "mine";
    seen = report(0, 0);
    seen.frames = 600;
    seen.links[1].device = "02:4D:49:53:4E:01";
    seen.hearing = session::Report::Hearing{.on = true};
  }
  std::optional<std::string> at(double s) { return unheard.tell(HostTime(from_seconds(s)), rig, seen); }
  sensor::Rig rig;
  session::Report seen;
  UnheardMicrophone unheard{"mine"};
};

TEST_F(UnheardMicrophoneTest, IsToldOfOnceWithItsDevice) {
  EXPECT_FALSE(at(3));
  EXPECT_FALSE(at(12.9));
  EXPECT_EQ(at(13).value_or(""),
            "nothing comes from the microphone 'mine' yet: is it on, and does it send here as "
            "02:4D:49:53:4E:01, the device that it is bound to?");
  EXPECT_FALSE(at(100));
}

TEST_F(UnheardMicrophoneTest, IsNoneThatWasHeardOrThatNobodyWantsToHear) {
  seen.hearing->on = false;
  EXPECT_FALSE(at(0));
  EXPECT_FALSE(at(60));
  seen.hearing->on = true;
  EXPECT_FALSE(at(61)) << "it was switched on just now";
  seen.frames = 0;
  EXPECT_FALSE(at(80)) << "that nothing comes at all is told already";
  seen.frames = 600;
  EXPECT_FALSE(at(81));
  seen.links[1].health.age = std::chrono::milliseconds(5);
  EXPECT_FALSE(at(92));
  seen.links[1].health.age.reset();
  EXPECT_FALSE(at(300)) << "a loss is told as one";
}

TEST_F(UnheardMicrophoneTest, IsNoneWhereNoneSendsHere) {
  UnheardMicrophone none{""};
  EXPECT_FALSE(none.tell(HostTime(), rig, seen));
  EXPECT_FALSE(none.tell(HostTime(std::chrono::seconds(60)), rig, seen));
  seen.links[1].device.clear();
  EXPECT_FALSE(at(0));
  EXPECT_FALSE(at(60)) << "it waits to be bound";
}

}  // namespace
}  // namespace mien::live::unheard_test
