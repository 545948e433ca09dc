#include "mien/virtual/eyewear/eyewear_simulator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "mien/builtin_face/builtin_face.h"
#include "tests/project_path.h"

namespace mien::virt::eyewear_simulator_test {
namespace {

using face::shape;

const sensor::Rig& rig() {
  static const sensor::Rig rig = sensor::read_rig(project_path("rigs/eyewear.toml")).value();
  return rig;
}

EyewearFaults faults() {
  return parse_eyewear_faults(rig().faults_toml, "rig").value();
}

const EyewearWearer& plain_wearer() {
  static const EyewearWearer wearer =
      seat_eyewear(builtin_face::make_builtin(), rig(), {}, Random(1)).value();
  return wearer;
}

std::size_t sensor_named(const char* name) {
  return rig().find(name).value();
}

TEST(EyewearRig, HasSixteenOnTheFrameAndFourOnTheHooks) {
  EXPECT_EQ(rig().sensors.size(), 20u);
  EXPECT_EQ(rig().face_sensors().size(), 20u);
  const auto hooks = std::ranges::count_if(rig().sensors, [](const sensor::Mount& mount) {
    return mount.site == "jaw_joint" || mount.site == "lower_jaw";
  });
  EXPECT_EQ(hooks, 4);
  for (const sensor::Mount& mount : rig().sensors) EXPECT_EQ(mount.kind, "eyewear");
}

TEST(EyewearWearer, EverySensorSeesSkinAtAWorkingDistance) {
  EyewearSimulator simulator(plain_wearer(), {}, Random(1));
  for (const double d : simulator.distances_m({})) {
    EXPECT_GE(d, 0.004 - 1e-4);
    EXPECT_LE(d, 0.016 + 1e-4);
  }
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const auto wearer = draw_eyewear_wearer(rig(), faults(), Random(seed));
    ASSERT_TRUE(wearer) << wearer.error().message();
    EyewearSimulator drawn(*wearer, {}, Random(1));
    for (const double d : drawn.distances_m({})) {
      EXPECT_GE(d, 0.004 - 1e-4);
      EXPECT_LE(d, 0.016 + 1e-4);
    }
  }
}

TEST(EyewearWearer, AnOpenJawKeepsTheSensorsBeneathItWhereTheOthersStand) {
  EyewearSimulator simulator(plain_wearer(), {}, Random(1));
  const std::size_t jaw_sensors = 2;  // The last ones.
  ASSERT_EQ(rig().sensors[rig().sensors.size() - jaw_sensors].site, "lower_jaw");
  const std::vector<double> rest_m = simulator.distances_m({});
  const auto [nearest_m, farthest_m] =
      std::ranges::minmax(std::span(rest_m).first(rest_m.size() - jaw_sensors));
  for (const float weight : {0.0F, 0.25F, 0.5F, 0.75F, 1.0F}) {
    face::BlendshapeWeights jaw;
    jaw[shape("jawOpen")] = weight;
    const std::vector<double> open_m = simulator.distances_m(jaw);
    for (const double d : std::span(open_m).last(jaw_sensors)) {
      EXPECT_GE(d, nearest_m) << weight;
      EXPECT_LE(d, farthest_m) << weight;
    }
  }
}

TEST(EyewearWearer, NeedsPlacesAndAims) {
  sensor::Rig blind = rig();
  blind.sensors[3].aim.reset();
  EXPECT_EQ(seat_eyewear(builtin_face::make_builtin(), blind, {}, Random(1)).error().code,
            ErrorCode::not_found);
  blind = rig();
  blind.sensors[3].aim = -*blind.sensors[3].aim;
  const auto away = seat_eyewear(builtin_face::make_builtin(), blind, {}, Random(1));
  ASSERT_FALSE(away);
  EXPECT_NE(away.error().what.find(blind.sensors[3].name), std::string::npos);
  face::Face face = builtin_face::make_builtin();
  face.has_landmarks = false;
  EXPECT_EQ(seat_eyewear(face, rig(), {}, Random(1)).error().code, ErrorCode::not_found);
}

TEST(EyewearSimulator, SensorsFeelTheSkinBeneathThem) {
  EyewearSimulator simulator(plain_wearer(), {}, Random(1));
  const std::vector<double> rest = simulator.reflected({});
  face::BlendshapeWeights cheeks, jaw;
  cheeks[shape("cheekSquint_L")] = 1;
  jaw[shape("jawOpen")] = 1;
  const std::vector<double> squint = simulator.reflected(cheeks);
  const std::vector<double> open = simulator.reflected(jaw);
  // A raised cheek comes nearer: brighter on its side, and nothing on the other.
  EXPECT_GT(squint[sensor_named("cheek_L")], 1.2 * rest[sensor_named("cheek_L")]);
  EXPECT_NEAR(squint[sensor_named("cheek_R")], rest[sensor_named("cheek_R")], 1e-3);
  // The hooks feel the jaw, the brows do not.
  EXPECT_GT(std::abs(open[sensor_named("jaw_lower_L")] / rest[sensor_named("jaw_lower_L")] - 1), 0.2);
  EXPECT_NEAR(open[sensor_named("brow_inner_L")], rest[sensor_named("brow_inner_L")], 1e-3);
  // And back.
  EXPECT_EQ(simulator.reflected({}), rest);
}

TEST(EyewearSimulator, AShiftTowardsTheFaceIsFelt) {
  EyewearSimulator simulator(plain_wearer(), {}, Random(1));
  const std::vector<double> before = simulator.distances_m({});
  EyewearSeat seat;
  seat.shift_m = Vec3(0, 0, -0.002);
  simulator.sit(seat);
  const std::vector<double> after = simulator.distances_m({});
  EXPECT_NEAR(before[sensor_named("brow_inner_L")] - after[sensor_named("brow_inner_L")], 0.002, 6e-4);
  seat = {};
  seat.tilt_rad = Vec3(0, 0.05, 0);
  simulator.sit(seat);
  EXPECT_NE(simulator.distances_m({}), before);
}

TEST(EyewearSimulator, PutsOnWithinTheFaultsAndNotIntoTheSkin) {
  EyewearSimulator simulator(plain_wearer(), faults(), Random(1));
  Vec3 last = Vec3::Zero();
  for (int i = 0; i < 20; ++i) {
    simulator.put_on();
    EXPECT_LE(simulator.seat().shift_m.norm(), 0.003 + 1e-9);
    EXPECT_LE(simulator.seat().tilt_rad.norm(), 5 * std::numbers::pi / 180 + 1e-9);
    EXPECT_NE(simulator.seat().shift_m, last);
    last = simulator.seat().shift_m;
    for (const double d : simulator.distances_m({})) EXPECT_GT(d, 0.001);
  }
}

TEST(EyewearSimulator, SamplesArePairsInTurn) {
  EyewearSimulator simulator(plain_wearer(), faults(), Random(1));
  const std::vector<sensor::Sample> samples = simulator.play(1, 10, {}, {});
  ASSERT_EQ(samples.size(), 200u);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i].kind, sensor::SampleKind::eyewear_light);
    EXPECT_EQ(samples[i].sensor, i % 20);
    EXPECT_EQ(samples[i].sequence, i / 20);
    ASSERT_EQ(samples[i].count, 2);
    for (const float value : samples[i].used()) {
      EXPECT_GE(value, 0);
      EXPECT_LE(value, 1);
    }
    if (i > 0) {
      EXPECT_GT(samples[i].time, samples[i - 1].time);
    }
  }
  const double true_s = simulator.clock().true_s(samples.back().time);
  EXPECT_NEAR(true_s, 1 + 10 * simulator.pair_period_s(), 2e-4);
}

