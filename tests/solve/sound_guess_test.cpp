#include "mien/solve/sound_guess.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "mien/core/random.h"
#include "mien/speech/sound_block.h"
#include "tests/folder.h"
#include "tests/virtual/three_sensors.h"

namespace mien::solve::sound_guess_test {
namespace {

constexpr double kTakeS = 40;
/// The reference's clock at the take's beginning, and when the first frame of features is, s after that.
constexpr double kReferenceS = 1'000, kFirstFrameS = 2;
/// The microphone's first block is of the take's second 1, and its clock is fast by so much.
constexpr std::uint64_t kFirstBlock = 50'000;
constexpr double kFastPpm = 40;
/// How long every packet takes.
constexpr double kWayS = 0.005;

DeviceTime first_frame() {
  return DeviceTime(from_seconds(kReferenceS + kFirstFrameS));
}

/// Bursts of noise that no other moment has, as a room hears them; 16 kHz.
std::vector<float> room() {
  Random random(3);
  std::vector<float> samples;
  while (samples.size() < static_cast<std::size_t>(kTakeS * speech::kRateHz)) {
    const double loud = random.chance(0.3) ? 1e-3 : random.uniform(0.02, 0.3);
    for (int left = static_cast<int>(random.uniform(0.05, 0.4) * speech::kRateHz); left > 0; --left)
      samples.push_back(static_cast<float>(std::clamp(random.normal(0, loud), -1.0, 1.0)));
  }
  return samples;
}

struct SoundGuessTest : testing::Test {
  mien::test::Folder folder;
  const std::vector<float> heard = room();

