#include "mien/session/cover_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace mien::session::cover_watch_test {
namespace {

using testing::HasSubstr;

HostTime at(double seconds) {
  return HostTime(from_seconds(seconds));
}

sensor::Reading picture(std::uint64_t device, float contrast, float mean = 0.4F) {
  sensor::Reading reading;
  reading.from = {device, 0};
  reading.sample.kind = sensor::SampleKind::picture;
  reading.sample.count = 7;
  reading.sample.values[0] = mean;
  reading.sample.values[4] = 0.2F;
  reading.sample.values[5] = 0.2F + contrast;
  return reading;
}

struct Told {
  std::optional<std::uint64_t> device;
  double at_s = 0;
};
/// Four cameras at 60 Hz from 0 s on; what each sees, none: nothing comes. Who was covered, and when that was
/// said.
using Sight = std::function<std::optional<float>(std::uint64_t device, double t)>;
Told watched(CoverWatch& watch, double seconds, const Sight& sight) {
  for (int i = 0; i < static_cast<int>(60 * seconds); ++i) {
    const double t = i / 60.0;
    for (std::uint64_t device = 0; device < 4; ++device) {
      const auto contrast = sight(device, t);
      if (!contrast) continue;
      if (const auto covered = watch.add(at(t), picture(device, *contrast))) {
        EXPECT_EQ(covered->sensor, "eye_L");
        return {covered->device.device, t};
      }
    }
  }
  return {};
}
constexpr float kFace = 0.6F, kFinger = 0.04F;

TEST(CoverWatch, FindsTheOneLensThatIsCoveredForHalfASecond) {
  CoverWatch watch;
  watch.arm("eye_L");
  EXPECT_EQ(watch.armed(), "eye_L");
  const Told told = watched(
      watch, 5, [](std::uint64_t device, double t) { return device == 2 && t >= 1 ? kFinger : kFace; });
  ASSERT_TRUE(told.device);
  EXPECT_EQ(*told.device, 2U);
  EXPECT_NEAR(told.at_s, 1.5, 0.02);
  EXPECT_EQ(watch.armed(), "");
  EXPECT_EQ(watch.trouble(), "");
}

// As measured on a virtual headset: in the dark exposure control makes the lens bright again, and its shaded
// corners are as far from its middle as cheek from nostril.
TEST(CoverWatch, FindsALensThatExposureControlMakesAsBrightAsAFace) {
  CoverWatch watch;
  watch.arm("eye_L");
  std::optional<CoverWatch::Covered> covered;
  double told_s = 0;
  for (int i = 0; i < 180 && !covered; ++i) {
    const double t = i / 60.0;
    for (std::uint64_t device = 0; device < 4 && !covered; ++device) {
      float mean = 0.33F, contrast = 0.75F;
      if (device == 3 && t >= 1) {
        mean = 0.42F - 0.31F * static_cast<float>(std::exp(-(t - 1) / 0.35));
        contrast = 1.33F * mean;
      }
      covered = watch.add(at(t), picture(device, contrast, mean));
      told_s = t;
    }
  }
  ASSERT_TRUE(covered);
  EXPECT_EQ(covered->device.device, 3U);
  EXPECT_NEAR(told_s, 1.5, 0.02);
}

TEST(CoverWatch, LampsThatDimAndFacesThatMoveCoverNothing) {
  CoverWatch watch;
  watch.arm("eye_L");
  for (int i = 0; i < 600; ++i) {
    const double t = i / 60.0;
    for (std::uint64_t device = 0; device < 4; ++device) {
      // All levels alike; and a mouth that opens and closes takes a fifth of the contrast.
      const float light = device == 1 && t > 2 ? 0.5F : 1.0F;
      const float moves = device == 2 ? 1 - 0.1F * static_cast<float>(1 - std::cos(2 * t)) : 1;
      EXPECT_FALSE(watch.add(at(t), picture(device, 0.75F * light * moves, 0.33F * light)));
    }
  }
  EXPECT_EQ(watch.armed(), "eye_L");
}

TEST(CoverWatch, AHandThatPassesIsNone) {
  CoverWatch watch;
  watch.arm("eye_L");
  EXPECT_FALSE(watched(watch, 5, [](std::uint64_t device, double t) {
                 return device == 1 && t >= 1 && t < 1.4 ? kFinger : kFace;
               }).device);
  EXPECT_EQ(watch.armed(), "eye_L") << "it waits on";
}

TEST(CoverWatch, ALensThatIsDarkFromTheBeginningIsNotTheOne) {
  CoverWatch watch;
  watch.arm("eye_L");
  const Told told = watched(watch, 5, [](std::uint64_t device, double t) {
    if (device == 0) return kFinger;
    return device == 3 && t >= 2 ? 0.02F : kFace;
  });
  ASSERT_TRUE(told.device);
  EXPECT_EQ(*told.device, 3U);
}

TEST(CoverWatch, TwoAtOnceAreSaid) {
  CoverWatch watch;
  watch.arm("eye_L");
  EXPECT_FALSE(watched(watch, 3, [](std::uint64_t device, double t) {
                 return (device == 1 && t >= 1) || (device == 2 && t >= 1.2) ? kFinger : kFace;
               }).device);
  EXPECT_EQ(watch.armed(), "");
  EXPECT_THAT(std::string(watch.trouble()), HasSubstr("two lenses"));
  watch.arm("eye_L");
  EXPECT_EQ(watch.trouble(), "") << "what was in the way before";
}

TEST(CoverWatch, OneThatWasCoveredBeforeItIsNotInTheWay) {
  CoverWatch watch;
  watch.arm("eye_L");
  const Told told = watched(watch, 5, [](std::uint64_t device, double t) {
    if (device == 1) return t >= 1 && t < 1.4 ? kFinger : kFace;
    return device == 2 && t >= 1.42 ? kFinger : kFace;
  });
  ASSERT_TRUE(told.device);
  EXPECT_EQ(*told.device, 2U);
}

TEST(CoverWatch, ACameraThatVanishesWhileItIsDarkIsNotCovered) {
  CoverWatch watch;
  watch.arm("eye_L");
  const Told told = watched(watch, 5, [](std::uint64_t device, double t) -> std::optional<float> {
    if (device == 1) return t < 1 ? std::optional(kFace) : t < 1.3 ? std::optional(kFinger) : std::nullopt;
    return device == 2 && t >= 2 ? kFinger : kFace;
  });
  ASSERT_TRUE(told.device) << watch.trouble();
  EXPECT_EQ(*told.device, 2U);
  // Nor is one whose next picture comes long after.
  watch.arm("eye_L");
  EXPECT_FALSE(watch.add(at(0), picture(1, kFace)));
  EXPECT_FALSE(watch.add(at(0.1), picture(1, kFinger)));
  EXPECT_FALSE(watch.add(at(3), picture(1, kFinger)));
  EXPECT_EQ(watch.armed(), "eye_L");
}

TEST(CoverWatch, NoneInTimeIsSaid) {
  CoverWatch watch;
  watch.arm("eye_L");
  EXPECT_FALSE(watched(watch, 19.9, [](std::uint64_t, double) { return kFace; }).device);
  EXPECT_EQ(watch.armed(), "eye_L");
  EXPECT_FALSE(watch.add(at(20.1), picture(0, kFace)));
  EXPECT_EQ(watch.armed(), "");
  EXPECT_THAT(std::string(watch.trouble()), HasSubstr("20 seconds"));
}

TEST(CoverWatch, WaitsForNothingUnlessAsked) {
  CoverWatch watch;
  const Sight covered = [](std::uint64_t device, double t) {
    return device == 2 && t >= 1 ? kFinger : kFace;
  };
  EXPECT_FALSE(watched(watch, 30, covered).device);
  watch.arm("eye_L");
  watch.arm("");
  EXPECT_FALSE(watched(watch, 30, covered).device);
  EXPECT_EQ(watch.trouble(), "");
}

TEST(CoverWatch, OtherKindsOfSensorsHaveNoLens) {
  CoverWatch watch;
  watch.arm("eye_L");
  for (int i = 0; i < 200; ++i) {
    sensor::Reading reading = picture(1, i < 60 ? kFace : kFinger);
    reading.sample.kind = sensor::SampleKind::imu_raw;
    EXPECT_FALSE(watch.add(at(i / 60.0), reading));
  }
  EXPECT_EQ(watch.armed(), "eye_L");
}

}  // namespace
}  // namespace mien::session::cover_watch_test
