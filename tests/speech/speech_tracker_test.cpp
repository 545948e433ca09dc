#include "mien/speech/speech_tracker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

namespace mien::speech::speech_tracker_test {
namespace {

using face::Provenance;
using face::shape;
using testing::HasSubstr;

const std::size_t kJaw = shape("jawOpen");

/// A microphone whose clock is the session's.
sensor::Rig one() {
  sensor::Rig rig{.name = "one", .reference = "microphone"};
  rig.sensors.push_back({.name = "microphone", .kind = "speech", .role = "face"});
  return rig;
}

/// Hears a jaw as far open as the block's first sample says, and a voice as its second.
class Parrot final : public Listener {
 public:
  Parrot(int& resets, const tracker::ShapeConfidence* confidence)
      : resets_(resets), confidence_(confidence) {}
  [[nodiscard]] const tracker::ShapeConfidence* confidence() const override { return confidence_; }
  Heard push(DeviceTime time, const Block& block) override {
    Heard heard{.time = time, .weights = {}, .voice = static_cast<float>(block[1]) / 100};
    heard.weights[kJaw] = static_cast<float>(block[0]) / 100;
    heard.weights[shape("browInnerUp_L")] = 1;  // Nobody can hear that.
    return heard;
  }
  void reset() override { ++resets_; }

 private:
  int& resets_;
  const tracker::ShapeConfidence* confidence_;
};

class Played {
 public:
  /// A block that begins at this time.
  void say(int ms, int jaw, int voice = 100) {
    Block block{};
    block[0] = static_cast<std::int16_t>(jaw);
    block[1] = static_cast<std::int16_t>(voice);
    sensor::Sample sample;
    sample.kind = sensor::SampleKind::sound;
    sample.time = DeviceTime(std::chrono::milliseconds(ms + 10));
    const HostTime arrival{std::chrono::milliseconds(ms + 10)};
    lines_.add(arrival, sample);
    tracker->add_with_payload(arrival, sample, payload_of(block));
  }
  void talk(int from_ms, int until_ms, int jaw, int voice = 100) {
    for (int ms = from_ms; ms < until_ms; ms += 20) say(ms, jaw, voice);
  }
  face::OutputFrame frame(int ms) {
    face::OutputFrame out;
    present = tracker->tick(DeviceTime(std::chrono::milliseconds(ms)), lines_, out).sensors_present;
    return out;
  }
  std::size_t present = 0;
  int made = 0, resets = 0;
  const tracker::ShapeConfidence* confidence = nullptr;
  std::unique_ptr<SpeechTracker> tracker =
      SpeechTracker::create(one(), [this] {
        ++made;
        return Result<std::unique_ptr<Listener>>(std::make_unique<Parrot>(resets, confidence));
      }).value();

