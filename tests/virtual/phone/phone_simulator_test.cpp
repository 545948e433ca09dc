// A phone before a performer's face, with a counter and faults of its own.
#include "mien/virtual/phone/phone_simulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>

#include "mien/phone/live_link.h"
#include "tests/performer/talking.h"

namespace mien::virt::phone_simulator_test {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;
using Values = std::array<float, face::kLiveLinkValueCount>;

constexpr std::size_t kJawOpen = 17;  // In the order of packets.

struct Told {
  std::uint32_t number = 0;
  double rate_hz = 0;
  DeviceTime time;
  std::optional<Values> values;
  HostTime arrival;
  std::vector<std::byte> bytes;
};
std::vector<Told> film(PhoneSimulator& phone, const PhoneSimulator::Performed& performed, double until_s) {
  std::vector<Datagram> sent;
  while (phone.filmed_s() < until_s) phone.film(performed, sent);
  std::vector<Told> told;
  for (Datagram& datagram : sent) {
    const auto packet = phone::parse_live_link(datagram.bytes);
    EXPECT_TRUE(packet) << packet.error().message();
    told.push_back({packet->frame, static_cast<double>(packet->rate_numerator) / packet->rate_denominator,
                    packet->time(), packet->values, datagram.time, datagram.bytes});
  }
  return told;
}
std::vector<Told> film(const PhoneFaults& faults, const PhoneSimulator::Performed& performed, double until_s,
                       double motion_start_s = 0, std::uint64_t seed = 3) {
  PhoneSimulator phone(faults, motion_start_s, Random(seed));
  return film(phone, performed, until_s);
}

/// The jaw opens and closes, a smile comes and goes, the head nods.
face::MotionFrame talking(double true_s) {
  static const face::Motion motion = performer::test::talking(6'000);
  static const face::MotionCurve curve(motion);
  return curve.at(true_s);
}
face::MotionFrame held(double, float weight) {
  face::MotionFrame frame;
  frame.weights.values.fill(weight);
  return frame;
}
face::MotionFrame at_rest(double true_s) {
  return held(true_s, 0);
}
face::MotionFrame at_half(double true_s) {
  return held(true_s, 0.5F);
}

void expect_told(const Values& told, const face::MotionFrame& truth, float within = 0) {
  const face::ArkitWeights weights = face::arkit_from_ict(truth.weights, truth.tongue_out, true);
  for (std::size_t k = 0; k < weights.values.size(); ++k)
    ASSERT_NEAR(told[k], std::clamp(weights.values[k], 0.0F, 1.0F), within) << k;
  const Quat head = face::head_from_livelink(Vec3(told[52], told[53], told[54]));
  ASSERT_LT(angle_between(head, truth.head), 1e-6);
}

/// Root mean square about the mean.
double spread(const std::vector<double>& values) {
  double sum = 0, squares = 0;
  for (const double value : values) sum += value;
  const double mean = sum / static_cast<double>(values.size());
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(values.size()));
}

TEST(Phone, APerfectOneTellsEverySixtiethAsItIsAtOnce) {
  const std::vector<Told> told = film(PhoneFaults(), talking, 5);
  ASSERT_EQ(told.size(), 300U);
  for (std::size_t i = 0; i < told.size(); ++i) {
    EXPECT_EQ(told[i].number, i);
    EXPECT_EQ(told[i].rate_hz, 60);
    EXPECT_EQ(told[i].arrival.time_since_epoch(), told[i].time.time_since_epoch());
    ASSERT_TRUE(told[i].values);
    expect_told(*told[i].values, talking(to_seconds(told[i].time.time_since_epoch())));
  }
}

TEST(Phone, TellsWhereTheEyesLook) {
  const auto looking = [](double) {
    face::MotionFrame frame;
    frame.weights[face::shape("eyeLookOut_L")] = 0.5F;
    frame.weights[face::shape("eyeLookDown_L")] = 0.25F;
    return frame;
  };
  const Values values = film(PhoneFaults(), looking, 0.1).front().values.value();
  // Positive to the performer's right, and down.
  EXPECT_NEAR(values[55], -0.5 * face::kEyeTurnRadPerUnit, 1e-6);
  EXPECT_NEAR(values[56], 0.25 * face::kEyeTurnRadPerUnit, 1e-6);
}

TEST(Phone, IsTheSameForTheSameStream) {
  const std::vector<Told> one = film(usual_phone(), talking, 5), same = film(usual_phone(), talking, 5);
  ASSERT_EQ(one.size(), same.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].bytes, same[i].bytes);
    EXPECT_EQ(one[i].arrival, same[i].arrival);
  }
  const std::vector<Told> other = film(usual_phone(), talking, 5, 0, 4);
  EXPECT_NE(one.front().number, other.front().number);
  EXPECT_NE(one.front().values, other.front().values);
}

