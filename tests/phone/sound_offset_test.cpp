#include "mien/phone/sound_offset.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "mien/core/random.h"

// A room that two microphones hear: what is said there is drawn, since no phone's film of a take was at hand.
namespace mien::phone::sound_offset_test {
namespace {

constexpr std::uint32_t kRateHz = 16'000;

/// As speech: syllables of voiced pulses or noise, each of its own loudness, pitch and formant, and pauses.
Sound speech(double seconds, std::uint64_t seed) {
  Random random(seed);
  Sound sound{.rate_hz = kRateHz, .samples = {}};
  const auto count = static_cast<std::size_t>(seconds * kRateHz);
  sound.samples.reserve(count);
  while (sound.samples.size() < count) {
    const double length_s = random.uniform(0.08, 0.3);
    const double loud = random.chance(0.25) ? 0 : random.uniform(0.02, 0.3);
    const bool voiced = random.chance(0.7);
    const double pitch_hz = random.uniform(90, 220), formant_hz = random.uniform(300, 2'800);
    const double turn = 2 * std::numbers::pi * formant_hz / kRateHz, keep = 0.97;
    double before = 0, now = 0, phase = 0;
    const auto samples = static_cast<std::size_t>(length_s * kRateHz);
    for (std::size_t i = 0; i < samples && sound.samples.size() < count; ++i) {
      phase += pitch_hz / kRateHz;
      double source = 0.2 * random.normal(0, 1);
      if (voiced && phase >= 1) source += 6;
      if (phase >= 1) phase -= 1;
      const double next = source + 2 * keep * std::cos(turn) * now - keep * keep * before;
      before = now, now = next;
      const double swell = std::sin(std::numbers::pi * static_cast<double>(i) / static_cast<double>(samples));
      sound.samples.push_back(static_cast<float>(0.1 * loud * swell * next));
    }
  }
  return sound;
}

/// How a microphone hears a room.
struct Ear {
  double begin_s = 0, length_s = 0;  ///< The room's time.
  double fast_ppm = 0;               ///< Of its clock.
  double gain = 1;
  double noise_db = -60;     ///< Against what it hears.
  double echo = 0;           ///< Of a wall, 7 ms later.
  double low_pass = 0;       ///< Share that stays of the sample before.
  std::uint64_t seed = 100;  ///< Of its noise.
};

Sound heard(const Sound& room, const Ear& ear) {
  Random random(ear.seed);
  Sound out{.rate_hz = kRateHz, .samples = {}};
  const auto count = static_cast<std::size_t>(ear.length_s * kRateHz);
  out.samples.resize(count);
  const auto at = [&](double time_s) {
    const double place = time_s * kRateHz;
    if (!(place >= 0) || place + 1 >= static_cast<double>(room.samples.size())) return 0.0;
    const auto before = static_cast<std::size_t>(place);
    const double share = place - static_cast<double>(before);
    return (1 - share) * double{room.samples[before]} + share * double{room.samples[before + 1]};
  };
  double kept = 0, squares = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double time_s = ear.begin_s + static_cast<double>(i) / kRateHz / (1 + 1e-6 * ear.fast_ppm);
    double now = at(time_s);
    if (ear.echo != 0) now += ear.echo * at(time_s - 0.007);
    kept = ear.low_pass * kept + (1 - ear.low_pass) * now;
    squares += kept * kept;
    out.samples[i] = static_cast<float>(ear.gain * kept);
  }
  const double noise =
      std::abs(ear.gain) * std::sqrt(squares / static_cast<double>(count)) * std::pow(10, ear.noise_db / 20);
  for (float& sample : out.samples) sample += static_cast<float>(random.normal(0, noise));
  return out;
}

/// Expects that a phone's time is found to a millisecond.
SoundOffset expect_found(const Sound& take, const Sound& phone, double begin_s, double fast_ppm = 0) {
  const auto found = sound_offset(take, phone);
  if (!found) {
    ADD_FAILURE() << found.error().message();
    return {};
  }
  // The phone's time p is the room's begin_s + p / (1 + fast).
  const double phone_s = found->middle_s - found->offset_s;
  EXPECT_NEAR(found->middle_s, begin_s + phone_s / (1 + 1e-6 * fast_ppm), 1e-3);
  EXPECT_NEAR(found->drift_ppm, -fast_ppm, std::max(3.0, 4 * found->drift_sigma_ppm));
  EXPECT_GT(found->score, kLeastSoundScore);
  return *found;
}

TEST(SoundOffset, IsFoundOverMinutesWhateverTheMicrophonesAreLike) {
  const Sound room = speech(400, 1);
  const Sound take = heard(room, {.length_s = 400, .noise_db = -20, .seed = 7});
  const SoundOffset plain = expect_found(take, heard(room, {.begin_s = 215.4321, .length_s = 60}), 215.4321);
  EXPECT_NEAR(plain.overlap_s, 60, 0.1);
  EXPECT_GT(plain.agreeing, 0.9);
  EXPECT_LT(plain.offset_sigma_s, 1e-3);
  expect_found(take,
               heard(room, {.begin_s = 215.4321,
                            .length_s = 60,
                            .gain = -0.05,
                            .noise_db = -10,
                            .echo = 0.6,
                            .low_pass = 0.7}),
               215.4321);
}

TEST(SoundOffset, IsFoundInAsMuchNoise) {
  const Sound room = speech(120, 2);
  const Sound take = heard(room, {.length_s = 120, .noise_db = 0, .seed = 7});
  expect_found(take, heard(room, {.begin_s = 33.3, .length_s = 60, .noise_db = 0}), 33.3);
  expect_found(take, heard(room, {.begin_s = 50, .length_s = 12, .noise_db = 0}), 50);
}

TEST(SoundOffset, MayBeBeforeTheTakeBegan) {
  const Sound room = speech(60, 3);
  const Sound take = heard(room, {.begin_s = 20, .length_s = 40});
  const SoundOffset found = expect_found(take, heard(room, {.length_s = 35}), -20);
  EXPECT_NEAR(found.overlap_s, 15, 0.1);
  EXPECT_NEAR(found.to_first_s(20), 0, 1e-3);
}

TEST(SoundOffset, FollowsAClockThatDrifts) {
  const Sound room = speech(320, 4);
  const Sound take = heard(room, {.length_s = 300, .noise_db = -20, .seed = 7});
  for (const double fast_ppm : {30.0, -100.0}) {
    const SoundOffset found = expect_found(
        take, heard(room, {.begin_s = 5, .length_s = 290, .fast_ppm = fast_ppm, .noise_db = -20}), 5,
        fast_ppm);
    EXPECT_LT(found.drift_sigma_ppm, 3);
  }
}

TEST(SoundOffset, IsOfSoundsOfAnyRate) {
  const Sound room = speech(60, 5);
  Sound take = heard(room, {.length_s = 60});
  Sound phone = heard(room, {.begin_s = 10, .length_s = 40});
  // Every other sample of what has little above 4 kHz.
  Sound half{.rate_hz = kRateHz / 2, .samples = {}};
  for (std::size_t i = 0; i < phone.samples.size(); i += 2) half.samples.push_back(phone.samples[i]);
  expect_found(take, half, 10);
  expect_found(half, take, -10);
}

TEST(SoundOffset, IsNotOfAnotherRoom) {
  for (const double seconds : {8.0, 30.0})
    for (std::uint64_t seed = 10; seed < 13; ++seed) {
      const auto found = sound_offset(speech(seconds, seed), speech(seconds, seed + 100));
      ASSERT_FALSE(found) << seconds << " " << seed << " " << found->score << " " << found->agreeing;
      EXPECT_EQ(found.error().code, ErrorCode::mismatch);
    }
  // Two microphones' own noise is not a room's.
  Sound quiet{.rate_hz = kRateHz, .samples = std::vector<float>(std::size_t{60} * kRateHz)};
  quiet.samples[0] = 0.5;
  Sound hiss = quiet, other = quiet;
  Random random(8);
  for (float& sample : hiss.samples) sample = static_cast<float>(random.normal(0, 0.01));
  for (float& sample : other.samples) sample = static_cast<float>(random.normal(0, 0.01));
  EXPECT_EQ(sound_offset(hiss, other).error().code, ErrorCode::mismatch);
}

TEST(SoundOffset, IsNotOfWhatRepeats) {
  // A click a second says no more than which part of one it is.
  Sound clicks{.rate_hz = kRateHz, .samples = std::vector<float>(std::size_t{60} * kRateHz)};
  Random random(8);
  for (std::size_t i = 0; i < clicks.samples.size(); ++i)
    clicks.samples[i] = static_cast<float>(random.normal(0, i % kRateHz < 400 ? 0.2 : 0.001));
  Sound later = clicks;
  std::ranges::rotate(later.samples, later.samples.begin() + 5 * kRateHz);
  for (float& sample : later.samples) sample += static_cast<float>(random.normal(0, 0.3));
  const auto found = sound_offset(clicks, later);
  ASSERT_FALSE(found) << found->offset_s << " " << found->score;
}

TEST(SoundOffset, RefusesWhatIsShortOrSilent) {
  const Sound room = speech(20, 6);
  const Sound brief = heard(room, {.length_s = 3});
  EXPECT_EQ(sound_offset(room, brief).error().code, ErrorCode::not_found);
  EXPECT_EQ(sound_offset(brief, room).error().code, ErrorCode::not_found);
  EXPECT_EQ(sound_offset(room, Sound{.rate_hz = kRateHz, .samples = {}}).error().code, ErrorCode::not_found);
  EXPECT_EQ(sound_offset(room, Sound{}).error().code, ErrorCode::not_found);
  const Sound silent{.rate_hz = kRateHz, .samples = std::vector<float>(std::size_t{20} * kRateHz)};
  EXPECT_EQ(sound_offset(room, silent).error().code, ErrorCode::not_found);
  EXPECT_EQ(sound_offset(silent, room).error().code, ErrorCode::not_found);
}

/// Bursts of noise that no other moment has; quickly drawn.
Sound bursts(double seconds, std::uint32_t rate_hz) {
  Random random(9);
  Sound sound{.rate_hz = rate_hz, .samples = {}};
  const auto count = static_cast<std::size_t>(seconds * rate_hz);
  std::uint32_t state = 1;
  while (sound.samples.size() < count) {
    const double loud = random.chance(0.3) ? 1e-4 : random.uniform(0.01, 0.5);
    const std::size_t end =
        std::min(count, sound.samples.size() + static_cast<std::size_t>(random.uniform(0.05, 0.4) * rate_hz));
    while (sound.samples.size() < end) {
      state = state * 1'664'525U + 1'013'904'223U;
      sound.samples.push_back(
          static_cast<float>(loud * (static_cast<double>(state >> 8U) / (1U << 23U) - 1)));
    }
  }
  return sound;
}

TEST(SoundOffset, IsFoundInLongSounds) {
  const Sound room = bursts(600, 8'000);
  const Sound part{.rate_hz = 8'000, .samples = {room.samples.begin() + 8'000 * 100, room.samples.end()}};
  const auto found = sound_offset(room, part);
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_NEAR(found->offset_s, 100, 1e-3);
}

}  // namespace
}  // namespace mien::phone::sound_offset_test
