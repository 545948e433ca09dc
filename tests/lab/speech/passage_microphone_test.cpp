#include "lab/speech/passage_microphone.h"

#include <gtest/gtest.h>

#include "lab/speech/loudness_listener.h"
#include "tests/synthetic/speech/letter_speaker.h"

namespace mien::lab::passage_microphone_test {
namespace {

using Asked = PassageMicrophone::Asked;

constexpr std::size_t kJaw = face::shape("jawOpen");
const DeviceTime kBegin(std::chrono::seconds(5));

synthetic::SpokenPassage passage() {
  return synthetic::speak_passage(synthetic::test::letter_speaker(), "one", 0, Random(3)).value();
}

std::unique_ptr<PassageMicrophone> microphone(const synthetic::SpokenPassage& passage, Duration lag,
                                              Asked asked) {
  return PassageMicrophone::create(
             passage, kBegin + lag,
             []() -> Result<std::unique_ptr<speech::Listener>> {
               return std::make_unique<LoudnessListener>();
             },
             asked)
      .value();
}

/// The jaw at every tenth of a second from two seconds after the beginning, asked for so much later.
std::vector<float> jaw(PassageMicrophone& microphone, Duration from, Duration later) {
  const sensor::TimeLines no_lines(0, std::nullopt);
  std::vector<float> out;
  for (int i = -20; i < 60; ++i) {
    const DeviceTime frame = kBegin + from + std::chrono::milliseconds(100) * (i + 20);
    microphone.hear(frame);
    face::OutputFrame answer;
    microphone.tick(frame + later, no_lines, answer);
    if (i >= 0) out.push_back(answer.weights[kJaw]);
  }
  return out;
}

TEST(PassageMicrophone, WhatIsHeardLaterIsTheSameLater) {
  const synthetic::SpokenPassage said = passage();
  const Duration lag = std::chrono::milliseconds(120);
  const auto on_time = jaw(*microphone(said, {}, Asked::as_told), {}, {});
  EXPECT_GT(std::ranges::max(on_time), 0.1F);
  EXPECT_EQ(jaw(*microphone(said, lag, Asked::as_told), lag, {}), on_time);
  EXPECT_EQ(jaw(*microphone(said, -lag, Asked::as_told), -lag, {}), on_time);
  EXPECT_NE(jaw(*microphone(said, -lag, Asked::as_told), {}, {}), on_time);
}

TEST(PassageMicrophone, SoundThatIsEarlyIsAskedForAsLongAgo) {
  const synthetic::SpokenPassage said = passage();
  const Duration ago = -std::chrono::milliseconds(120);
  const auto as_it_comes = jaw(*microphone(said, ago, Asked::at_frame), {}, {});
  EXPECT_EQ(jaw(*microphone(said, ago, Asked::at_frame), {}, ago), as_it_comes) << "whatever is asked";
  EXPECT_NE(jaw(*microphone(said, ago, Asked::as_told), {}, ago), as_it_comes);
}

TEST(PassageMicrophone, NothingIsHeardBeforeItSounds) {
  const synthetic::SpokenPassage said = passage();
  const sensor::TimeLines no_lines(0, std::nullopt);
  const auto listening = microphone(said, {}, Asked::as_told);
  face::OutputFrame answer;
  listening->hear(kBegin - std::chrono::milliseconds(100));
  EXPECT_EQ(listening->tick(kBegin, no_lines, answer).sensors_present, 0U);
  // What is asked for beyond the frame is the newest that was heard.
  bool behind = false;
  for (int i = 0; i < 300; ++i) {
    const DeviceTime frame = kBegin + std::chrono::milliseconds(20) * i;
    listening->hear(frame);
    const auto told = listening->tick(frame + std::chrono::milliseconds(100), no_lines, answer);
    if (told.hearing->speaks) {
      EXPECT_GE(told.hearing->behind, std::chrono::milliseconds(90));
      behind = true;
    }
  }
  EXPECT_TRUE(behind);
}

}  // namespace
}  // namespace mien::lab::passage_microphone_test
