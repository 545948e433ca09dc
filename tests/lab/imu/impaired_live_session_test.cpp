// A session behind bad networks and devices in trouble: impair() feeds it as a socket would.

#include <gtest/gtest.h>

#include <iostream>

#include "lab/imu/impair.h"
#include "tests/session/session_run.h"

namespace mien::lab::impaired_live_session_test {
namespace {

namespace test = session::test;
using face::Provenance;
using face::shape;
using test::kPrologue_s;
using test::Played;

struct Case {
  const char* name;
  virt::NetworkSettings network;
  virt::DeviceTroubles troubles;
  double largest_step = 0.2;   ///< Between frames, of any weight; the face itself makes up to 0.08.
  double largest_error = 0.1;  ///< RMS of jawOpen against the truth, from a second after the prologue.
  bool calibrates = true;      ///< Else headings may not be found through such a network, and that is said.
};

virt::NetworkSettings with(auto&&... change) {
  virt::NetworkSettings settings;
  (change(settings), ...);
  return settings;
}
auto loss(double share) {
  return [share](virt::NetworkSettings& s) { s.loss = share; };
}
auto jitter(double ms) {
  return [ms](virt::NetworkSettings& s) { s.jitter_ms = ms; };
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const double share : {0.0, 0.02, 0.05, 0.1, 0.2}) {
    static const std::array kNames = {"loss 0", "loss 2", "loss 5", "loss 10", "loss 20"};
    all.push_back({kNames[all.size()], with(loss(share)), {}, share < 0.1 ? 0.2 : 0.6});
  }
  all.push_back(
      {"bursts", with([](auto& s) { s.burst_share = 0.05, s.burst_length = 10; }), {}, 0.6, 1.0, false});
  all.push_back({"lag", with([](auto& s) { s.lag_ms = 100; }), {}});
  all.push_back({"jitter 20", with(jitter(20)), {}, 0.2, 0.02});
  all.push_back({"jitter 100", with(jitter(100)), {}, 0.5, 0.1, false});
  all.push_back({"doubled", with([](auto& s) { s.duplicated = 0.3, s.jitter_ms = 10; }), {}, 0.25, 0.2});
  all.push_back({"corrupted", with([](auto& s) { s.corrupted = 0.1, s.truncated = 0.1; }), {}, 0.25, 0.15});
  virt::DeviceTroubles drift;
  drift.clocks = {{0, 50, 500, 10}, {1, -50, -500, 7}, {2, 50, 500, 9}};
  all.push_back({"drift and steps", {}, drift});
  virt::DeviceTroubles restart;
  restart.restarts = {{0, kPrologue_s + 3, 1.5}};
  all.push_back({"restart", {}, restart, 0.3, 0.35});
  virt::DeviceTroubles reference;
  reference.restarts = {{2, kPrologue_s + 3, 1.5}};
  all.push_back({"reference restarts", {}, reference, 0.4, 0.4});
  virt::DeviceTroubles mask;
  mask.restarts = {{0, kPrologue_s + 3, 1.5}, {1, kPrologue_s + 3, 1.5}, {2, kPrologue_s + 3, 1.5}};
  all.push_back({"the whole mask restarts", {}, mask, 0.4, 0.4});
  virt::DeviceTroubles shared;
  shared.shared_ids = {{1, 0}};
  all.push_back({"two with one id", {}, shared, 1.0, 1.0});
  return all;
}

TEST(SessionBehindANetwork, StaysSoundWhateverItDoes) {
  const virt::VirtualSession performed = test::performance(20);
  const sensor::Rig rig = virt::test::three_sensors();
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const auto worse = impair(performed, rig, c.network, Random(9), c.troubles);
    ASSERT_TRUE(worse) << worse.error().message();
    const auto session = test::session();
    const Played played = test::run(*session, worse->entries);
    test::expect_sound(played);
    ASSERT_GT(played.frames.size(), 1700u);

    std::map<DeviceTime, const take::TruthFrame*> truth;
    for (const take::TruthFrame& t : worse->truth) truth.emplace(t.time, &t);
    double square = 0;
    std::size_t count = 0, measured = 0;
    for (const Played::Frame& f : played.frames) {
      if (to_seconds(f.tick.fired.time_since_epoch()) < kPrologue_s + 1) continue;
      measured += f.frame.provenance[shape("jawOpen")] == Provenance::measured ? 1 : 0;
      const auto found = truth.find(f.tick.frame);
      if (found == truth.end() || !found->second->evaluated) continue;
      const double error = f.frame.weights[shape("jawOpen")] - found->second->weights[shape("jawOpen")];
      square += error * error;
      ++count;
    }
    const double rms = count > 0 ? std::sqrt(square / static_cast<double>(count)) : 0;
    const double step = test::largest_step(played, kPrologue_s);
    std::cout << c.name << ": jawOpen " << rms << " RMS over " << count << " frames, largest step " << step
              << ", calibrations " << session->versions().size() << "\n";
    if (c.calibrates)
      EXPECT_GE(session->versions().size(), 1u) << played.report.calibration.prompt;
    else
      EXPECT_TRUE(!session->versions().empty() || !played.report.calibration.prompt.empty());
    EXPECT_LE(step, c.largest_step);
    EXPECT_LE(rms, c.largest_error);
    // Whatever happened in between, at the end the face is measured.
    if (c.calibrates) {
      EXPECT_EQ(played.frames.back().frame.provenance[shape("jawOpen")], Provenance::measured);
    }
    if (std::string_view(c.name).starts_with("loss")) {
      EXPECT_GT(count, 1000u);
      EXPECT_GT(measured, 1000u);
    }
    // The same log again: the same bits.
    const auto again = test::session();
    EXPECT_EQ(test::run(*again, worse->entries).hash, played.hash);
  }
}

