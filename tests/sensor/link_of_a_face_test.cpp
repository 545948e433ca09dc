#include <gtest/gtest.h>

#include "mien/sensor/link_health.h"

// The link of who tells a face: in parts, and not while none is seen.
namespace mien::sensor::link_of_a_face_test {
namespace {

constexpr Duration kMs = std::chrono::milliseconds(1);

LinkState state(const LinkHealth& link, HostTime now) {
  return link.report(now, {}).state;
}

/// A program at 60 Hz that tells a face in three parts of one time.
struct Parts {
  std::uint32_t sequence = 0;
  bool still = false;
  float value = 0;
  [[nodiscard]] HostTime arrival() const { return HostTime(5 * kMs + sequence * 16 * kMs); }
  void send(LinkHealth& link, int times = 1) {
    if (!still) value += 0.01F;
    for (int time = 0; time < times; ++time)
      for (int part = 0; part < 3; ++part) {
        Sample s;
        s.kind = part < 2 ? SampleKind::weights : SampleKind::head_pose;
        s.sequence = sequence;
        s.time = DeviceTime(sequence * 16 * kMs);
        s.count = 5;
        // The first part never changes, as half of a face that rests.
        s.values = {1, 1, part < 2 ? 13.0F * static_cast<float>(part) : 0, 0, part == 0 ? 0 : value};
        link.add(arrival(), s, false);
      }
    ++sequence;
  }
};

TEST(LinkOfAFace, AReadingInPartsIsOneSample) {
  LinkHealth link;
  Parts face;
  for (int i = 0; i < 300; ++i) face.send(link);
  LinkReport report = link.report(face.arrival(), {});
  EXPECT_EQ(report.state, LinkState::good);
  EXPECT_NEAR(report.rate_hz, 1000.0 / 16, 2);
  EXPECT_EQ(report.lost + report.late + report.doubled + report.reordered + report.restarts, 0U);
  ++face.sequence;
  face.send(link, 2);
  report = link.report(face.arrival(), {});
  EXPECT_EQ(report.lost, 1U);
  EXPECT_EQ(report.doubled, 1U) << "came twice at one moment";
}

TEST(LinkOfAFace, SeesAReadingInPartsThatIsFrozen) {
  LinkHealth link;
  Parts face;
  for (int i = 0; i < 300; ++i) face.send(link);
  face.still = true;
  for (int i = 0; i < 20; ++i) face.send(link);
  EXPECT_EQ(state(link, face.arrival()), LinkState::good);
  for (int i = 0; i < 20; ++i) face.send(link);
  EXPECT_EQ(state(link, face.arrival()), LinkState::frozen);
  face.still = false;
  for (int i = 0; i < 2; ++i) face.send(link);
  EXPECT_EQ(state(link, face.arrival()), LinkState::good);
}

TEST(LinkOfAFace, WhoSaysThatItSeesNoFaceIsThere) {
  LinkHealth link;
  Parts face;
  for (int i = 0; i < 300; ++i) face.send(link);
  HostTime now = face.arrival();
  link.add_no_face(now);
  EXPECT_EQ(state(link, now + 80 * kMs), LinkState::good) << "a frame or two are nothing";
  for (int i = 0; i < 300; ++i) link.add_no_face(now += 16 * kMs);
  LinkReport report = link.report(now, {});
  EXPECT_EQ(report.state, LinkState::no_face);
  EXPECT_EQ(report.loss, 0) << "it owes no samples";
  // What it said holds a second; of what it owed only what came after is missing.
  EXPECT_EQ(state(link, now + 1000 * kMs), LinkState::no_face);
  report = link.report(now + 1001 * kMs, {});
  EXPECT_EQ(report.state, LinkState::lost);
  EXPECT_GT(report.loss, 0);
  link.add_no_face(now += 2000 * kMs);
  EXPECT_EQ(state(link, now), LinkState::no_face) << "at once, since no sample came";
  face.sequence += static_cast<std::uint32_t>((now - face.arrival()) / (16 * kMs)) + 1;
  face.send(link);
  EXPECT_NE(state(link, face.arrival()), LinkState::no_face);
  EXPECT_NE(state(link, face.arrival()), LinkState::lost);
}

TEST(LinkOfAFace, WhatIsRepeatedWithoutAFaceIsNoFaceAndNotFrozen) {
  LinkHealth link;
  Parts face;
  for (int i = 0; i < 300; ++i) face.send(link);
  face.still = true;
  for (int i = 0; i < 60; ++i) {
    link.add_no_face(face.arrival());
    face.send(link);
  }
  EXPECT_EQ(state(link, face.arrival()), LinkState::no_face);
  for (int i = 0; i < 60; ++i) face.send(link);
  EXPECT_EQ(state(link, face.arrival()), LinkState::frozen) << "it does not say so any more";
}

TEST(LinkOfAFace, WhoNeverSawAFaceIsNotSilent) {
  LinkHealth link;
  link.add_alive(HostTime(5 * kMs));
  EXPECT_EQ(state(link, HostTime(6 * kMs)), LinkState::silent) << "that it is there says nothing of a face";
  link.add_no_face(HostTime(10 * kMs));
  EXPECT_EQ(state(link, HostTime(10 * kMs)), LinkState::no_face);
  EXPECT_EQ(state(link, HostTime(1011 * kMs)), LinkState::lost);
}

}  // namespace
}  // namespace mien::sensor::link_of_a_face_test