  /// A take whose microphone hears the room; all packets take 5 ms. `jump`: its block's count leaps back
  /// then.
  take::Take take(bool with_sound = true, bool jump = false) const {
    take::Header header;
    header.rig_toml = virt::test::kRig;
    auto writer = take::TakeWriter::create(folder / "take.mien", header, true).value();
    const std::uint16_t reference = virt::test::three_sensors().find("mastoid_L").value();
    const auto end_of = [](std::uint64_t number) {  // Of a block, in the take's time.
      return 1 + to_seconds(speech::kBlockDuration) * static_cast<double>(number + 1) / (1 + 1e-6 * kFastPpm);
    };
    std::uint64_t next = 0;
    for (int tick = 0; tick < static_cast<int>(100 * kTakeS); ++tick) {
      const double now_s = tick / 100.0;
      const HostTime arrival(from_seconds(now_s + kWayS));
      sensor::Sample sample{.sensor = reference, .time = DeviceTime(from_seconds(kReferenceS + now_s))};
      sample.count = 6;
      writer.add_sample(writer.add_entry(arrival, "udp", {}), arrival, sample);
      for (; with_sound && end_of(next) < now_s + 0.01; ++next) {
        if (next % 100 == 7) continue;  // Lost.
        speech::Block block{};
        for (std::size_t i = 0; i < block.size(); ++i) {
          const double back_s = static_cast<double>(block.size() - i) / speech::kRateHz;
          const auto place = static_cast<std::size_t>(std::lround((end_of(next) - back_s) * speech::kRateHz));
          if (place < heard.size()) block[i] = static_cast<std::int16_t>(std::lround(30'000 * heard[place]));
        }
        const bool leapt = jump && next >= 1'700;
        const speech::BlockHeader of{7, leapt ? next - 1'700 : kFirstBlock + next};
        writer.add_entry(HostTime(from_seconds(end_of(next) + kWayS)), "udp",
                         speech::encode_packet(of, block).value());
      }
    }
    const auto done = writer.finish();
    EXPECT_TRUE(done) << done.error().message();
    return take::Take::open(folder / "take.mien").value();
  }
  /// What a phone's film has of the room, from the take's second `from_s` on.
  [[nodiscard]] FilmSound film(double from_s, double seconds) const {
    const auto begin = heard.begin() + static_cast<std::ptrdiff_t>(from_s * speech::kRateHz);
    return {.sound = {.rate_hz = speech::kRateHz,
                      .samples = {begin, begin + static_cast<std::ptrdiff_t>(seconds * speech::kRateHz)}},
            .start_s = std::nullopt};
  }
};

TEST_F(SoundGuessTest, TheTakesSoundStandsOnTheSensorsTime) {
  const auto sound = take_sound(take(), first_frame());
  ASSERT_TRUE(sound) << sound.error().message();
  EXPECT_NEAR(sound->begin_s, 1 - kFirstFrameS, 2e-3);
  EXPECT_NEAR(sound->drift_ppm, -kFastPpm, 10);
  EXPECT_NEAR(sound->sound.duration_s(), kTakeS - 1, 0.05);
  // What was lost is silence, and what follows stands where it belongs.
  const std::size_t lost = 7 * speech::kBlockSamples;
  for (std::size_t i = 0; i < speech::kBlockSamples; ++i) ASSERT_EQ(sound->sound.samples[lost + i], 0);
  EXPECT_NE(sound->sound.samples[lost + speech::kBlockSamples + 5], 0);
}

TEST_F(SoundGuessTest, OfAMicrophoneThatWasStartedAnewTheLongestStretchCounts) {
  const auto sound = take_sound(take(true, true), first_frame());
  ASSERT_TRUE(sound) << sound.error().message();
  EXPECT_NEAR(sound->sound.duration_s(), 34, 0.1);
  EXPECT_NEAR(sound->begin_s, 1 - kFirstFrameS, 2e-3);
}

TEST_F(SoundGuessTest, ATakeMayHaveNone) {
  const auto sound = take_sound(take(false), first_frame());
  ASSERT_FALSE(sound);
  EXPECT_EQ(sound.error().code, ErrorCode::not_found);
}

TEST_F(SoundGuessTest, AFilmBeginsWithItsTrackOrByItsTimeCode) {
  const TakeSound sound = take_sound(take(), first_frame()).value();
  FilmSound of_phone = film(12, 20);
  const auto together = guess_by_sound(sound, of_phone, 50'000);
  ASSERT_TRUE(together) << together.error().message();
  EXPECT_FALSE(together->by_timecode);
  EXPECT_NEAR(together->at.to_first_s(0), 12 - kFirstFrameS, 3e-3);
  EXPECT_NEAR(together->at.to_first_s(20), 32 - kFirstFrameS, 3e-3);
  const phone::AlignmentPrior prior = together->prior();
  EXPECT_NEAR(prior.offset_s, 12 - kFirstFrameS, 3e-3);
  EXPECT_LT(prior.offset_window_s, phone::AlignmentPrior{}.offset_window_s);

  // The film began half a second before the file's first row, and a midnight between.
  of_phone.start_s = 86'399.75;
  const auto by_timecode = guess_by_sound(sound, of_phone, 0.25);
  ASSERT_TRUE(by_timecode) << by_timecode.error().message();
  EXPECT_TRUE(by_timecode->by_timecode);
  EXPECT_NEAR(by_timecode->at.to_first_s(0), 12.5 - kFirstFrameS, 3e-3);
  EXPECT_LT(by_timecode->begin_sigma_s, together->begin_sigma_s);
  // Of another clock.
  of_phone.start_s = 3'600;
  const auto foreign = guess_by_sound(sound, of_phone, 50'000);
  ASSERT_TRUE(foreign) << foreign.error().message();
  EXPECT_FALSE(foreign->by_timecode);
  EXPECT_NEAR(foreign->at.to_first_s(0), together->at.to_first_s(0), 1e-9);
}

TEST_F(SoundGuessTest, AnotherRoomsFilmIsRefused) {
  const TakeSound sound = take_sound(take(), first_frame()).value();
  FilmSound other = film(0, 20);
  Random random(9);
  for (float& sample : other.sound.samples) sample = static_cast<float>(random.normal(0, 0.1));
  EXPECT_EQ(guess_by_sound(sound, other, 0).error().code, ErrorCode::mismatch);
  EXPECT_EQ(guess_by_sound(sound, film(0, 3), 0).error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace mien::solve::sound_guess_test
