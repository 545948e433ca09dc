#include "mien/sensor/ticks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "mien/core/random.h"

namespace mien::sensor::ticks_test {
namespace {

constexpr Duration kMs = std::chrono::milliseconds(1);

Rig rig_of(std::size_t count) {
  Rig rig;
  rig.name = "test";
  rig.reference = "s0";
  for (std::size_t i = 0; i < count; ++i) {
    Mount mount;
    mount.name = "s" + std::to_string(i);
    mount.kind = "imu";
    mount.role = i == 0 ? "head" : "face";
    rig.sensors.push_back(mount);
  }
  return rig;
}

struct Entry {
  HostTime arrival;
  std::vector<Sample> samples;
};

/// Packets of four samples at 240 Hz from each sensor, each with its own clock, through a radio.
std::vector<Entry> play(std::size_t sensors, double seconds, std::uint64_t seed,
                        double mean_delay_s = 0.003) {
  std::vector<Entry> entries;
  for (std::size_t s = 0; s < sensors; ++s) {
    Random random = Random(seed).fork("sensor", s);
    const double offset = random.uniform(0, 100);
    const double rate = 1 + random.normal(0, 20e-6);
    std::uint32_t sequence = 0;
    for (double t = random.uniform(0, 0.01); t < seconds; ++sequence) {
      Entry entry;
      for (int i = 0; i < 4; ++i, t += 1 / 240.0) {
        Sample sample;
        sample.sensor = static_cast<std::uint16_t>(s);
        sample.sequence = sequence;
        sample.time = DeviceTime(from_seconds(offset + rate * t));
        sample.count = 6;
        entry.samples.push_back(sample);
        entry.arrival = HostTime(from_seconds(t + 0.001));
      }
      entry.arrival += from_seconds(random.exponential(mean_delay_s));
      entries.push_back(entry);
    }
  }
  std::ranges::sort(entries, {}, [](const Entry& e) { return std::pair(e.arrival, e.samples[0].sensor); });
  return entries;
}

std::vector<FrameTick> run(const Rig& rig, const std::vector<Entry>& entries) {
  TickRule rule(rig);
  std::vector<FrameTick> ticks;
  for (const Entry& entry : entries) {
    while (const auto tick = rule.due(entry.arrival)) ticks.push_back(*tick);
    for (const Sample& sample : entry.samples) rule.add(entry.arrival, sample);
    while (const auto tick = rule.due(entry.arrival)) ticks.push_back(*tick);
  }
  return ticks;
}

TEST(Ticks, AreEveryFrameOfTheGridOnce) {
  const auto ticks = run(rig_of(12), play(12, 20, 1));
  ASSERT_GT(ticks.size(), 1180u);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    EXPECT_EQ(ticks[i].frame.time_since_epoch(), frame_offset(ticks[i].index));
    if (i == 0) continue;
    EXPECT_EQ(ticks[i].index, ticks[i - 1].index + 1);
    EXPECT_GE(ticks[i].fired, ticks[i - 1].fired);
  }
}

TEST(Ticks, FireWithTheSampleThatCompletesThem) {
  const auto ticks = run(rig_of(1), play(1, 10, 2, 0.0005));
  const auto complete =
      std::count_if(ticks.begin(), ticks.end(), [](const FrameTick& t) { return t.complete; });
  EXPECT_GT(static_cast<double>(complete), 0.99 * static_cast<double>(ticks.size()));
}

TEST(Ticks, DoNotWaitLongerThanEightMilliseconds) {
  // From the third second on sensor 1 answers half a second late: heard, but never in time.
  auto entries = play(2, 10, 3);
  for (Entry& entry : entries)
    if (entry.samples[0].sensor == 1 && entry.arrival.time_since_epoch() > std::chrono::seconds(3))
      entry.arrival += 300 * kMs;
  std::ranges::sort(entries, {}, [](const Entry& e) { return std::pair(e.arrival, e.samples[0].sensor); });
  TickRule rule(rig_of(2));
  std::vector<FrameTick> ticks;
  Duration worst{};
  for (const Entry& entry : entries) {
    while (const auto tick = rule.due(entry.arrival)) {
      // A frame, its packet's end and 8 ms.
      worst = std::max(worst, tick->fired - rule.lines().to_host(tick->frame));
      ticks.push_back(*tick);
    }
    for (const Sample& sample : entry.samples) rule.add(entry.arrival, sample);
  }
  EXPECT_GT(ticks.size(), 590u);
  EXPECT_LE(worst, 8 * kMs + Duration(16'700'000));
}

TEST(Ticks, GoOnWhenTheReferenceFallsSilent) {
  auto entries = play(3, 12, 4);
  std::erase_if(entries, [](const Entry& e) {
    return e.samples[0].sensor == 0 && e.arrival.time_since_epoch() > std::chrono::seconds(5);
  });
  const auto ticks = run(rig_of(3), entries);
  EXPECT_GT(ticks.size(), 715u);
  for (std::size_t i = 400; i < ticks.size(); ++i) {
    const Duration step = ticks[i].fired - ticks[i - 100].fired;
    EXPECT_NEAR(to_seconds(step), 100 / 60.0, 0.03);
  }
}

TEST(Ticks, RunOnTheHostsTimeWithoutAReference) {
  auto entries = play(3, 6, 5);
  std::erase_if(entries, [](const Entry& e) { return e.samples[0].sensor == 0; });
  const auto ticks = run(rig_of(3), entries);
  ASSERT_GT(ticks.size(), 310u);
  EXPECT_NEAR(to_seconds(ticks.back().frame.time_since_epoch()), 6.0, 0.1);
}

TEST(Ticks, TakeLabSamplesAtTheirOwnTime) {
  TickRule rule(rig_of(3));
  std::size_t ticks = 0;
  for (int i = 0; i < 100; ++i) {
    const HostTime arrival{frame_offset(i) + kMs};
    while (rule.due(arrival)) ++ticks;
    for (std::uint16_t s = 1; s < 3; ++s) {
      Sample sample;
      sample.sensor = s;
      sample.kind = SampleKind::imu_head_relative;
      sample.time = DeviceTime(frame_offset(i));
      rule.add(arrival, sample);
    }
    while (const auto tick = rule.due(arrival)) {
      EXPECT_TRUE(tick->complete);
      EXPECT_EQ(tick->frame, DeviceTime(frame_offset(i)));
      ++ticks;
    }
  }
  EXPECT_EQ(ticks, 100u);
}

TEST(Ticks, DependOnNothingButTheCalls) {
  const auto entries = play(4, 8, 6);
  EXPECT_EQ(run(rig_of(4), entries), run(rig_of(4), entries));
}

/// How many frames fire within a second of host time, at most.
std::size_t most_in_a_second(const std::vector<FrameTick>& ticks) {
  std::size_t most = 0, first = 0;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    while (ticks[i].fired - ticks[first].fired > std::chrono::seconds(1)) ++first;
    most = std::max(most, i - first + 1);
  }
  return most;
}

