#include "mien/train/batches.h"

#include <gtest/gtest.h>

#include "mien/face/profile.h"
#include "tests/train/toy_data.h"

namespace mien::train::batches_test {
namespace {

class Batches : public testing::Test {
 protected:
  void SetUp() override {
    layout_ = {.sensors = dataset_.sensors, .presence_flags = true};
    normalisation_ = normalisation_of(dataset_, recipe_.lab_noise_rad);
  }
  [[nodiscard]] BatchMaker maker() const {
    return {dataset_, recipe_, layout_, normalisation_, skin_, mean_pose_};
  }
  void lose_nothing() { recipe_.sensor_loss = recipe_.many_lost = recipe_.acceleration_loss = 0; }

  Recipe recipe_ = *parse_recipe(toy_recipe(1), "test");
  dataset::Dataset dataset_ = toy_data(0, 3);
  model::FeatureLayout layout_;
  model::FeatureNormalisation normalisation_;
  std::optional<model::Skin> skin_;
  std::vector<float> mean_pose_ = std::vector<float>(face::kShapeCount, 0.05F);
};

TEST_F(Batches, AStepsBatchIsAFunctionOfTheStep) {
  const BatchMaker batches = maker();
  const auto make = [&](std::uint64_t step) {
    return batches.random_batch(16, Random(3).fork("batch", step));
  };
  EXPECT_EQ(make(5).condition, make(5).condition);
  EXPECT_EQ(make(5).level, make(5).level);
  EXPECT_NE(make(5).condition, make(6).condition);
}

TEST_F(Batches, NormalisedValuesHaveMeanZeroAndSpreadOne) {
  lose_nothing();
  const Batch batch = maker().even_batch(1000, Random(1));
  ASSERT_GT(batch.windows, 20U);
  const std::size_t width = layout_.width(), frames = batch.condition.size() / width;
  for (const std::size_t column : {4U, 5U, 6U, 11U, 12U, 13U}) {  // The rotations' vector parts.
    double sum = 0, squares = 0;
    for (std::size_t f = 0; f < frames; ++f) {
      const double v = batch.condition[f * width + column];
      sum += v / static_cast<double>(frames);
      squares += v * v / static_cast<double>(frames);
    }
    EXPECT_NEAR(sum, 0, 0.1) << column;
    EXPECT_NEAR(std::sqrt(squares - sum * sum), 1, 0.1) << column;
  }
}

TEST_F(Batches, LabRotationsGetFreshNoiseOfTheGivenSize) {
  lose_nothing();
  for (dataset::Sequence& s : dataset_.sequences) {
    s.lab = true;
    for (std::size_t i = 0; i < s.values.size(); ++i) s.values[i] = i % 7 == 3 ? 1.0F : 0.0F;  // Neutral.
  }
  normalisation_ = {.mean = std::vector<float>(14, 0.0F), .scale = std::vector<float>(14, 1.0F)};
  const BatchMaker batches = maker();
  std::vector<float> once(200 * layout_.width()), again(once.size());
  Random random(1);
  batches.encode(0, 0, 200, random, once);
  batches.encode(0, 0, 200, random, again);
  EXPECT_NE(once, again);
  double squares = 0;
  for (std::size_t f = 0; f < 200; ++f)
    for (const std::size_t column : {4U, 5U, 6U})
      squares += std::pow(2.0 * double{once[f * layout_.width() + column]}, 2) / 600;
  EXPECT_NEAR(std::sqrt(squares), recipe_.lab_noise_rad, 0.1 * recipe_.lab_noise_rad);
}

TEST_F(Batches, DeviceRotationsAreLeftAlone) {
  lose_nothing();
  const BatchMaker batches = maker();
  std::vector<float> once(200 * layout_.width()), again(once.size());
  Random random(1);
  batches.encode(1, 0, 200, random, once);
  batches.encode(1, 0, 200, random, again);
  EXPECT_EQ(once, again);
}

TEST_F(Batches, HeadingsDriftOfDevicesAloneAndStayThroughTheWindow) {
  lose_nothing();
  recipe_.lab_noise_rad = 0;
  for (dataset::Sequence& s : dataset_.sequences)
    for (std::size_t i = 0; i < s.values.size(); ++i) s.values[i] = i % 7 == 3 ? 1.0F : 0.0F;  // Neutral.
  normalisation_ = {.mean = std::vector<float>(14, 0.0F), .scale = std::vector<float>(14, 1.0F)};
  recipe_.heading_drift = 1;
  recipe_.heading_drift_rad = 0.2;
  const std::size_t width = layout_.width(), window = recipe_.architecture.window;
  for (const bool lab : {false, true}) {
    for (dataset::Sequence& s : dataset_.sequences) s.lab = lab;
    const Batch batch = maker().random_batch(400, Random(1));
    double squares = 0;
    for (std::size_t w = 0; w < batch.windows; ++w)
      for (std::size_t sensor = 0; sensor < 2; ++sensor) {
        const float* first = batch.condition.data() + w * window * width + 7 * sensor;
        squares += std::pow(2.0 * double{first[5]}, 2) / 800;
        EXPECT_EQ(first[4], 0);
        EXPECT_EQ(first[6], 0) << "about the vertical";
        EXPECT_EQ(first[(window - 1) * width + 5], first[5]);
      }
    // A sigma drawn evenly up to s: a mean square of s * s / 3.
    EXPECT_NEAR(std::sqrt(squares), lab ? 0 : 0.2 / std::sqrt(3.0), 0.012);
  }
}

TEST_F(Batches, LostSensorsSaySo) {
  recipe_.sensor_loss = 1;
  recipe_.many_lost = 0;
  const Batch batch = maker().random_batch(4, Random(1));
  for (const float v : batch.condition) ASSERT_EQ(v, 0.0F);
  recipe_.sensor_loss = 0;
  recipe_.acceleration_loss = 1;
  const Batch turned = maker().random_batch(4, Random(1));
  const std::size_t width = layout_.width();
  for (std::size_t at = 0; at < turned.condition.size(); at += width) {
    EXPECT_EQ(turned.condition[at + 14], 1.0F);  // Rotations are there,
    EXPECT_EQ(turned.condition[at + 16], 0.0F);  // accelerations are not,
    EXPECT_EQ(turned.condition[at], 0.0F);       // and stand at their mean.
  }
}

TEST_F(Batches, SensorsGoAndComeBack) {
  lose_nothing();
  recipe_.stretch_loss = 0.5;
  const std::size_t width = layout_.width(), window = recipe_.architecture.window;
  const Batch batch = maker().random_batch(200, Random(1));
  std::size_t gone_at_first = 0, gone_at_last = 0, changes = 0, both_gone = 0;
  for (std::size_t w = 0; w < batch.windows; ++w)
    for (std::size_t f = 0; f < window; ++f) {
      const float* frame = batch.condition.data() + (w * window + f) * width;
      for (std::size_t sensor = 0; sensor < 2; ++sensor) {
        const bool gone = frame[14 + sensor] == 0;
        if (gone) {
          for (std::size_t v = 0; v < 7; ++v) ASSERT_EQ(frame[7 * sensor + v], 0.0F) << "and says nothing";
          ASSERT_EQ(frame[16 + sensor], 0.0F);
        }
        gone_at_first += gone && f == 0;
        gone_at_last += gone && f == window - 1;
        changes +=
            f > 0 &&
            gone !=
                (frame[static_cast<std::ptrdiff_t>(14 + sensor) - static_cast<std::ptrdiff_t>(width)] == 0);
      }
      both_gone += frame[14] == 0 && frame[15] == 0;
    }
  EXPECT_GT(gone_at_first, 20U);
  EXPECT_GT(gone_at_last, 20U);
  EXPECT_GT(changes, 200U);
  EXPECT_GT(both_gone, 400U);
}

TEST_F(Batches, ReadingsStandStillForAFewFrames) {
  lose_nothing();
  recipe_.held_readings = 1;
  const std::size_t width = layout_.width(), window = recipe_.architecture.window;
  const Batch batch = maker().random_batch(200, Random(1));
  std::size_t held = 0, longest = 0;
  for (std::size_t w = 0; w < batch.windows; ++w)
    for (std::size_t sensor = 0; sensor < 2; ++sensor)
      for (std::size_t f = 1, now = 0; f < window; ++f) {
        const auto reading =
            batch.condition.begin() + static_cast<std::ptrdiff_t>((w * window + f) * width + 7 * sensor);
        const bool still = std::equal(reading, reading + 7, reading - static_cast<std::ptrdiff_t>(width));
        held += still ? 1 : 0;
        now = still ? now + 1 : 0;
        longest = std::max(longest, now);
        ASSERT_EQ(batch.condition[(w * window + f) * width + 14 + sensor], 1.0F)
            << "it is there all the same";
      }
  const double share = static_cast<double>(held) / static_cast<double>(200 * 2 * (window - 1));
  EXPECT_NEAR(share, 0.2, 0.05);
  EXPECT_GE(longest, 6U);
}

TEST_F(Batches, LevelsCoverTheScheduleAndLeanWhereTold) {
  const auto mean_level = [&] {
    const Batch batch = maker().random_batch(400, Random(1));
    double sum = 0;
    for (const std::int64_t level : batch.level) {
      EXPECT_GE(level, 0);
      EXPECT_LT(level, 1000);
      sum += static_cast<double>(level) / 400;
    }
    return sum;
  };
  EXPECT_NEAR(mean_level(), 500, 10);
  recipe_.t_bias = 1;
  EXPECT_NEAR(mean_level(), 667, 10);
}

TEST_F(Batches, BadDataAreRefused) {
  EXPECT_TRUE(check(dataset_));
  EXPECT_TRUE(check_apart(dataset_, toy_data(3, 1)));
  EXPECT_FALSE(check_apart(dataset_, toy_data(2, 1)));
  auto other = toy_data(3, 1);
  other.sensors[0] = "frontalis_l";
  EXPECT_FALSE(check_apart(dataset_, other));
  auto bad = dataset_;
  bad.sequences[1].values[3] = NAN;
  EXPECT_FALSE(check(bad));
  bad = dataset_;
  bad.sequences[0].present.pop_back();
  EXPECT_FALSE(check(bad));
  bad = dataset_;
  bad.sequences[0].frames += 1;
  EXPECT_FALSE(check(bad));
}

TEST_F(Batches, AKnownSkinIsReadAsTheStandardOne) {
  lose_nothing();
  // Everybody's chin turns twice as far as the standard's.
  const std::size_t slopes = 3 * dataset_.sensors.size() * face::kShapeCount;
  dataset_.standard_slopes.assign(slopes, 0.0F);
  dataset_.standard_slopes[face::shape("jawOpen")] = 0.1F;
  for (dataset::Sequence& s : dataset_.sequences) {
    s.lab = false;
    s.slopes.assign(slopes, 0.0F);
    s.slopes[face::shape("jawOpen")] = 0.2F;
    for (std::size_t f = 0; f < s.frames; ++f) {
      float* q = s.values.data() + f * 7 * dataset_.sensors.size() + 3;
      q[0] = 0.995004F, q[1] = 0.0998334F, q[2] = q[3] = 0;  // 0.2 rad about x.
    }
  }
  skin_ = model::Skin{.standard = dataset_.standard_slopes,
                      .covariance = std::vector<float>(face::kShapeCount * face::kShapeCount, 0.0F),
                      .wearer = {}};
  for (std::size_t k = 0; k < face::kShapeCount; ++k) skin_->covariance[k * face::kShapeCount + k] = 0.04F;
  normalisation_ = {.mean = std::vector<float>(normalisation_.mean.size(), 0.0F),
                    .scale = std::vector<float>(normalisation_.scale.size(), 1.0F)};
  const auto turned = [&](double known) {
    recipe_.known_skin = known;
    recipe_.skin_gain_error = recipe_.skin_slope_error = 0;
    return maker().even_batch(1, Random(1)).condition[4];
  };
  EXPECT_NEAR(turned(0), 0.0998334, 1e-5);
  EXPECT_NEAR(turned(1), 0.05, 0.01) << "half of the turn, but for what the prior holds back";
}

}  // namespace
}  // namespace mien::train::batches_test