TEST(Phone, ItsFramesStandOnItsOwnCounter) {
  PhoneFaults faults;
  faults.clock_offset_s = {500, 600};
  faults.clock_drift_ppm = 300;
  PhoneSimulator phone(faults, 0, Random(3));
  EXPECT_GE(phone.clock().offset_s, 500);
  EXPECT_LE(phone.clock().offset_s, 600);
  EXPECT_NE(phone.clock().rate, 1);
  const std::vector<Told> told = film(phone, talking, 60);
  EXPECT_NEAR(phone.clock().true_s(told.front().time), -0.25, 0.02);
  for (std::size_t i = 0; i < told.size(); ++i) {
    ASSERT_EQ(told[i].number, told.front().number + i);
    const double true_s = phone.clock().true_s(told[i].time);
    expect_told(told[i].values.value(), talking(true_s), 1e-5F);
    EXPECT_NEAR(to_seconds(told[i].arrival.time_since_epoch()), true_s, 1e-6);
  }
}

TEST(Phone, OfThirtyASecondItCountsSixtieths) {
  PhoneFaults faults;
  faults.rate_hz = 30;
  phone::LiveLinkProtocol protocol;
  sensor::Inbox inbox;
  for (const bool sixtieths : {true, false}) {
    faults.counts_sixtieths = sixtieths;
    const std::vector<Told> told = film(faults, talking, 5);
    ASSERT_EQ(told.size(), 150U);
    for (std::size_t i = 0; i < told.size(); ++i) {
      EXPECT_EQ(told[i].number, (sixtieths ? 2 : 1) * i);
      EXPECT_EQ(told[i].rate_hz, sixtieths ? 60 : 30);
      EXPECT_NEAR(to_seconds(told[i].time.time_since_epoch()), static_cast<double>(i) / 30, 1e-8);
    }
  }
  // A session finds none missing.
  faults.counts_sixtieths = true;
  std::vector<std::uint32_t> sequence;
  for (const Told& frame : film(faults, talking, 5)) {
    inbox.clear();
    ASSERT_EQ(protocol.receive(frame.arrival, 0, frame.bytes, inbox), sensor::Verdict::taken);
    sequence.push_back(inbox.readings.front().sample.sequence);
  }
  for (std::size_t i = 1; i < sequence.size(); ++i) EXPECT_EQ(sequence[i], sequence[i - 1] + 1);
}

TEST(Phone, TheFaceItTellsIsOlderThanItsFrame) {
  PhoneFaults faults;
  faults.lag_ms = {50, 50};
  for (const Told& frame : film(faults, talking, 5)) {
    const double frame_s = to_seconds(frame.time.time_since_epoch());
    expect_told(frame.values.value(), talking(frame_s - 0.05), 1e-6F);
    EXPECT_EQ(frame.arrival.time_since_epoch(), frame.time.time_since_epoch())
        << "arrival tells nothing of it";
  }
  faults.lag_ms = {10, 90};
  std::vector<double> lags_s;
  for (std::uint64_t seed = 0; seed < 200; ++seed)
    lags_s.push_back(PhoneSimulator(faults, 0, Random(seed)).lag_s());
  EXPECT_GE(std::ranges::min(lags_s), 0.01);
  EXPECT_LE(std::ranges::max(lags_s), 0.09);
  EXPECT_NEAR(spread(lags_s), 0.08 / std::sqrt(12.0), 0.003);
}

TEST(Phone, SmoothingFlattensAndAddsNoLag) {
  PhoneFaults faults;
  faults.smoothing_ms = 40;
  const auto rising = [](double true_s) {
    face::MotionFrame frame;
    frame.weights[face::shape("jawOpen")] = static_cast<float>(0.3 + 0.1 * true_s);
    return frame;
  };
  for (const Told& frame : film(faults, rising, 3))
    EXPECT_NEAR((*frame.values)[kJawOpen], 0.3 + 0.1 * to_seconds(frame.time.time_since_epoch()), 1e-6);
  const auto beating = [](double true_s) {  // 4 Hz about 0.5.
    face::MotionFrame frame;
    frame.weights[face::shape("jawOpen")] =
        static_cast<float>(0.5 + 0.4 * std::cos(8 * std::numbers::pi * true_s));
    return frame;
  };
  // What a Gaussian leaves of it.
  const double left = std::exp(-0.5 * std::pow(8 * std::numbers::pi * 0.04, 2));
  for (const Told& frame : film(faults, beating, 3))
    EXPECT_NEAR((*frame.values)[kJawOpen],
                0.5 + 0.4 * left * std::cos(8 * std::numbers::pi * to_seconds(frame.time.time_since_epoch())),
                0.005);
}

