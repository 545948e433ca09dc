#include "mien/solve/phone_truth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/builtin_face/load_face.h"
#include "mien/core/random.h"
#include "mien/model/model_file.h"
#include "mien/performer/script.h"
#include "mien/solve/trace_features.h"
#include "mien/virtual/stage.h"
#include "tests/project_path.h"

// A virtual phone before a virtual wearer of the default rig: its truth beside the performer's own.
namespace mien::solve::phone_truth_test {
namespace {

struct Filmed {
  sensor::Rig rig;
  virt::VirtualSession session;
  std::vector<model::FeatureFrame> features;
};

Filmed filmed(const virt::PhoneFaults& phone, double seconds = 40) {
  virt::StageRequest request;
  request.script = performer::default_script(performer::Block::reading, seconds);
  request.rig = project_path("rigs/default.toml");
  request.seed = 5;
  request.phone = true;
  request.phone_faults = phone;
  virt::Stage stage = virt::set_stage(request).value();
  Filmed out;
  out.session = virt::play(stage).value();
  out.rig = std::move(stage.rig);
  out.features = trace_features(out.rig, out.session.events, out.session.entries, out.session.ticks).value();
  return out;
}

Result<PhoneTrack> track_of(const Filmed& take) {
  return phone_track(take.rig, take.session.samples, take.features.front().time);
}

/// Root mean square of what the phone's truth is off, over the frames that both know.
double off(const Filmed& take, const PhoneTruth& truth) {
  double sum = 0, count = 0;
  for (std::size_t f = 0; f < truth.frames.size(); ++f) {
    const take::TruthFrame& real = take.session.truth[f];
    if (!truth.frames[f].evaluated || !real.evaluated) continue;
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      sum += std::pow(double{truth.frames[f].weights[k]} - std::clamp(double{real.weights[k]}, 0.0, 1.0), 2);
    count += static_cast<double>(face::kShapeCount);
  }
  EXPECT_GT(count, 0);
  return std::sqrt(sum / count);
}

TEST(PhoneTruth, StandsBesideThePerformersOwn) {
  virt::PhoneFaults phone;
  phone.clock_offset_s = {5'000, 5'000};
  phone.lag_ms = {30, 30};
  phone.delay_ms = {60, 120};
  phone.resting_offset = 0.1;
  phone.frames_dropped = 0.1;
  phone.face_lost_between_s = {12, 15};
  const Filmed take = filmed(phone);
  const auto track = track_of(take);
  ASSERT_TRUE(track) << track.error().message();
  ASSERT_TRUE(track->prior);
  EXPECT_EQ(track->left_out_s, 0);
  const auto truth = phone_truth(take.session.events, take.features, *track);
  ASSERT_TRUE(truth) << truth.error().message();
  ASSERT_EQ(truth->frames.size(), take.features.size());
  EXPECT_GT(truth->alignment.agreement, 0.5);
  EXPECT_LT(off(take, *truth), 0.03);
  // Three seconds without a face are no truth; the calibration is none either.
  const auto known = std::ranges::count_if(truth->frames, &take::TruthFrame::evaluated);
  const auto seen = std::ranges::count_if(truth->frames, &take::TruthFrame::has_face);
  EXPECT_LT(known, seen);
  EXPECT_NEAR(static_cast<double>(truth->frames.size() - static_cast<std::size_t>(seen)), 180, 60);
  // What rests on the phone's face is told from the neutral hold.
  ASSERT_TRUE(truth->rest);
  EXPECT_GT(*std::ranges::max_element(truth->rest->values), 0.05F);
}

/// Three taps on the chin, whose moments are the sensors' time in s: in every sensor's acceleration, and as a
/// push of the jaw. (A virtual performer does not tap, so they are drawn here.)
void tap(Filmed& take, PhoneTrack& track, double phone_at_s, std::span<const double> taps) {
  constexpr std::size_t kJaw = face::shape("jawOpen");
  const auto pulse = [](double off_s) { return std::exp(-0.5 * off_s * off_s / (0.02 * 0.02)); };
  const auto around = [&](double time_s) { return time_s > taps.front() - 2 && time_s < taps.back() + 2; };
  for (model::FeatureFrame& frame : take.features) {
    const double time_s = to_seconds(frame.time - take.features.front().time);
    if (!around(time_s)) continue;
    for (model::SensorFeature& sensor : frame.sensors) {
      sensor.accel_m_s2.setZero();
      for (const double at : taps) sensor.accel_m_s2.z() += static_cast<float>(12 * pulse(time_s - at));
    }
  }
  for (face::MotionFrame& frame : track.motion.frames) {
    if (!around(frame.time_s + phone_at_s)) continue;
    frame.weights[kJaw] = 0.1F;
    for (const double at : taps)
      frame.weights[kJaw] += static_cast<float>(0.1 * pulse(frame.time_s + phone_at_s - at));
  }
}

TEST(PhoneTruth, OfAFileBeginsWithTapsAndElseAnywhere) {
  Filmed take = filmed({});
  PhoneTrack track = track_of(take).value();
  const auto by_arrivals = phone_truth(take.session.events, take.features, track);
  ASSERT_TRUE(by_arrivals) << by_arrivals.error().message();
  EXPECT_EQ(by_arrivals->guess, FirstGuess::arrivals);
  track.prior.reset();  // As of a file.
  const auto anywhere = phone_truth(take.session.events, take.features, track);
  ASSERT_TRUE(anywhere) << anywhere.error().message();
  EXPECT_EQ(anywhere->guess, FirstGuess::none);
  const double offset_s = by_arrivals->alignment.offset_s;
  EXPECT_NEAR(anywhere->alignment.offset_s, offset_s, 5e-3);

  const double begin_s = offset_s + track.motion.duration_s() - 10;
  const std::array<double, 3> taps = {begin_s, begin_s + 0.35, begin_s + 0.8};
  PhoneTrack tapped = track;
  tap(take, tapped, offset_s, taps);
  const auto by_taps = phone_truth(take.session.events, take.features, tapped);
  ASSERT_TRUE(by_taps) << by_taps.error().message();
  EXPECT_EQ(by_taps->guess, FirstGuess::taps);
  EXPECT_NEAR(by_taps->alignment.offset_s, offset_s, 10e-3);
  // Taps of something else, three seconds off: what the face says is believed.
  PhoneTrack wrongly = track;
  tap(take, wrongly, offset_s + 3, taps);
  const auto despite = phone_truth(take.session.events, take.features, wrongly);
  ASSERT_TRUE(despite) << despite.error().message();
  EXPECT_EQ(despite->guess, FirstGuess::none);
  EXPECT_NEAR(despite->alignment.offset_s, offset_s, 10e-3);
}

TEST(PhoneTruth, ALeapOfItsClockLeavesTheLongestStretch) {
  Filmed take = filmed({}, 30);
  const auto truths = std::ranges::find_if(take.rig.sensors, &sensor::Mount::is_truth);
  const auto phone = static_cast<std::uint16_t>(truths - take.rig.sensors.begin());
  const HostTime leap = take.session.samples.back().arrival - std::chrono::seconds(10);
  for (take::StoredSample& stored : take.session.samples)
    if (stored.sample.sensor == phone && stored.arrival > leap) stored.sample.time += std::chrono::hours(1);
  const auto track = track_of(take);
  ASSERT_TRUE(track) << track.error().message();
  EXPECT_NEAR(track->left_out_s, 10, 1);
  const auto truth = phone_truth(take.session.events, take.features, *track);
  ASSERT_TRUE(truth) << truth.error().message();
  EXPECT_LT(off(take, *truth), 0.03);
}

/// Two minutes of packets of a phone, whose clock is slow by `slow_ppm`, and of the sensors: when they came.
/// The phone's least delay wanders by so much.
std::vector<take::StoredSample> arrived(const sensor::Rig& rig, Random random, double slow_ppm,
                                        double wanders_s) {
  const auto phone = static_cast<std::uint16_t>(std::ranges::find_if(rig.sensors, &sensor::Mount::is_truth) -
                                                rig.sensors.begin());
  std::vector<take::StoredSample> samples;
  HostTime newest{};
  for (std::uint32_t f = 0; f < 7'200; ++f) {
    const double true_s = 10 + f / 60.0;
    const auto send = [&](std::uint16_t sensor, double time_s, HostTime arrival) {
      sensor::Sample sample{.sensor = sensor, .sequence = f, .time = DeviceTime(from_seconds(time_s))};
      samples.push_back({static_cast<std::int64_t>(samples.size()) + 1, arrival, sample});
    };
    send(*rig.find(rig.reference), true_s,
         HostTime(from_seconds(true_s + 0.001 + std::abs(random.normal(0, 0.003)))));
    // No packet overtakes another.
    const double delay_s = random.uniform(0.06, 0.12) + wanders_s * std::abs(std::sin(true_s / 9));
    newest = std::max(newest, HostTime(from_seconds(true_s + delay_s)));
    send(phone, 5'000 + true_s * (1 - 1e-6 * slow_ppm), newest);
  }
  return samples;
}

TEST(PhoneTruth, ArrivalsTellDriftAsWellAsTheyScatter) {
  virt::StageRequest request;
  request.script = performer::default_script(performer::Block::reading, 10);
  request.rig = project_path("rigs/default.toml");
  request.phone = true;
  const sensor::Rig rig = virt::set_stage(request).value().rig;
  double steady_ppm = 0, wandering_ppm = 0;
  constexpr int kPhones = 10;
  for (std::uint64_t seed = 0; seed < kPhones; ++seed) {
    const auto prior = [&](double wanders_s) {
      const auto samples = arrived(rig, Random(seed), 25, wanders_s);
      return *phone_track(rig, samples, DeviceTime(from_seconds(10))).value().prior;
    };
    const phone::AlignmentPrior steady = prior(0), wandering = prior(0.01);
    EXPECT_NEAR(steady.drift_ppm, 25, 4 * steady.drift_sigma_ppm) << seed;
    EXPECT_NEAR(steady.drift_ppm, 25, 15) << seed;
    steady_ppm += steady.drift_sigma_ppm / kPhones;
    wandering_ppm += wandering.drift_sigma_ppm / kPhones;
  }
  EXPECT_LT(steady_ppm, 8);
  EXPECT_GT(wandering_ppm, 1.5 * steady_ppm);
}

TEST(PhoneTruth, IsNeitherAnothersNorNobodys) {
  const Filmed take = filmed({}, 30);
  sensor::Rig without = take.rig;
  std::erase_if(without.sensors, [](const sensor::Mount& mount) { return mount.is_truth(); });
  const auto refused = phone_track(without, take.session.samples, take.features.front().time);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::not_found);
  const auto silent = phone_track(take.rig, {}, take.features.front().time);
  ASSERT_FALSE(silent);
  EXPECT_EQ(silent.error().code, ErrorCode::not_found);
  // One who says other things.
  PhoneTrack other = track_of(take).value();
  const std::size_t count = other.motion.frames.size();
  for (std::size_t f = 0; f < count / 2; ++f)
    std::swap(other.motion.frames[f].weights, other.motion.frames[count - 1 - f].weights);
  const auto disagrees = phone_truth(take.session.events, take.features, other);
  ASSERT_FALSE(disagrees);
  EXPECT_EQ(disagrees.error().code, ErrorCode::mismatch);
}

}  // namespace
}  // namespace mien::solve::phone_truth_test