TEST(Ticks, AClockThatCreepsAheadMakesNoBacklog) {
  // Sixteen times as fast as time goes, in leaps that are each too small for a restart.
  std::vector<Entry> entries = play(3, 30, 5);
  for (Entry& entry : entries)
    for (Sample& sample : entry.samples)
      if (sample.sensor == 0) sample.time = DeviceTime(16 * sample.time.time_since_epoch());
  const auto ticks = run(rig_of(3), entries);
  EXPECT_GT(ticks.size(), 1500u);
  EXPECT_LE(ticks.size(), 30u * 62 + 61);
  EXPECT_LE(most_in_a_second(ticks), 123u);
  for (std::size_t i = 1; i < ticks.size(); ++i) ASSERT_GT(ticks[i].frame, ticks[i - 1].frame);
}

TEST(Ticks, ASilenceOfAllLeavesNoFrameOut) {
  std::vector<Entry> entries = play(3, 30, 6);
  std::erase_if(entries, [](const Entry& entry) {
    return entry.arrival > HostTime(std::chrono::seconds(10)) &&
           entry.arrival < HostTime(std::chrono::seconds(20));
  });
  // Nobody looked meanwhile: they fire with what comes next, each at its deadline.
  const auto ticks = run(rig_of(3), entries);
  EXPECT_GT(ticks.size(), 1770u);
  for (std::size_t i = 1; i < ticks.size(); ++i) ASSERT_EQ(ticks[i].index, ticks[i - 1].index + 1);
  EXPECT_LE(most_in_a_second(ticks), 70u);
}

/// What a network makes of entries: each comes later by what `delay` draws.
std::vector<Entry> delayed(std::vector<Entry> entries, const std::function<double(Random&)>& delay_s) {
  Random random(17);
  for (Entry& entry : entries) entry.arrival += from_seconds(delay_s(random));
  std::ranges::sort(entries, {}, [](const Entry& e) { return std::pair(e.arrival, e.samples[0].sensor); });
  return entries;
}

double up_to_100_ms(Random& random) {
  return random.uniform(0, 0.1);
}

Duration longest_hold(const std::vector<Entry>& entries) {
  TickRule rule(rig_of(12));
  for (const Entry& entry : entries) {
    while (rule.due(entry.arrival)) continue;
    for (const Sample& sample : entry.samples) rule.add(entry.arrival, sample);
    while (rule.due(entry.arrival)) continue;
  }
  return rule.hold().longest();
}

