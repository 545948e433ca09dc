#include "mien/session/prompt_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/virtual/three_sensors.h"

namespace mien::session::prompt_watch_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Link = PromptWatch::Link;

/// A line of two seconds in which the jaw opens by so much, and the second sensor is `link` in so many
/// frames.
std::vector<std::string> judged(const Prompt& prompt, float opens, Link link, int frames_missing) {
  const sensor::Rig rig = virt::test::three_sensors();
  PromptWatch watch(rig);
  face::OutputFrame frame;
  for (int i = 0; i < 120; ++i) {
    frame.weights[face::shape("jawOpen")] = i == 60 ? opens : 0;
    watch.add(DeviceTime(), frame,
              [&](std::uint16_t sensor) { return sensor == 1 && i < frames_missing ? link : Link::there; });
  }
  return watch.poor(prompt, rig);
}

TEST(PromptWatch, ALineIsPoorWhereASensorWasLostForMoreThanATenthOfIt) {
  const std::string name = virt::test::three_sensors().sensors[1].name;
  Prompt read;
  read.text = "Read this.";
  EXPECT_THAT(judged(read, 0.5F, Link::lost, 0), IsEmpty());
  EXPECT_THAT(judged(read, 0.5F, Link::lost, 12), IsEmpty());
  EXPECT_THAT(judged(read, 0.5F, Link::lost, 13), ElementsAre(name + " was lost"));
  EXPECT_THAT(judged(read, 0.5F, Link::no_face, 13), ElementsAre(name + " saw no face"));
}

TEST(PromptWatch, ALineIsPoorWhereNothingMovedThoughSomethingWasAskedFor) {
  Prompt read, pose, rest;
  read.text = "Read this.";
  pose.target[face::shape("jawOpen")] = 1;
  EXPECT_THAT(judged(read, 0.01F, Link::there, 0), ElementsAre("nothing moved"));
  EXPECT_THAT(judged(pose, 0.01F, Link::there, 0), ElementsAre("nothing moved"));
  EXPECT_THAT(judged(rest, 0.01F, Link::there, 0), IsEmpty()) << "a face at rest is asked to hold still";
}

TEST(PromptWatch, LidsAndEyesMoveWithoutAnybodysDoing) {
  const sensor::Rig rig = virt::test::three_sensors();
  PromptWatch watch(rig);
  face::OutputFrame frame;
  for (int i = 0; i < 120; ++i) {
    frame.weights[face::shape("eyeBlink_L")] = i == 60 ? 1.0F : 0.0F;
    watch.add(DeviceTime(), frame, [](std::uint16_t) { return Link::there; });
  }
  Prompt read, shut;
  read.text = "Read this.";
  shut.target[face::shape("eyeBlink_L")] = 1;
  EXPECT_THAT(watch.poor(read, rig), ElementsAre("nothing moved"));
  EXPECT_THAT(watch.poor(shut, rig), IsEmpty()) << "there they are what was asked for";
}

TEST(PromptWatch, ALineThatBeginsAnewIsJudgedAnew) {
  const sensor::Rig rig = virt::test::three_sensors();
  PromptWatch watch(rig);
  face::OutputFrame frame;
  Prompt rest;
  for (int i = 0; i < 60; ++i) watch.add(DeviceTime(), frame, [](std::uint16_t) { return Link::lost; });
  EXPECT_EQ(watch.poor(rest, rig).size(), 3u);
  const DeviceTime later{std::chrono::seconds(1)};
  for (int i = 0; i < 29; ++i) watch.add(later, frame, [](std::uint16_t) { return Link::there; });
  EXPECT_THAT(watch.poor(rest, rig), ElementsAre("it was over at once"));
  watch.add(later, frame, [](std::uint16_t) { return Link::there; });
  EXPECT_THAT(watch.poor(rest, rig), IsEmpty());
}

}  // namespace
}  // namespace mien::session::prompt_watch_test
