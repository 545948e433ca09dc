// IMUs and a headset's cameras on one performer.
#include "mien/virtual/worn_together.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "mien/core/files.h"
#include "mien/headset/picture_packet.h"
#include "mien/sensor/rig_part.h"
#include "mien/virtual/headset/worn_headset.h"
#include "mien/virtual/node_group.h"
#include "mien/virtual/stage.h"
#include "tests/folder.h"
#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt::worn_together_test {
namespace {

using ::testing::HasSubstr;

/// Every `from` in the text becomes `to`.
std::string with(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

/// A shipped rig, its cameras with small and few pictures.
std::string small(const std::string& name) {
  return with(with(read_text(project_path("rigs/" + name)).value(), "size = [240, 240]", "size = [64, 48]"),
              "rate_hz = 60.0", "rate_hz = 20.0");
}

class WornTogetherTest : public ::testing::Test {
 protected:
  void SetUp() override {
    request_.motion = test::talking(61);  // A second.
    request_.seed = 5;
  }
  const StageRequest& with_rig(const std::string& toml) {
    EXPECT_TRUE(write_file(folder_ / "rig.toml", toml));
    request_.rig = folder_ / "rig.toml";
    return request_;
  }
  Stage staged(const std::string& toml) {
    auto stage = set_stage(with_rig(toml));
    EXPECT_TRUE(stage) << stage.error().message();
    return std::move(stage).value();
  }
  Error refused(const std::string& toml) {
    const auto stage = set_stage(with_rig(toml));
    EXPECT_FALSE(stage);
    return stage ? Error{} : stage.error();
  }
  mien::test::Folder folder_;
  StageRequest request_;
};

/// What the cameras sent, or what all else did.
std::vector<take::LogEntry> entries_of(const VirtualSession& session, bool cameras) {
  std::vector<take::LogEntry> entries;
  for (const take::LogEntry& entry : session.entries)
    if (headset::parse_picture_packet(entry.bytes).has_value() == cameras) entries.push_back(entry);
  return entries;
}

void expect_same_bytes(const std::vector<take::LogEntry>& one, const std::vector<take::LogEntry>& other) {
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].bytes, other[i].bytes) << i;
    ASSERT_EQ(one[i].arrival, other[i].arrival) << i;
  }
}

TEST_F(WornTogetherTest, EachKindIsAsItIsAlone) {
  const VirtualSession both = play(staged(small("imu_headset.toml"))).value();
  EXPECT_EQ(both.truth.size(), both.ticks.size());
  const std::vector<take::LogEntry> pictures = entries_of(both, true);
  EXPECT_GT(pictures.size(), 4 * 20 * 5U);
  for (const take::LogEntry& entry : pictures) EXPECT_TRUE(both.payloads.contains(entry.id));

  const VirtualSession imus = play(staged(read_text(project_path("rigs/default.toml")).value())).value();
  expect_same_bytes(entries_of(both, false), imus.entries);
  EXPECT_EQ(both.motion_start, imus.motion_start) << "the clock is the ear's";
  // The same neutral, and then nod and shake, of which cameras on the head see nothing.
  EXPECT_TRUE(std::ranges::any_of(both.events, [](const take::Event& e) { return e.kind == "nod"; }));
}

TEST_F(WornTogetherTest, WhatBefallsTheCamerasIsToldOnTheImusClock) {
  request_.headset_failure = parse_timed_failure("hand@0.4-0.7").value();
  const VirtualSession session = play(staged(small("imu_headset.toml"))).value();
  const auto event = std::ranges::find(session.events, "headset_failure", &take::Event::kind);
  ASSERT_NE(event, session.events.end());
  EXPECT_NEAR(to_seconds(event->begin - session.motion_start), 0.4, 1e-3);
  EXPECT_NEAR(to_seconds(event->end - event->begin), 0.3, 1e-3);
}

TEST_F(WornTogetherTest, AMicrophoneIsBesideBoth) {
  const std::string microphone =
      "\n[[sensor]]\nname = \"microphone\"\nkind = \"speech\"\nrole = \"face\"\n"
      "device = \"02:4D:49:53:4E:01\"\n";
  std::string rig = small("imu_headset.toml");
  rig.insert(rig.find("# How the skin"), microphone);
  const VirtualSession session = play(staged(rig)).value();
  std::array<std::size_t, 17> samples{};
  for (const take::StoredSample& stored : session.samples) ++samples.at(stored.sample.sensor);
  EXPECT_EQ(std::ranges::count(samples, 0U), 0);
}

TEST_F(WornTogetherTest, WhatNobodyCanWearIsSaid) {
  const std::string rig = small("imu_headset.toml");
  EXPECT_THAT(refused(with(rig, "reference = \"mastoid_L\"", "reference = \"eye_L\"")).message(),
              HasSubstr("a camera's beside IMUs"));
  EXPECT_THAT(refused(with(rig, "[faults.headset]", "[faults.cameras]")).message(), HasSubstr("cameras"));
  EXPECT_THAT(refused(with(rig, "pores = 0.05", "pores = 5.0")).message(), HasSubstr("pores"));
  request_.devices = "lab";
  EXPECT_THAT(refused(rig).message(), HasSubstr("lab"));
}

TEST_F(WornTogetherTest, BoardsSendAndCamerasAreAsked) {
  const Stage stage = staged(small("imu_headset.toml"));
  const auto imus = sensor::sensors_of(stage.rig, "imu").size();
  const auto* headset = headset_of(stage);
  ASSERT_NE(headset, nullptr);
  EXPECT_EQ(headset->boards(stage)->cameras(), stage.rig.sensors.size() - imus);
  const auto group = NodeGroup::create(stage, NodeLanguage::mien, false);
  ASSERT_TRUE(group) << group.error().message();
  EXPECT_EQ((*group)->size(), imus);
}

}  // namespace
}  // namespace mien::virt::worn_together_test