TEST(Phone, PacketsComeLateAndInOrder) {
  PhoneFaults faults;
  faults.delay_ms = {60, 120};
  const std::vector<Told> told = film(faults, talking, 60);
  std::vector<double> delays_s;
  for (std::size_t i = 0; i < told.size(); ++i) {
    if (i > 0) {
      ASSERT_GE(told[i].arrival, told[i - 1].arrival);
    }
    delays_s.push_back(to_seconds(told[i].arrival.time_since_epoch() - told[i].time.time_since_epoch()));
  }
  EXPECT_NEAR(std::ranges::min(delays_s), 0.06, 0.002);
  EXPECT_NEAR(std::ranges::max(delays_s), 0.12, 0.002);
}

TEST(Phone, DroppedFramesAreGapsAndChangeNothingElse) {
  PhoneFaults faults = usual_phone();
  faults.frames_dropped = 0;
  const std::vector<Told> all = film(faults, talking, 40);
  faults.frames_dropped = 0.1;
  const std::vector<Told> some = film(faults, talking, 40);
  EXPECT_NEAR(static_cast<double>(some.size()), 0.9 * static_cast<double>(all.size()), 50);
  auto whole = all.begin();
  for (const Told& frame : some) {
    whole = std::ranges::find(whole, all.end(), frame.number, &Told::number);
    ASSERT_NE(whole, all.end());
    EXPECT_EQ(frame.bytes, whole->bytes);
    EXPECT_EQ(frame.arrival, whole->arrival);
  }
}

TEST(Phone, ALostFaceIsAPacketWithoutOne) {
  PhoneFaults faults;
  faults.face_lost_between_s = {1, 3};
  const std::vector<Told> told = film(faults, talking, 6, 0.5);
  EXPECT_EQ(told.size(), 360U);
  for (const Told& frame : told) {
    const double motion_s = to_seconds(frame.time.time_since_epoch()) - 0.5;
    EXPECT_EQ(frame.values.has_value(), motion_s < 1 || motion_s >= 3) << motion_s;
  }
}

TEST(Phone, LosesTheFaceForSecondsNowAndThen) {
  PhoneFaults faults;
  faults.face_loss_per_hour = 360;
  faults.face_loss_s = {1, 2};
  const std::vector<Told> told = film(faults, talking, 600);
  EXPECT_EQ(told.size(), 36'000U);
  std::vector<int> losses;  // How many frames each.
  for (std::size_t i = 1; i < told.size(); ++i) {
    if (told[i].values) continue;
    if (told[i - 1].values || losses.empty()) losses.push_back(0);
    ++losses.back();
  }
  if (!told.back().values) losses.pop_back();
  EXPECT_NEAR(static_cast<double>(losses.size()), 60, 25);
  EXPECT_GE(std::ranges::min(losses), 60);
}

TEST(Phone, AFaceAtRestIsNotZeroToIt) {
  PhoneFaults faults;
  faults.resting_offset = 0.1;
  const std::vector<Told> told = film(faults, at_rest, 1);
  const Values first = told.front().values.value();
  double squares = 0;
  for (std::size_t k = 0; k < 52; ++k) {
    EXPECT_GE(first[k], 0);
    EXPECT_LE(first[k], 0.5F);
    squares += double{first[k]} * double{first[k]};
  }
  EXPECT_NEAR(std::sqrt(squares / 43), 0.1, 0.03) << "of those that neither look nor are the tongue";
  for (const char* none : {"eyeLookUpLeft", "eyeLookInRight", "tongueOut"})
    EXPECT_EQ(first[face::arkit_index(none)], 0) << none;
  for (const Told& frame : told) EXPECT_EQ(frame.values, first);
  // And a full one is full.
  for (const Told& frame : film(
           faults, [](double t) { return held(t, 1); }, 1))
    EXPECT_NEAR((*frame.values)[kJawOpen], 1, 1e-6);
}

TEST(Phone, HasAGainForEachShape) {
  PhoneFaults faults;
  faults.gain_error = 0.1;
  std::vector<double> gains;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const std::vector<Told> told = film(faults, at_half, 0.2, 0, seed);
    for (const Told& frame : told) EXPECT_EQ(frame.values, told.front().values);
    for (std::size_t k = 0; k < 51; ++k)
      if (k != face::arkit_index("mouthClose") && k != face::arkit_index("browInnerUp") &&
          k != face::arkit_index("cheekPuff"))
        gains.push_back(double{(*told.front().values)[k]} / 0.5);
  }
  EXPECT_NEAR(spread(gains), 0.1, 0.01);
}

