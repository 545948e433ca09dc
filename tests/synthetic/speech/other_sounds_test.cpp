#include "mien/synthetic/speech/other_sounds.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/speech/sound_block.h"

namespace mien::synthetic::other_sounds_test {
namespace {

constexpr std::size_t kTenSeconds = 10 * speech::kRateHz;

TEST(OtherSounds, AreAllHeardAndNeverTheSame) {
  for (std::size_t kind = 0; kind < kOtherSoundNames.size(); ++kind) {
    const auto sound = make_other_sound(static_cast<OtherSound>(kind), kTenSeconds, Random(1));
    ASSERT_EQ(sound.size(), kTenSeconds);
    EXPECT_GT(rms_of(sound), 0.03) << kOtherSoundNames[kind];
    EXPECT_LT(rms_of(sound), 0.11) << kOtherSoundNames[kind];
    for (const float s : sound) ASSERT_LE(std::abs(s), 1);
    EXPECT_EQ(sound, make_other_sound(static_cast<OtherSound>(kind), kTenSeconds, Random(1)));
    EXPECT_NE(sound, make_other_sound(static_cast<OtherSound>(kind), kTenSeconds, Random(2)));
  }
}

TEST(OtherSounds, AreMixedAtTheirRatio) {
  // Speech for half of the time: only that half counts.
  std::vector<float> sound(kTenSeconds);
  for (std::size_t i = 0; i < sound.size() / 2; ++i)
    sound[i] = 0.1F * static_cast<float>(i % 2 == 0 ? 1 : -1);
  const std::vector<float> before = sound;
  mix_at(20, make_other_sound(OtherSound::white, kTenSeconds, Random(1)), sound);
  std::vector<float> added(sound.size());
  for (std::size_t i = 0; i < sound.size(); ++i) added[i] = sound[i] - before[i];
  EXPECT_NEAR(20 * std::log10(0.1 / rms_of(added)), 20, 0.2);
}

TEST(OtherSounds, ARoomAddsItsPartAndDiesAway) {
  std::vector<float> click(speech::kRateHz);
  click[100] = 1;
  put_in_room(0.3, 6, Random(1), click);
  double tail = 0;
  for (std::size_t i = 101; i < click.size(); ++i) tail += double{click[i]} * double{click[i]};
  EXPECT_NEAR(10 * std::log10(tail), -6, 1);
  for (std::size_t i = 100 + static_cast<std::size_t>(0.31 * speech::kRateHz); i < click.size(); ++i)
    EXPECT_EQ(click[i], 0);
}

TEST(OtherSounds, ATelephoneCutsBothEnds) {
  const auto level = [](double hz) {
    std::vector<float> tone(speech::kRateHz);
    for (std::size_t i = 0; i < tone.size(); ++i)
      tone[i] = static_cast<float>(std::sin(2 * M_PI * hz * static_cast<double>(i) / speech::kRateHz));
    limit_band(300, 3400, tone);
    return 20 * std::log10(rms_of(tone) * std::numbers::sqrt2);
  };
  EXPECT_NEAR(level(1000), 0, 0.5);
  EXPECT_LT(level(75), -20);
  EXPECT_LT(level(7000), -15);
}

}  // namespace
}  // namespace mien::synthetic::other_sounds_test