TEST(Ticks, AreNotHeldWhileArrivalsArePunctual) {
  const std::vector<Entry> good = play(12, 40, 7);
  EXPECT_EQ(longest_hold(good), Duration::zero());

  std::vector<Entry> lossy = good;
  Random random(18);
  std::erase_if(lossy, [&](const Entry&) { return random.chance(0.2); });
  EXPECT_EQ(longest_hold(lossy), Duration::zero());

  EXPECT_EQ(longest_hold(delayed(good, [](Random&) { return 0.1; })), Duration::zero()) << "lag";

  // Crystals that are 90 ppm off, each its own way.
  std::vector<Entry> drifting = good;
  for (Entry& entry : drifting)
    for (Sample& sample : entry.samples)
      sample.time += (sample.sensor % 2 == 0 ? 1 : -1) * (entry.arrival.time_since_epoch() / 1'000'000 * 90);
  EXPECT_EQ(longest_hold(drifting), Duration::zero());

  // The whole mask is switched off and on.
  std::vector<Entry> restarted = good;
  std::erase_if(restarted, [](const Entry& entry) {
    return entry.arrival > HostTime(std::chrono::seconds(20)) &&
           entry.arrival < HostTime(std::chrono::seconds(22));
  });
  for (Entry& entry : restarted)
    if (entry.arrival > HostTime(std::chrono::seconds(20)))
      for (Sample& sample : entry.samples) {
        sample.time -= std::chrono::seconds(19);
        sample.sequence -= 900;
      }
  EXPECT_EQ(longest_hold(restarted), Duration::zero());
}

/// Of the packets that a sensor had sent up to each frame, the share that had come when it fired: from the
/// fifth second on.
double share_there(const std::vector<Entry>& entries, Duration& latest) {
  TickRule rule(rig_of(12));
  std::vector<std::size_t> came(12);
  std::size_t there = 0, all = 0;
  latest = {};
  for (const Entry& entry : entries) {
    const auto fire = [&] {
      while (const auto tick = rule.due(entry.arrival)) {
        if (entry.arrival < HostTime(std::chrono::seconds(5))) continue;
        latest = std::max(latest, tick->fired - rule.lines().to_host(tick->frame));
        for (const Entry& sent : entries) {
          const Sample& last = sent.samples.back();
          const Duration before = tick->frame - rule.lines().to_line(last.sensor, last.time);
          if (before < Duration::zero() || before > 100 * kMs) continue;
          ++all;
          there += sent.arrival <= tick->fired ? 1 : 0;
        }
      }
    };
    fire();
    for (const Sample& sample : entry.samples) rule.add(entry.arrival, sample);
    fire();
  }
  return static_cast<double>(there) / static_cast<double>(all);
}

TEST(Ticks, AreHeldWhilePacketsComeLate) {
  const std::vector<Entry> late = delayed(play(12, 8, 8), up_to_100_ms);
  EXPECT_EQ(longest_hold(late), ArrivalHold::kMost);
  Duration latest{};
  // Of what was sent in the 100 ms before: without a hold not two thirds.
  EXPECT_GT(share_there(late, latest), 0.9);
  EXPECT_LE(latest, 68 * kMs + Duration(16'700'000));
  const auto ticks = run(rig_of(12), late);
  EXPECT_GT(ticks.size(), 460u);
  for (std::size_t i = 1; i < ticks.size(); ++i) {
    ASSERT_EQ(ticks[i].index, ticks[i - 1].index + 1);
    ASSERT_GE(ticks[i].fired, ticks[i - 1].fired);
  }
  EXPECT_EQ(ticks, run(rig_of(12), late)) << "by nothing but the calls";
}

TEST(Ticks, AreHeldNoLongerThanUntilAllIsThere) {
  std::vector<Entry> entries = play(3, 20, 9, 0.0005);
  Random random(19);
  for (Entry& entry : entries)
    if (entry.arrival < HostTime(std::chrono::seconds(6)))
      entry.arrival += from_seconds(random.uniform(0, 0.1));
  // A packet that is missing in the middle is waited for, though newer ones are there.
  constexpr Duration kAway = 50 * kMs;
  const HostTime away(std::chrono::milliseconds(7500));
  const auto missing = std::ranges::find_if(
      entries, [&](const Entry& e) { return e.samples[0].sensor == 1 && e.arrival > away; });
  const HostTime came = missing->arrival += kAway;
  std::ranges::sort(entries, {}, [](const Entry& e) { return std::pair(e.arrival, e.samples[0].sensor); });
  TickRule rule(rig_of(3));
  std::size_t at_once = 0, waited = 0, all = 0;
  for (const Entry& entry : entries) {
    const auto fire = [&] {
      while (const auto tick = rule.due(entry.arrival)) {
        if (tick->fired < HostTime(std::chrono::seconds(7)) ||
            tick->fired > HostTime(std::chrono::seconds(12)))
          continue;
        EXPECT_GT(rule.hold().now(), 20 * kMs);
        const Duration after = tick->fired - rule.lines().to_host(tick->frame);
        ++all;
        at_once += after < 20 * kMs ? 1 : 0;
        if (after < 20 * kMs) continue;
        ++waited;
        EXPECT_LE(tick->fired, came);
        EXPECT_TRUE(tick->complete);
      }
    };
    fire();
    for (const Sample& sample : entry.samples) rule.add(entry.arrival, sample);
    fire();
  }
  EXPECT_EQ(at_once + waited, all);
  EXPECT_GE(waited, 2u);
  EXPECT_LE(waited, 5u);
}

}  // namespace
}  // namespace mien::sensor::ticks_test