TEST(Phone, ItsNoiseLastsForAWhile) {
  PhoneFaults faults;
  faults.noise = 0.05;
  faults.noise_time_s = 2;
  const std::vector<Told> told = film(faults, at_half, 600);
  std::vector<double> now, later_apart, next_apart;
  constexpr std::size_t kLater = 120;  // Two seconds.
  for (std::size_t i = 0; i + kLater < told.size(); ++i) {
    const auto jaw = [&](std::size_t at) { return double{(*told[at].values)[kJawOpen]}; };
    now.push_back(jaw(i));
    next_apart.push_back(jaw(i + 1) - jaw(i));
    later_apart.push_back(jaw(i + kLater) - jaw(i));
  }
  EXPECT_NEAR(spread(now), 0.05, 0.01);
  // Differences of what is worth exp(-t / 2 s): sqrt(2 (1 - that)).
  EXPECT_NEAR(spread(next_apart), 0.05 * std::sqrt(2 * (1 - std::exp(-1.0 / 120))), 0.001);
  EXPECT_NEAR(spread(later_apart), 0.05 * std::sqrt(2 * (1 - std::exp(-1.0))), 0.01);
}

TEST(Phone, WhateverIsWrongWithItItsNumbersAreNot) {
  PhoneFaults faults = usual_phone();
  faults.resting_offset = faults.gain_error = faults.noise = 1;
  const auto wild = [](double true_s) { return held(true_s, static_cast<float>(2 * std::sin(9 * true_s))); };
  for (const Told& frame : film(faults, wild, 20)) {
    if (!frame.values) continue;
    EXPECT_THAT(std::span(*frame.values).first(52),
                Each(::testing::AllOf(::testing::Ge(0), ::testing::Le(1))));
    EXPECT_LE((*frame.values)[face::arkit_index("mouthClose")], (*frame.values)[kJawOpen]);
  }
}

TEST(PhoneFaults, AreReadFromTheirTable) {
  const PhoneFaults faults =
      parse_phone_faults(
          "rate_hz = 30\ncounts_sixtieths = false\nclock_offset_s = [1, 2]\nclock_drift_ppm = 20\n"
          "lag_ms = [10, 40]\nsmoothing_ms = 5\ndelay_ms = [60, 120]\nframes_dropped = 0.1\n"
          "face_loss_per_hour = 3\nface_loss_s = [1, 3]\nface_lost_between_s = [20, 24]\n"
          "resting_offset = 0.05\ngain_error = 0.2\nnoise = 0.02\nnoise_time_s = 4",
          "rig.toml")
          .value();
  PhoneFaults expected;
  expected.rate_hz = 30;
  expected.counts_sixtieths = false;
  expected.clock_offset_s = {1, 2};
  expected.clock_drift_ppm = 20;
  expected.lag_ms = {10, 40};
  expected.smoothing_ms = 5;
  expected.delay_ms = {60, 120};
  expected.frames_dropped = 0.1;
  expected.face_loss_per_hour = 3;
  expected.face_loss_s = {1, 3};
  expected.face_lost_between_s = {20, 24};
  expected.resting_offset = 0.05;
  expected.gain_error = 0.2;
  expected.noise = 0.02;
  expected.noise_time_s = 4;
  EXPECT_EQ(faults, expected);
  EXPECT_EQ(parse_phone_faults("", "rig.toml").value(), PhoneFaults()) << "a perfect one";
  EXPECT_NE(usual_phone(), PhoneFaults());
}

TEST(PhoneFaults, RefuseWhatIsNone) {
  const auto refused = [](const std::string& text) { return parse_phone_faults(text, "rig.toml").error(); };
  EXPECT_EQ(refused("gyro_scale = 1").code, ErrorCode::malformed);
  EXPECT_EQ(refused("rate_hz = \"fast\"").code, ErrorCode::malformed);
  EXPECT_EQ(refused("counts_sixtieths = 1").code, ErrorCode::malformed);
  EXPECT_EQ(refused("lag_ms = 20").code, ErrorCode::malformed);
  for (const char* text :
       {"rate_hz = 50", "rate_hz = 0", "frames_dropped = 1.1", "resting_offset = 2", "gain_error = 1.5",
        "noise = 1.5", "noise = nan", "noise_time_s = -1", "clock_drift_ppm = 20000", "lag_ms = [0, 2001]",
        "lag_ms = [2, 1]", "smoothing_ms = 3000", "delay_ms = [1, 5000]", "clock_offset_s = [2, 1]",
        "face_loss_s = [2, 1]", "face_lost_between_s = [24, 20]"})
    EXPECT_EQ(refused(text).code, ErrorCode::out_of_range) << text;
  EXPECT_THAT(refused("noise = 2").message(), HasSubstr("rig.toml"));
}

}  // namespace
}  // namespace mien::virt::phone_simulator_test
