#include "mien/shaping/blinks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/shaping/shaper.h"
#include "tests/shaping/frames.h"

namespace mien::shaping::blinks_test {
namespace {

using face::Provenance;
using face::shape;

constexpr std::array<std::size_t, 2> kBlinks = {shape("eyeBlink_L"), shape("eyeBlink_R")};

/// A frame of sensors on the skin: lids 0.1 and predicted, all else measured.
face::OutputFrame frame_at(std::int64_t index) {
  face::OutputFrame frame = measured(index);
  for (const std::size_t lid : kBlinks) {
    frame.weights[lid] = 0.1F;
    frame.confidence[lid] = 0.4F;
    frame.provenance[lid] = Provenance::predicted;
  }
  for (const std::size_t squint : {shape("eyeSquint_L"), shape("eyeSquint_R")}) frame.weights[squint] = 0;
  frame.head = Quat::Identity();
  return frame;
}

/// Frames in which the left lid begins to close further than half.
std::vector<std::int64_t> closings(Blinks& blinks, std::int64_t from, std::int64_t to, double rate_per_min) {
  std::vector<std::int64_t> out;
  bool shut = false;
  for (std::int64_t i = from; i < to; ++i) {
    face::OutputFrame frame = frame_at(i);
    blinks.apply(frame, rate_per_min);
    const bool now = frame.weights[kBlinks[0]] > 0.3F;
    if (now && !shut) out.push_back(i);
    shut = now;
  }
  return out;
}

TEST(MadeBlinks, ComeAtTheGivenRateAndIrregularly) {
  for (const double rate : {6.0, 12.0, 20.0}) {
    Blinks blinks;
    const auto at = closings(blinks, 0, 60 * 60 * 60, rate);
    // Some that would follow on another are left out.
    EXPECT_NEAR(static_cast<double>(at.size()) / 60, rate, 0.15 * rate);
    double mean = 0, square = 0;
    for (std::size_t i = 1; i < at.size(); ++i) mean += static_cast<double>(at[i] - at[i - 1]);
    mean /= static_cast<double>(at.size() - 1);
    for (std::size_t i = 1; i < at.size(); ++i)
      square += std::pow(static_cast<double>(at[i] - at[i - 1]) - mean, 2);
    EXPECT_GT(std::sqrt(square / static_cast<double>(at.size() - 1)), 0.4 * mean);
  }
}

TEST(MadeBlinks, NoneAtRateZero) {
  Blinks blinks;
  EXPECT_TRUE(closings(blinks, 0, 60 * 600, 0).empty());
}

TEST(MadeBlinks, AreTheSameFromWhereverTheyBegin) {
  Blinks whole, later;
  const auto all = closings(whole, 0, 60 * 300, 12);
  const auto part = closings(later, 60 * 100 + 7, 60 * 300, 12);
  ASSERT_GT(part.size(), 20U);
  EXPECT_TRUE(std::ranges::equal(part, std::span(all).last(part.size())));
}

TEST(MadeBlinks, CloseBothLidsAndOpenThemAgain) {
  Blinks blinks;
  float most = 0;
  for (std::int64_t i = 0; i < 60 * 60; ++i) {
    face::OutputFrame frame = frame_at(i);
    blinks.apply(frame, 12);
    EXPECT_GE(frame.weights[kBlinks[0]], 0.1F);
    EXPECT_LE(frame.weights[kBlinks[0]], 1.0F);
    EXPECT_NEAR(frame.weights[kBlinks[0]], frame.weights[kBlinks[1]], 0.2F);
    EXPECT_EQ(frame.provenance[kBlinks[0]], Provenance::predicted);
    // What is made is not known.
    EXPECT_NEAR(frame.confidence[kBlinks[0]], 0.4F * (1 - (frame.weights[kBlinks[0]] - 0.1F) / 0.9F), 1e-5F);
    most = std::max(most, frame.weights[kBlinks[0]]);
  }
  EXPECT_GT(most, 0.9F);
}

TEST(MadeBlinks, LeaveLidsAloneThatAreNotPredicted) {
  for (const Provenance provenance :
       {Provenance::measured, Provenance::interpolated, Provenance::held, Provenance::neutral}) {
    Blinks blinks;
    for (std::int64_t i = 0; i < 60 * 60; ++i) {
      face::OutputFrame frame = frame_at(i);
      for (const std::size_t lid : kBlinks) frame.provenance[lid] = provenance;
      const face::OutputFrame before = frame;
      blinks.apply(frame, 60);
      EXPECT_EQ(frame.weights.values, before.weights.values);
      EXPECT_EQ(frame.confidence, before.confidence);
    }
  }
}

/// Whether the lids close within 0.2 s of frame `from`, of a session that never blinks by itself there.
bool blinks_at(std::int64_t from, auto&& change) {
  Blinks blinks;
  bool shut = false;
  for (std::int64_t i = from - 30; i < from + 12; ++i) {
    face::OutputFrame frame = frame_at(i);
    change(frame, static_cast<double>(i - from) / 60);
    blinks.apply(frame, 1);  // One a minute: none lies in these 0.7 s.
    shut = shut || (i >= from && frame.weights[kBlinks[0]] > 0.3F);
  }
  return shut;
}

TEST(MadeBlinks, GoWithFastTurnsOfTheHeadAndSquints) {
  constexpr std::int64_t kFrom = 1000;
  EXPECT_FALSE(blinks_at(kFrom, [](face::OutputFrame&, double) {}));
  const auto turning = [](double rad_s) {
    return [=](face::OutputFrame& frame, double t_s) {
      if (t_s > 0) frame.head = exp_rotation({0, 0, rad_s * t_s});
    };
  };
  EXPECT_TRUE(blinks_at(kFrom, turning(3)));
  EXPECT_FALSE(blinks_at(kFrom, turning(0.8)));
  const auto squinting = [](Provenance provenance) {
    return [=](face::OutputFrame& frame, double t_s) {
      const std::size_t squint = shape("eyeSquint_L");
      frame.weights[squint] = static_cast<float>(std::clamp(5 * t_s, 0.0, 0.6));
      frame.provenance[squint] = provenance;
    };
  };
  EXPECT_TRUE(blinks_at(kFrom, squinting(Provenance::measured)));
  EXPECT_FALSE(blinks_at(kFrom, squinting(Provenance::predicted)));
}

TEST(MadeBlinks, FadeWhenASensorBeginsToObserveTheLid) {
  Blinks blinks;
  const auto at = closings(blinks, 0, 60 * 60, 12);
  ASSERT_FALSE(at.empty());
  blinks.reset();
  float before = 0.1F;
  for (std::int64_t i = 0; i < at.front() + 60; ++i) {
    face::OutputFrame frame = frame_at(i);
    if (i >= at.front() + 3)
      for (const std::size_t lid : kBlinks) frame.provenance[lid] = Provenance::measured;
    blinks.apply(frame, 12);
    EXPECT_LT(std::abs(frame.weights[kBlinks[0]] - before), 0.45F) << i;
    before = frame.weights[kBlinks[0]];
  }
  EXPECT_EQ(before, 0.1F);
}

TEST(MadeBlinks, AreAStepOfTheChainThatCanBeLeftOut) {
  for (const bool off : {false, true}) {
    ShaperSettings settings{.blinks_per_min = 30};
    settings.off.set(static_cast<std::size_t>(ChainStep::blinks), off);
    Shaper shaper(settings);
    float most = 0;
    for (std::int64_t i = 0; i < 60 * 20; ++i) {
      face::OutputFrame frame = frame_at(i);
      shaper.apply(frame, 1);
      most = std::max(most, frame.weights[kBlinks[1]]);
    }
    EXPECT_EQ(most > 0.9F, !off);
  }
}

}  // namespace
}  // namespace mien::shaping::blinks_test
