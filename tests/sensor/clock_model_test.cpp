#include "mien/sensor/clock_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/core/random.h"

namespace mien::sensor::clock_model_test {
namespace {

/// A device whose clock reads offset + rate * true time, heard through a radio that only delays.
struct Device {
  double offset_s = 12.5;
  double rate = 1 + 30e-6;
  double least_delay_s = 0.001;
  double mean_delay_s = 0.003;

  [[nodiscard]] DeviceTime clock(double true_s) const {
    return DeviceTime(from_seconds(offset_s + rate * true_s));
  }
  HostTime arrival(double true_s, Random& random) const {
    return HostTime(from_seconds(true_s + least_delay_s + random.exponential(mean_delay_s)));
  }
};

TEST(ClockModel, FindsOffsetAndRateUnderRadioDelay) {
  for (const double ppm : {-50.0, -20.0, 0.0, 20.0, 50.0}) {
    Random random(7);
    Device device;
    device.rate = 1 + 1e-6 * ppm;
    ClockModel model;
    for (int i = 0; i < 60 * 90; ++i) {
      const double t = i / 60.0;
      model.add(device.clock(t), device.arrival(t, random));
      if (t < 1) continue;
      // The least delay belongs to the offset: nobody can tell it from the clocks' difference.
      const double error =
          to_seconds(model.to_host(device.clock(t)).time_since_epoch()) - (t + device.least_delay_s);
      EXPECT_LT(std::abs(error), t < 10 ? 1e-3 : 4e-4) << ppm << " ppm at " << t;
    }
    EXPECT_NEAR(model.rate(), -1e-6 * ppm, 6e-6);
    EXPECT_LT(to_seconds(model.uncertainty(device.clock(90))), 3e-4);
    EXPECT_GT(to_seconds(model.uncertainty(device.clock(400))),
              to_seconds(model.uncertainty(device.clock(90))));
  }
}

TEST(ClockModel, IsAsSureAfterAMillionPairsAsAfterAMinute) {
  // 4.6 hours, in which the device's clock falls behind by half a second.
  Random random(5);
  Device device;
  device.rate = 1 - 30e-6;
  ClockModel model;
  for (int i = 0; i < 1'000'000; ++i) {
    const double t = i / 60.0;
    ASSERT_FALSE(model.add(device.clock(t), device.arrival(t, random))) << t;
    if (t < 60 || i % 1'000 != 0) continue;
    const double uncertainty_s = to_seconds(model.uncertainty(device.clock(t)));
    ASSERT_GT(uncertainty_s, 1e-6) << t;
    ASSERT_LT(uncertainty_s, 1e-3) << t;  // A second that has just begun has a late packet alone.
    ASSERT_NEAR(model.rate(), 30e-6, 2e-6) << t;
    ASSERT_NEAR(to_seconds(model.to_host(device.clock(t)).time_since_epoch()), t + device.least_delay_s,
                1e-4);
  }
}

TEST(ClockModel, GoesThereAndBack) {
  Random random(3);
  const Device device;
  ClockModel model;
  for (int i = 0; i < 2000; ++i) model.add(device.clock(i / 60.0), device.arrival(i / 60.0, random));
  for (const double t : {-5.0, 0.0, 3.25, 33.0, 1000.0}) {
    const DeviceTime time = device.clock(t);
    EXPECT_LE(std::abs((model.to_device(model.to_host(time)) - time).count()), 2) << t;
  }
}

TEST(ClockModel, TellsARestartFromASlowRadio) {
  Random random(4);
  Device device;
  ClockModel model;
  double t = 0;
  for (; t < 10; t += 1 / 60.0) EXPECT_FALSE(model.add(device.clock(t), device.arrival(t, random)));
  for (; t < 12; t += 1 / 60.0)
    EXPECT_FALSE(model.add(device.clock(t), device.arrival(t, random) + std::chrono::milliseconds(700)));
  for (; t < 14; t += 1 / 60.0) EXPECT_FALSE(model.add(device.clock(t), device.arrival(t, random)));
  device.offset_s = -13.9;  // Counts from nought again.
  EXPECT_TRUE(model.add(device.clock(t), device.arrival(t, random)));
  for (double end = t + 5; t < end; t += 1 / 60.0)
    EXPECT_FALSE(model.add(device.clock(t), device.arrival(t, random)));
  EXPECT_NEAR(to_seconds(model.to_host(device.clock(t)).time_since_epoch()), t + 0.001, 5e-4);
}

TEST(ClockModel, IsAPureFunctionOfItsPairs) {
  // Asking in between changes nothing.
  Random random(9);
  const Device device;
  ClockModel asked;
  ClockModel unasked;
  for (int i = 0; i < 3000; ++i) {
    const double t = i / 60.0;
    const HostTime arrival = device.arrival(t, random);
    asked.add(device.clock(t), arrival);
    unasked.add(device.clock(t), arrival);
    (void)asked.to_host(device.clock(t + 1));
  }
  EXPECT_EQ(asked.to_host(device.clock(77)), unasked.to_host(device.clock(77)));
  EXPECT_EQ(asked.rate(), unasked.rate());
}

Sample sample_of(std::uint16_t sensor, DeviceTime time, SampleKind kind = SampleKind::imu_raw) {
  Sample sample;
  sample.sensor = sensor;
  sample.time = time;
  sample.kind = kind;
  return sample;
}

TEST(TimeLines, BringTwoDevicesTogether) {
  Random random(11);
  Device face;
  Device ear;
  ear.offset_s = 71.0;
  ear.rate = 1 - 20e-6;
  TimeLines lines(2, std::uint16_t{1});
  for (int i = 0; i < 60 * 60; ++i) {
    const double t = i / 60.0;
    lines.add(face.arrival(t, random), sample_of(0, face.clock(t)));
    lines.add(ear.arrival(t, random), sample_of(1, ear.clock(t)));
    if (t < 2) continue;
    EXPECT_LT(std::abs(to_seconds(lines.to_line(0, face.clock(t)) - ear.clock(t))), 1e-3) << t;
    EXPECT_EQ(lines.to_line(1, ear.clock(t)), ear.clock(t));
    EXPECT_LE(std::abs((lines.from_line(0, lines.to_line(0, face.clock(t))) - face.clock(t)).count()), 3);
  }
  EXPECT_FALSE(lines.on_host_time());
}

TEST(TimeLines, AnotherBoardInItsPlaceHasAClockOfItsOwn) {
  TimeLines lines(2, std::uint16_t{1});
  const auto receive = [&](double t, double offset_s) {
    lines.add(HostTime(from_seconds(t)), sample_of(0, DeviceTime(from_seconds(t + offset_s))));
    lines.add(HostTime(from_seconds(t)), sample_of(1, DeviceTime(from_seconds(t))));
  };
  for (int i = 0; i < 600; ++i) receive(i / 60.0, 3);
  lines.forget(0);
  EXPECT_FALSE(lines.has_samples(0));
  lines.forget(1);  // The reference carries the line.
  EXPECT_TRUE(lines.has_samples(1));
  // So near to the one before that it would pass for it; and the reference's, a fifth of a second behind.
  const auto receive_others = [&](double t) {
    lines.add(HostTime(from_seconds(t)), sample_of(0, DeviceTime(from_seconds(t + 3.05))));
    lines.add(HostTime(from_seconds(t)), sample_of(1, DeviceTime(from_seconds(t - 0.2))));
  };
  receive_others(10);
  const auto on_line = [&](std::uint16_t sensor, double device_s) {
    return to_seconds(lines.to_line(sensor, DeviceTime(from_seconds(device_s))).time_since_epoch());
  };
  EXPECT_NEAR(on_line(0, 13.05), 10, 1e-3);
  EXPECT_NEAR(on_line(1, 9.8), 10, 1e-3);
}

// The radio lies by tens of milliseconds, and more for one than for the other; the wire does not.
TEST(TimeLines, PulsesOnAWireLeaveTheRadioOut) {
  Random random(14);
  Device ear, face;
  ear.offset_s = 5;
  face.offset_s = 91;
  face.rate = 1 + 40e-6;
  TimeLines by_radio(2, std::uint16_t{1});
  TimeLines by_wire(2, std::uint16_t{1});
  std::uint32_t index = 0;
  double next_pulse = 0.5;
  const auto late = [](HostTime time, double s) { return time + from_seconds(s); };
  for (double t = 0; t < 30; t += 1 / 60.0) {
    for (TimeLines* lines : {&by_radio, &by_wire}) {
      lines->add(late(ear.arrival(t, random), 0.004), sample_of(1, ear.clock(t)));
      lines->add(late(face.arrival(t, random), 0.045), sample_of(0, face.clock(t)));
    }
    if (t < next_pulse) continue;
    next_pulse += 1;
    // The face's word comes first in every other second, and one in five is lost.
    const auto tell_ear = [&] { by_wire.pulse(1, index, ear.clock(t)); };
    const auto tell_face = [&] {
      if (index % 5 != 3) by_wire.pulse(0, index, face.clock(t));
    };
    if (index % 2 == 0) {
      tell_face();
      tell_ear();
    } else {
      tell_ear();
      tell_face();
    }
    ++index;
  }
  const double t = 29.5;
  const double by_radio_s = to_seconds(by_radio.to_line(0, face.clock(t)) - ear.clock(t));
  const double by_wire_s = to_seconds(by_wire.to_line(0, face.clock(t)) - ear.clock(t));
  EXPECT_GT(std::abs(by_radio_s), 0.03);
  EXPECT_LT(std::abs(by_wire_s), 1e-4);
  const DeviceTime back = by_wire.from_line(0, by_wire.to_line(0, face.clock(t)));
  EXPECT_NEAR(to_seconds(back - face.clock(t)), 0, 1e-6);
}

// After two pulses the rate is not known: it must not be held for an hour.
TEST(TimeLines, APulledCableLeavesTheClockToTheRadio) {
  Random random(16);
  Device ear, face;
  face.rate = 1 + 90e-6;
  ear.rate = 1;
  TimeLines lines(2, std::uint16_t{1});
  for (double t = 0; t < 1200; t += 0.1) {
    lines.add(ear.arrival(t, random), sample_of(1, ear.clock(t)));
    lines.add(face.arrival(t, random), sample_of(0, face.clock(t)));
    if (t < 2 && std::abs(t - std::round(t)) < 0.01) {
      lines.pulse(1, static_cast<std::uint32_t>(std::lround(t)), ear.clock(t));
      lines.pulse(0, static_cast<std::uint32_t>(std::lround(t)), face.clock(t));
    }
  }
  EXPECT_NEAR(to_seconds(lines.to_line(0, face.clock(1200)) - ear.clock(1200)), 0, 0.005);
}

TEST(TimeLines, ABoardThatRestartsForgetsItsPulses) {
  Random random(15);
  Device ear, face;
  TimeLines lines(2, std::uint16_t{1});
  double t = 0;
  for (std::uint32_t index = 0; t < 10; t += 1 / 60.0) {
    lines.add(ear.arrival(t, random), sample_of(1, ear.clock(t)));
    lines.add(face.arrival(t, random), sample_of(0, face.clock(t)));
    if (t < index) continue;
    lines.pulse(1, index, ear.clock(t));
    lines.pulse(0, index++, face.clock(t));
  }
  face.offset_s -= 1000;
  for (double end = t + 2; t < end; t += 1 / 60.0) {
    lines.add(ear.arrival(t, random), sample_of(1, ear.clock(t)));
    lines.add(face.arrival(t, random), sample_of(0, face.clock(t)));
  }
  EXPECT_NEAR(to_seconds(lines.to_line(0, face.clock(t)) - ear.clock(t)), 0, 0.01);
}

TEST(TimeLines, AReferenceThatRestartsGoesOnWhereItLeftOff) {
  Random random(12);
  Device ear;
  TimeLines lines(1, std::uint16_t{0});
  double t = 0;
  for (; t < 20; t += 1 / 60.0) lines.add(ear.arrival(t, random), sample_of(0, ear.clock(t)));
  const DeviceTime before = lines.to_line(0, ear.clock(t));
  t += 3;
  ear.offset_s = -22;
  for (double end = t + 5; t < end; t += 1 / 60.0)
    lines.add(ear.arrival(t, random), sample_of(0, ear.clock(t)));
  const DeviceTime after = lines.to_line(0, ear.clock(t));
  EXPECT_NEAR(to_seconds(after - before), 8.0, 0.02);
}

TEST(TimeLines, WithoutAReferenceTheHostsTimeIsTheLine) {
  Random random(13);
  const Device face;
  TimeLines lines(2, std::uint16_t{1});
  double t = 0;
  for (; t < 0.4; t += 1 / 60.0) lines.add(face.arrival(t, random), sample_of(0, face.clock(t)));
  EXPECT_FALSE(lines.ready());
  for (; t < 3; t += 1 / 60.0) lines.add(face.arrival(t, random), sample_of(0, face.clock(t)));
  ASSERT_TRUE(lines.ready());
  EXPECT_TRUE(lines.on_host_time());
  EXPECT_NEAR(to_seconds(lines.to_line(0, face.clock(t)).time_since_epoch()), t + 0.001, 1e-3);
}

TEST(TimeLines, LabSamplesStandOnTheLine) {
  TimeLines lines(2, std::uint16_t{1});
  const DeviceTime time{std::chrono::seconds(5)};
  lines.add(HostTime{std::chrono::seconds(5)}, sample_of(0, time, SampleKind::imu_head_relative));
  ASSERT_TRUE(lines.ready());
  EXPECT_TRUE(lines.on_host_time());
  EXPECT_EQ(lines.to_line(0, time), time);
}

}  // namespace
}  // namespace mien::sensor::clock_model_test
