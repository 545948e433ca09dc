#include "mien/phone/time_alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mien/core/random.h"
#include "mien/core/rotation.h"
#include "mien/core/time.h"

// A phone whose clock has nothing to do with the sensors', before a face that both of them know.
namespace mien::phone::time_alignment_test {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kJaw = face::shape("jawOpen"), kSmile = face::shape("mouthSmile_L");
constexpr std::size_t kSensors = 3;

/// A performer whose jaw and smile move as speech does, smoothly and never the same twice; another one by
/// another seed.
class Performer {
 public:
  explicit Performer(std::uint64_t seed) {
    Random random(seed);
    for (Wave& wave : waves_)
      wave = {random.uniform(0.4, 4), random.uniform(0, 6.28), random.uniform(0.1, 0.4)};
  }
  [[nodiscard]] double jaw(double time_s) const { return value(0, time_s); }
  [[nodiscard]] double smile(double time_s) const { return value(kWaves / 2, time_s); }

 private:
  static constexpr std::size_t kWaves = 24;
  struct Wave {
    double hz = 0, phase = 0, size = 0;
  };
  [[nodiscard]] double value(std::size_t first, double time_s) const {
    double sum = 0.3;
    for (std::size_t w = first; w < first + kWaves / 2; ++w)
      sum += 0.15 * waves_[w].size * std::sin(6.28 * waves_[w].hz * time_s + waves_[w].phase);
    return sum;
  }
  std::array<Wave, kWaves> waves_;
};

/// Skin that turns with jaw and smile, as late as sensors on it do, and by `noise_rad` of its own.
std::vector<model::FeatureFrame> skin(const Performer& performer, double seconds, double noise_rad = 0.01) {
  Random random(99);
  std::vector<model::FeatureFrame> frames;
  for (int f = 0; f < seconds * kFrameRateHz; ++f) {
    const double time_s = f / kFrameRateHz - kSkinLagS;
    model::FeatureFrame& frame = frames.emplace_back();
    frame.time = DeviceTime(from_seconds(100) + frame_offset(f));
    for (std::size_t s = 0; s < kSensors; ++s) {
      const auto share = static_cast<double>(s) / kSensors;
      const Vec3 turn(0.3 * performer.jaw(time_s) * (1 - share) + random.normal(0, noise_rad),
                      0.2 * performer.smile(time_s) * share + random.normal(0, noise_rad),
                      random.normal(0, noise_rad));
      const Quat q = exp_rotation(turn);
      frame.sensors.push_back({.rotation = {static_cast<float>(q.w()), static_cast<float>(q.x()),
                                            static_cast<float>(q.y()), static_cast<float>(q.z())},
                               .has_rotation = true});
    }
  }
  return frames;
}

/// Who filmed the performer from `from_s` on, with a clock that is slow by `drift_ppm`.
face::Motion filmed(const Performer& performer, double from_s, double seconds, double drift_ppm = 0) {
  face::Motion told{.name = "a phone", .frames = {}};
  for (int f = 0; f < seconds * 60; ++f) {
    face::MotionFrame& frame = told.frames.emplace_back();
    frame.time_s = f / 60.0;
    const double true_s = from_s + frame.time_s * (1 + 1e-6 * drift_ppm);
    frame.weights[kJaw] = static_cast<float>(performer.jaw(true_s));
    frame.weights[kSmile] = static_cast<float>(0.8 * performer.smile(true_s));
  }
  return told;
}

TEST(TimeAlignment, FindsOffsetAndDriftAnywhere) {
  const Performer performer(1);
  const auto felt = skin(performer, 120);
  for (const double from_s : {-7.3137, 0.0, 31.0042}) {
    const face::Motion told = filmed(performer, from_s, 80, 40);
    const auto found = align(felt, told, std::nullopt);
    ASSERT_TRUE(found) << found.error().message();
    // Where the phone's time p = middle - offset stands.
    const double phone_s = found->middle_s - found->offset_s;
    EXPECT_NEAR(found->middle_s, from_s + phone_s * (1 + 40e-6), 1e-3) << from_s;
    EXPECT_NEAR(found->drift_ppm, 40, 3 * found->drift_sigma_ppm + 1);
    EXPECT_LT(found->offset_sigma_s, 3e-3);
    EXPECT_GT(found->agreement, 0.8);
    EXPECT_GE(found->blocks.size(), 4U);
    for (const AlignmentBlock& block : found->blocks) EXPECT_LT(std::abs(block.residual_s), 5e-3);
  }
}

TEST(TimeAlignment, BelievesWhatItIsToldBefore) {
  const Performer performer(2);
  const auto felt = skin(performer, 60);
  const face::Motion told = filmed(performer, 3, 40);
  const auto near = align(felt, told, AlignmentPrior{.offset_s = 3.2, .offset_window_s = 1});
  ASSERT_TRUE(near) << near.error().message();
  EXPECT_NEAR(near->offset_s, 3, 2e-3);
  // Within a window that it is not in nothing agrees.
  const auto far = align(felt, told, AlignmentPrior{.offset_s = 8, .offset_window_s = 1});
  ASSERT_FALSE(far) << far->agreement << " at " << far->offset_s;
  EXPECT_EQ(far.error().code, ErrorCode::mismatch);
}

TEST(TimeAlignment, SurvivesLostFacesAndSensors) {
  const Performer performer(3);
  auto felt = skin(performer, 60);
  for (std::size_t f = 600; f < 900; ++f) felt[f].sensors[1] = {};
  // A calibration that takes long.
  for (std::size_t f = 0; f < 1'000; ++f)
    for (model::SensorFeature& sensor : felt[f].sensors) sensor = {};
  for (model::FeatureFrame& frame : felt) frame.sensors[2] = {};  // Never there.
  face::Motion told = filmed(performer, 5, 50);
  for (face::MotionFrame& frame : told.frames)
    if (frame.time_s > 20 && frame.time_s < 24) frame.has_face = false;
  Random random(4);
  std::erase_if(told.frames, [&](const face::MotionFrame& frame) {
    return frame.time_s > 0 && random.uniform(0, 1) < 0.1;
  });
  const auto found = align(felt, told, std::nullopt);
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_NEAR(found->offset_s, 5, 3e-3);
}

TEST(TimeAlignment, RefusesSomebodyElse) {
  const auto felt = skin(Performer(1), 90);
  const auto refused = align(felt, filmed(Performer(7), 4, 80), std::nullopt);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::mismatch);
  EXPECT_THAT(refused.error().message(), HasSubstr("a phone"));
}

TEST(TimeAlignment, SaysWhatIsTooLittle) {
  const Performer performer(1);
  const auto felt = skin(performer, 60);
  const auto code = [&](std::span<const model::FeatureFrame> frames, const face::Motion& told) {
    const auto refused = align(frames, told, std::nullopt);
    return refused ? ErrorCode::internal : refused.error().code;
  };
  EXPECT_EQ(code(felt, filmed(performer, 5, 8)), ErrorCode::not_found);
  EXPECT_EQ(code(felt, {.name = "nothing", .frames = {}}), ErrorCode::not_found);
  EXPECT_EQ(code({}, filmed(performer, 5, 50)), ErrorCode::not_found);
  face::Motion still = filmed(performer, 5, 50);
  for (face::MotionFrame& frame : still.frames) frame.weights = {};
  EXPECT_EQ(code(felt, still), ErrorCode::not_found);
  face::Motion blind = filmed(performer, 5, 50);
  for (face::MotionFrame& frame : blind.frames) frame.has_face = false;
  EXPECT_EQ(code(felt, blind), ErrorCode::not_found);
  auto lost = felt;
  for (model::FeatureFrame& frame : lost)
    for (model::SensorFeature& sensor : frame.sensors) sensor = {};
  EXPECT_EQ(code(lost, filmed(performer, 5, 50)), ErrorCode::not_found);
}

}  // namespace
}  // namespace mien::phone::time_alignment_test
