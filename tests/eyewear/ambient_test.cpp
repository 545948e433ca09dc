#include "mien/eyewear/ambient.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace mien::eyewear::ambient_test {
namespace {

constexpr double kRate_hz = 250;

sensor::Sample sample_at(double time_s, double on, double off) {
  sensor::Sample sample;
  sample.kind = sensor::SampleKind::eyewear_light;
  sample.time = DeviceTime(from_seconds(time_s));
  sample.count = 2;
  sample.values[0] = static_cast<float>(on);
  sample.values[1] = static_cast<float>(off);
  return sample;
}

/// What the skin gives back: a smile now and then, between 0.2 and 0.4.
double reflected(double time_s) {
  return 0.3 + 0.1 * std::sin(2 * std::numbers::pi * 0.5 * time_s);
}

/// The largest error of the filter's answer over 10 s, its delay taken out, where `strobe(t)` falls into the
/// reading that is being taken then; with and without the median.
struct Errors {
  double filtered = 0;
  double difference = 0;
};
template <class Ambient, class Strobe>
Errors errors(const Ambient& ambient, const Strobe& strobe) {
  AmbientFilter filter;
  Errors worst;
  const double delay_s = 0.5 * (kMedianSamples - 1) / kRate_hz;
  for (int i = 0; i < static_cast<int>(10 * kRate_hz); ++i) {
    const double time_s = i / kRate_hz;
    const double off_s = time_s + 0.0001;  // The LED is off 0.1 ms after it was on.
    const auto lit = [](double value) { return std::min(value, 1.0); };
    const double on = lit(reflected(time_s) + ambient(time_s) + strobe(time_s));
    const double off = lit(ambient(off_s) + strobe(off_s));
    const double answer = filter.add(sample_at(time_s, on, off));
    if (i < static_cast<int>(kMedianSamples)) continue;
    worst.filtered = std::max(worst.filtered, std::abs(answer - reflected(time_s - delay_s)));
    worst.difference = std::max(worst.difference, std::abs(on - off - reflected(time_s)));
  }
  return worst;
}

double none(double) {
  return 0.0;
}

/// Cameras that flash for 0.5 ms.
auto flashing(double rate_hz, double brightness) {
  return
      [=](double time_s) { return std::fmod(time_s * rate_hz, 1.0) < 0.0005 * rate_hz ? brightness : 0.0; };
}

TEST(AmbientFilter, TakesAwayTheSunAndLamps) {
  EXPECT_LT(errors([](double) { return 0.5; }, none).filtered, 0.001);
  // A lamp at twice the mains: 0.1 ms between the two readings is all that it has to change.
  const auto lamp = [](double t) { return 0.15 * (1 + std::sin(2 * std::numbers::pi * 100 * t)); };
  EXPECT_LT(errors(lamp, none).filtered, 0.012);
}

TEST(AmbientFilter, StrobesDoNotShow) {
  for (const double rate_hz : {30.0, 60.0, 97.0, 100.0, 120.0, 240.0}) {
    const Errors worst = errors(none, flashing(rate_hz, 0.4));
    EXPECT_GT(worst.difference, 0.35) << rate_hz << " Hz: no strobe ever hit";
    EXPECT_LT(worst.filtered, 0.02) << rate_hz << " Hz";
  }
}

TEST(AmbientFilter, AStrobeAtTheSensorsOwnRateStays) {
  // It falls into every sample, or none: no median tells it from light. The sketch should sample at another
  // rate.
  EXPECT_GT(
      errors(none, [](double time_s) { return std::fmod(time_s * kRate_hz + 0.01, 1.0) < 0.02 ? 0.4 : 0.0; })
          .filtered,
      0.3);
}

TEST(AmbientFilter, AnswersFromTheFirstSampleOn) {
  AmbientFilter filter;
  EXPECT_NEAR(filter.add(sample_at(0, 0.5, 0.1)), 0.4, 1e-6);
  EXPECT_NEAR(filter.add(sample_at(0.004, 0.7, 0.1)), 0.5, 1e-6);
}

TEST(AmbientFilter, DoubledAndOvertakenSamplesDoNotCount) {
  AmbientFilter filter;
  filter.add(sample_at(1, 0.5, 0));
  filter.add(sample_at(1.004, 0.6, 0));
  EXPECT_NEAR(filter.add(sample_at(1.004, 0.6, 0)), 0.55, 1e-6);
  EXPECT_NEAR(filter.add(sample_at(1, 0.1, 0)), 0.55, 1e-6);
  EXPECT_NEAR(filter.add(sample_at(1.008, 0.7, 0)), 0.6, 1e-6);
}

TEST(AmbientFilter, AfterAPauseItBeginsAnew) {
  for (const double then_s : {1.3, 0.1}) {
    AmbientFilter filter;
    filter.add(sample_at(1, 0.5, 0));
    EXPECT_NEAR(filter.add(sample_at(then_s, 0.1, 0)), 0.1, 1e-6);
  }
  AmbientFilter filter;
  filter.add(sample_at(1, 0.5, 0));
  filter.reset();
  EXPECT_NEAR(filter.add(sample_at(1, 0.1, 0)), 0.1, 1e-6);
}

}  // namespace
}  // namespace mien::eyewear::ambient_test
