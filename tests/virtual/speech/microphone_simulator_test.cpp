// A microphone that hears a performance, with a clock and faults of its own.
#include "mien/virtual/speech/microphone_simulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mien/speech/sound_block.h"

namespace mien::virt::microphone_simulator_test {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;

constexpr double kToneHz = 400;

/// Of 22.05 kHz, as espeak-ng's.
Sound tone(double seconds, float amplitude = 0.5F) {
  Sound sound{.rate_hz = 22'050, .samples = {}};
  sound.samples.resize(static_cast<std::size_t>(seconds * sound.rate_hz));
  for (std::size_t i = 0; i < sound.samples.size(); ++i)
    sound.samples[i] =
        amplitude *
        static_cast<float>(std::sin(2 * std::numbers::pi * kToneHz * static_cast<double>(i) / sound.rate_hz));
  return sound;
}

struct Heard {
  speech::BlockHeader header;
  speech::Block block;
  HostTime arrival;
};
std::vector<Heard> hear(MicrophoneSimulator& microphone, double until_s) {
  std::vector<Datagram> sent;
  while (microphone.heard_s() < until_s)
    EXPECT_TRUE(microphone.hear([](double true_s) { return true_s; }, sent));
  std::vector<Heard> heard;
  for (const Datagram& datagram : sent) {
    const auto packet = speech::parse_packet(datagram.bytes).value();
    heard.push_back({packet.header, speech::samples_of(packet.samples).value(), datagram.time});
  }
  return heard;
}

std::vector<Heard> hear(const SoundInAir& sound, const MicrophoneFaults& faults, double until_s,
                        const VirtualClock& clock = {}) {
  MicrophoneSimulator microphone(sound, faults, speech::kAnyMicrophone, Random(3), clock);
  return hear(microphone, until_s);
}

TEST(SoundInAir, IsTheSoundAtAnyMoment) {
  const SoundInAir sound = SoundInAir::of(tone(1)).value();
  for (double t = 0.1; t < 0.9; t += 0.01037)
    EXPECT_NEAR(sound.at(t), 0.5 * std::sin(2 * std::numbers::pi * kToneHz * t), 2e-3) << t;
  EXPECT_EQ(sound.at(-0.5), 0);
  EXPECT_EQ(sound.at(1.5), 0);
  EXPECT_EQ(sound.at(std::nan("")), 0);
  EXPECT_EQ(SoundInAir().at(0), 0);
  EXPECT_EQ(SoundInAir::of({.rate_hz = 1, .samples = {0}}).error().code, ErrorCode::out_of_range);
}

TEST(Microphone, APerfectOneSendsEachBlockAtItsEnd) {
  const SoundInAir sound = SoundInAir::of(tone(1)).value();
  const std::vector<Heard> heard = hear(sound, {}, 0.5);
  ASSERT_EQ(heard.size(), 25U);
  for (std::size_t b = 0; b < heard.size(); ++b) {
    EXPECT_EQ(heard[b].header.device, speech::kAnyMicrophone);
    EXPECT_EQ(heard[b].header.block, b);
    EXPECT_NEAR(to_seconds(heard[b].arrival.time_since_epoch()), 0.02 * static_cast<double>(b + 1), 1e-8);
  }
  for (std::size_t i = 0; i < speech::kBlockSamples; ++i) {
    const double t = 0.2 + static_cast<double>(i) / speech::kRateHz;
    ASSERT_NEAR(heard[10].block[i] / speech::kFullScale, 0.5 * std::sin(2 * std::numbers::pi * kToneHz * t),
                2e-3);
  }
}

TEST(Microphone, ACountOfItsSamplesIsItsOwnClock) {
  const SoundInAir sound = SoundInAir::of(tone(30)).value();
  // A clock that is 300 ppm fast, and was switched on 7 s before.
  const VirtualClock clock{.offset_s = 7, .rate = 1 + 300e-6};
  const std::vector<Heard> heard = hear(sound, {}, 29, clock);
  const double first_s = clock.true_s(heard.front().header.time());
  EXPECT_GE(first_s, -0.25);
  EXPECT_LT(first_s, -0.22);
  for (const Heard& one : {heard[100], heard[1'400]}) {
    const double begin_s = clock.true_s(one.header.time());
    EXPECT_NEAR(to_seconds(one.arrival.time_since_epoch()), begin_s + 0.02 / clock.rate, 1e-6);
    for (std::size_t i = 0; i < speech::kBlockSamples; ++i) {
      const double t = begin_s + static_cast<double>(i) / (speech::kRateHz * clock.rate);
      ASSERT_NEAR(one.block[i] / speech::kFullScale, 0.5 * std::sin(2 * std::numbers::pi * kToneHz * t),
                  4e-3);
    }
  }
}

TEST(Microphone, DrawsItsClockAndIsTheSameForTheSameSeed) {
  MicrophoneFaults faults;
  faults.clock_offset_s = {1, 50};
  faults.clock_drift_ppm = 300;
  faults.noise = 0.01;
  faults.radio_delay_ms = 3;
  faults.packet_loss = 0.1;
  const SoundInAir silence;
  const auto make = [&](std::uint64_t seed) {
    return MicrophoneSimulator(silence, faults, speech::kAnyMicrophone, Random(seed));
  };
  MicrophoneSimulator one = make(1), same = make(1), other = make(2);
  EXPECT_GE(one.clock().offset_s, 1);
  EXPECT_LE(one.clock().offset_s, 50);
  EXPECT_NE(one.clock().rate, 1);
  EXPECT_NE(one.clock().offset_s, other.clock().offset_s);
  const std::vector<Heard> a = hear(one, 5), b = hear(same, 5);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].header, b[i].header);
    EXPECT_EQ(a[i].block, b[i].block);
    EXPECT_EQ(a[i].arrival, b[i].arrival);
  }
}

TEST(Microphone, LosesBlocksAndDelaysThemInOrder) {
  MicrophoneFaults faults;
  faults.packet_loss = 0.2;
  faults.radio_delay_min_ms = 120;
  faults.radio_delay_ms = 40;
  const std::vector<Heard> heard = hear(SoundInAir(), faults, 40);
  EXPECT_NEAR(static_cast<double>(heard.size()), 0.8 * 2'000, 70);
  double most_s = 0, least_s = 10;
  for (std::size_t i = 0; i < heard.size(); ++i) {
    if (i > 0) {
      ASSERT_GT(heard[i].header.block, heard[i - 1].header.block);
      ASSERT_GE(heard[i].arrival, heard[i - 1].arrival);
    }
    const double delay_s = to_seconds(heard[i].arrival.time_since_epoch()) -
                           0.02 * static_cast<double>(heard[i].header.block + 1);
    least_s = std::min(least_s, delay_s);
    most_s = std::max(most_s, delay_s);
  }
  EXPECT_NEAR(least_s, 0.12, 2e-3);
  EXPECT_GT(most_s, 0.2);
}

TEST(Microphone, FallsSilentForSeconds) {
  MicrophoneFaults faults;
  faults.sensor_loss_per_hour = 600;
  const std::vector<Heard> heard = hear(SoundInAir(), faults, 90);
  std::size_t gaps = 0;
  for (std::size_t i = 1; i < heard.size(); ++i)
    if (const auto missing = heard[i].header.block - heard[i - 1].header.block - 1; missing > 0) {
      ++gaps;
      EXPECT_GE(missing, 49U);
    }
  EXPECT_GT(gaps, 3U);
}

TEST(Microphone, IsClippedAndBiasedAsItsFaultsSay) {
  const SoundInAir sound = SoundInAir::of(tone(1)).value();
  MicrophoneFaults loud;
  loud.level = 1'000;
  const speech::Block clipped = hear(sound, loud, 0.5)[10].block;
  EXPECT_EQ(*std::ranges::max_element(clipped), 32'767);
  EXPECT_EQ(*std::ranges::min_element(clipped), -32'768);
  MicrophoneFaults biased;
  biased.offset = 1;
  EXPECT_THAT(hear(SoundInAir(), biased, 0.5)[10].block, Each(32'767));
  MicrophoneFaults noisy;
  noisy.noise = 0.001;
  EXPECT_NEAR(speech::loudness_of(hear(SoundInAir(), noisy, 0.5)[10].block).rms, 0.001, 2e-4);
  EXPECT_THAT(hear(SoundInAir(), {}, 0.5)[10].block, Each(0)) << "a perfect one in a silent room";
}

TEST(MicrophoneFaults, AreReadFromTheirTable) {
  const MicrophoneFaults faults =
      parse_microphone_faults(
          "clock_offset_s = [1, 2]\nclock_drift_ppm = 300\nradio_delay_min_ms = 120\n"
          "radio_delay_ms = 2\npacket_loss = 0.1\nsensor_loss_per_hour = 3\nlevel = 2\n"
          "noise = 0.1\noffset = 0.2",
          "rig.toml")
          .value();
  MicrophoneFaults expected;
  expected.clock_offset_s = {1, 2};
  expected.clock_drift_ppm = 300;
  expected.radio_delay_min_ms = 120;
  expected.radio_delay_ms = 2;
  expected.packet_loss = 0.1;
  expected.sensor_loss_per_hour = 3;
  expected.level = 2;
  expected.noise = 0.1;
  expected.offset = 0.2;
  EXPECT_EQ(faults, expected);
  EXPECT_EQ(parse_microphone_faults("", "rig.toml").value(), MicrophoneFaults());
}

TEST(MicrophoneFaults, RefuseWhatIsNone) {
  const auto refused = [](const std::string& text) {
    return parse_microphone_faults(text, "rig.toml").error();
  };
  EXPECT_EQ(refused("gyro_scale = 1").code, ErrorCode::malformed);
  EXPECT_EQ(refused("level = \"loud\"").code, ErrorCode::malformed);
  for (const char* text : {"packet_loss = 1.1", "noise = 2", "offset = 1.5", "clock_drift_ppm = 20000",
                           "level = nan", "radio_delay_ms = -1", "clock_offset_s = [2, 1]"})
    EXPECT_EQ(refused(text).code, ErrorCode::out_of_range) << text;
  EXPECT_THAT(refused("noise = 2").message(), HasSubstr("rig.toml"));
}

}  // namespace
}  // namespace mien::virt::microphone_simulator_test