 private:
  sensor::TimeLines lines_{1, std::uint16_t{0}};
};

TEST(SpeechTracker, MouthAndJawAreFromAudioWhileSomebodySpeaks) {
  Played played;
  EXPECT_EQ(played.frame(0).provenance[kJaw], Provenance::neutral);
  EXPECT_EQ(played.present, 0U);
  EXPECT_EQ(played.made, 0) << "a session's first frame does not wait for its ears";
  played.talk(1000, 1100, 40);
  const face::OutputFrame frame = played.frame(1090);
  EXPECT_EQ(played.made, 1);
  EXPECT_EQ(played.present, 1U);
  EXPECT_FLOAT_EQ(frame.weights[kJaw], 0.4F);
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const bool heard = face::kShapeNames[k].starts_with("mouth") || face::kShapeNames[k].starts_with("jaw");
    EXPECT_EQ(frame.provenance[k], heard ? Provenance::audio : Provenance::neutral) << face::kShapeNames[k];
    EXPECT_EQ(frame.confidence[k], 0) << "nobody measured it";
  }
  EXPECT_EQ(frame.weights[shape("browInnerUp_L")], 0);
  EXPECT_EQ(frame.head_provenance, Provenance::neutral);
  EXPECT_EQ(frame.eyes_provenance, Provenance::neutral);
}

TEST(SpeechTracker, ConfidenceIsByTheListenersTableForMouthAndJawAlone) {
  model::ConfidenceTable table;
  table.coverage_edges = {0.75F};  // Of the voice.
  table.explained.assign(2 * face::kShapeCount, 0);
  table.within.assign(2 * face::kShapeCount, 0.25F);
  for (std::size_t k = 0; k < face::kShapeCount; ++k) table.within[2 * k + 1] = 0.875F;
  table.regions.emplace().fill({.offset = 1, .slope = 0});
  const tracker::ShapeConfidence confidence(table);
  Played played;
  played.confidence = &confidence;
  played.talk(0, 300, 40, 100);
  face::OutputFrame out = played.frame(290);
  EXPECT_EQ(out.confidence[kJaw], 0.875F);
  EXPECT_EQ(out.provenance[kJaw], Provenance::audio);
  EXPECT_EQ(out.confidence[shape("browInnerUp_L")], 0);
  EXPECT_GT(out.region_confidence[static_cast<std::size_t>(face::ShapeRegion::jaw)], 0.7F);
  EXPECT_EQ(out.region_confidence[static_cast<std::size_t>(face::ShapeRegion::brows)], 0);
  played.talk(300, 500, 40, 70);
  out = played.frame(490);
  EXPECT_EQ(out.confidence[kJaw], 0.25F) << "hardly a voice";
  played.talk(500, 1500, 40, 0);
  for (int ms = 510; ms <= 1490; ms += 20) out = played.frame(ms);
  EXPECT_EQ(out.confidence[kJaw], 0) << "nobody speaks";
  EXPECT_EQ(out.region_confidence[static_cast<std::size_t>(face::ShapeRegion::jaw)], 0);
}

TEST(SpeechTracker, BetweenTwoAnswersTimeDecides) {
  Played played;
  played.say(1000, 20);
  played.say(1020, 60);
  EXPECT_NEAR(played.frame(1005).weights[kJaw], 0.3F, 1e-5);
  EXPECT_FLOAT_EQ(played.frame(1030).weights[kJaw], 0.6F) << "and after the newest it holds";
  EXPECT_EQ(played.frame(990).provenance[kJaw], Provenance::neutral) << "nothing was heard of that";
}

TEST(SpeechTracker, SilenceIsNeutralAfterAPause) {
  Played played;
  played.talk(1000, 1200, 40);
  EXPECT_EQ(played.frame(1190).provenance[kJaw], Provenance::audio);
  int last = 0;
  for (int ms = 1200; ms < 2000; ms += 20) {
    played.say(ms, 0, 10);
    if (played.frame(ms).provenance[kJaw] == Provenance::audio) last = ms;
  }
  EXPECT_NEAR(last, 1200 + 300, 40);
  EXPECT_EQ(played.present, 1U) << "the microphone is there";
  // Neither one nor the other: what was is.
  played.talk(2000, 2100, 30, 50);
  EXPECT_EQ(played.frame(2090).provenance[kJaw], Provenance::neutral);
  played.talk(2100, 2200, 30, 70);
  EXPECT_EQ(played.frame(2190).provenance[kJaw], Provenance::audio);
  played.talk(2200, 3000, 30, 50);
  EXPECT_EQ(played.frame(2990).provenance[kJaw], Provenance::audio);
}

TEST(SpeechTracker, WithoutBlocksThereIsNoSound) {
  Played played;
  played.talk(1000, 1200, 40);
  EXPECT_EQ(played.frame(1390).provenance[kJaw], Provenance::audio) << "200 ms after the last block's middle";
  EXPECT_EQ(played.frame(1400).provenance[kJaw], Provenance::neutral);
  EXPECT_EQ(played.present, 0U);
  // After a gap the listener begins anew, and so it does with a microphone that restarts or is another.
  played.talk(1500, 1600, 40);
  EXPECT_EQ(played.resets, 1);
  played.talk(0, 100, 40);
  EXPECT_EQ(played.resets, 2);
  played.tracker->forget(0);
  EXPECT_EQ(played.resets, 3);
  played.tracker->forget(7);
  EXPECT_EQ(played.resets, 3);
}

TEST(SpeechTracker, DoubledBlocksAndOnesWithoutSamplesChangeNothing) {
  Played played;
  played.talk(1000, 1100, 40);
  const face::OutputFrame before = played.frame(1090);
  played.say(1080, 90);
  played.say(1040, 90);
  sensor::Sample sample;
  sample.kind = sensor::SampleKind::sound;
  sample.time = DeviceTime(std::chrono::milliseconds(1110));
  played.tracker->add({}, sample);
  played.tracker->add_with_payload({}, sample, {});
  EXPECT_EQ(played.frame(1090).weights, before.weights);
  EXPECT_EQ(played.resets, 0);
}

TEST(SpeechTracker, WithoutAListenerNothingIsHeard) {
  Played played;
  played.tracker = SpeechTracker::create(one(), []() -> Result<std::unique_ptr<Listener>> {
                     return fail(ErrorCode::not_found, "no ears", "model");
                   }).value();
  played.talk(1000, 1100, 40);
  EXPECT_EQ(played.frame(1090).provenance[kJaw], Provenance::neutral);
}

TEST(SpeechTracker, NeedsAMicrophone) {
  sensor::Rig rig = one();
  rig.sensors[0].kind = "imu";
  const auto tracker = SpeechTracker::create(rig, nullptr);
  ASSERT_FALSE(tracker);
  EXPECT_THAT(tracker.error().message(), HasSubstr("rig one"));
}

}  // namespace
}  // namespace mien::speech::speech_tracker_test