TEST(EyewearSimulator, TheSameDrawsGiveTheSameSamples) {
  const auto play = [](std::uint64_t seed) {
    EyewearSimulator simulator(plain_wearer(), faults(), Random(seed));
    simulator.put_on();
    std::vector<float> values;
    for (int i = 0; i < 5; ++i)
      for (const sensor::Sample& sample : simulator.play(10.0 * i, 3, {}, {}))
        values.insert(values.end(), sample.used().begin(), sample.used().end());
    return values;
  };
  EXPECT_EQ(play(1), play(1));
  EXPECT_NE(play(1), play(2));
}

TEST(EyewearSimulator, TheBenchTellsDistancesBack) {
  EyewearSimulator simulator(plain_wearer(), {}, Random(1));
  const auto line = eyewear::Linearisation::fit(simulator.bench(0));
  ASSERT_TRUE(line) << line.error().message();
  for (const eyewear::BenchReading& reading : simulator.bench(0))
    if (reading.distance_m > 0.004) {
      EXPECT_NEAR(line->distance_m(reading.light), reading.distance_m, 2e-4);
    }
}

TEST(SkinPattern, VariesOverTheSkinByWhatIsAsked) {
  const SkinPattern pattern(0.1, 0.006, Random(3));
  Random random(4);
  double sum = 0, squares = 0;
  constexpr int kPoints = 4000;
  for (int i = 0; i < kPoints; ++i) {
    const double log = std::log(pattern.at(Vec3(random.uniform(), random.uniform(), random.uniform())));
    sum += log;
    squares += log * log;
  }
  EXPECT_NEAR(sum / kPoints, 0, 0.01);
  EXPECT_NEAR(std::sqrt(squares / kPoints), 0.1, 0.02);
  EXPECT_EQ(SkinPattern(0, 0.006, Random(3)).at(Vec3(0.1, 0, 0)), 1);
}

}  // namespace
}  // namespace mien::virt::eyewear_simulator_test