/// RMS of jawOpen against the truth, from two seconds after the prologue.
double jaw_error(const virt::VirtualSession& performed, const Played& played) {
  std::map<DeviceTime, const take::TruthFrame*> truth;
  for (const take::TruthFrame& t : performed.truth) truth.emplace(t.time, &t);
  double square = 0;
  std::size_t count = 0;
  for (const Played::Frame& f : played.frames) {
    const auto found = truth.find(f.tick.frame);
    if (to_seconds(f.tick.fired.time_since_epoch()) < kPrologue_s + 2 || found == truth.end() ||
        !found->second->evaluated)
      continue;
    const double error = f.frame.weights[shape("jawOpen")] - found->second->weights[shape("jawOpen")];
    square += error * error;
    ++count;
  }
  EXPECT_GT(count, 800u);
  return std::sqrt(square / static_cast<double>(count));
}

TEST(SessionBehindANetwork, FramesAreHeldForLatePacketsAndTheHoldIsSaid) {
  const virt::VirtualSession performed = test::performance(20);
  const sensor::Rig rig = virt::test::three_sensors();
  const Played clean = test::run(*test::session(), performed.entries);
  EXPECT_EQ(clean.report.longest_hold, Duration::zero());
  // From 0 to 100 ms on every packet.
  const virt::NetworkSettings late =
      with([](auto& s) { s.jitter_ms = 50, s.jitter = virt::NetworkSettings::Jitter::uniform; });
  const auto worse = impair(performed, rig, late, Random(9)).value();
  const Played played = test::run(*test::session(), worse.entries);
  test::expect_sound(played);
  EXPECT_GE(played.report.hold, std::chrono::milliseconds(50));
  EXPECT_EQ(played.report.longest_hold, std::chrono::milliseconds(60));
  const double error = jaw_error(worse, played), clean_error = jaw_error(performed, clean);
  std::cout << "jawOpen " << clean_error << " RMS, 0 to 100 ms late " << error << "\n";
  EXPECT_LE(error, clean_error + 0.01) << "a hundredth of the jaw's way";
}

TEST(SessionBehindANetwork, AFrozenSensorIsSaid) {
  const virt::VirtualSession performed = test::performance(8);
  virt::DeviceTroubles frozen;
  frozen.frozen = {{0, kPrologue_s + 2, 100}};
  const auto worse = impair(performed, virt::test::three_sensors(), {}, Random(9), frozen).value();
  const auto session = test::session();
  const Played played = test::run(*session, worse.entries);
  test::expect_sound(played);
  EXPECT_EQ(played.report.links[0].health.state, sensor::LinkState::frozen);
  EXPECT_EQ(played.report.links[1].health.state, sensor::LinkState::good);
}

TEST(SessionBehindANetwork, ALostSensorIsNeverGreen) {
  const virt::VirtualSession performed = test::performance(6);
  virt::DeviceTroubles silent;
  silent.silences = {{std::uint16_t{1}, kPrologue_s + 2, 100}};
  const auto worse = impair(performed, virt::test::three_sensors(), {}, Random(9), silent).value();
  const Played played = test::run(*test::session(), worse.entries);
  EXPECT_EQ(played.report.links[1].health.state, sensor::LinkState::lost);
  EXPECT_EQ(played.count("sensor_lost"), 1u);
}

}  // namespace
}  // namespace mien::lab::impaired_live_session_test
