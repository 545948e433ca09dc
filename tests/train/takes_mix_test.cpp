#include "mien/train/takes_mix.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "mien/model/schedule.h"
#include "mien/synthetic/imu/dataset_part.h"
#include "mien/train/assess.h"
#include "mien/train/batches.h"
#include "tests/train/toy_takes.h"

namespace mien::train::takes_mix_test {
namespace {

dataset::TrainingData performed_by(std::size_t people, std::size_t frames = 200) {
  return {.train = toy_data(0, people, frames), .validation = toy_data(100, 1, frames)};
}

dataset::Dataset mixed(std::size_t performer_frames, std::size_t take_frames) {
  const auto takes = as_takes({.train = toy_takes(0, 1, take_frames), .validation = {}}, 40);
  return synthetic::put_together(performed_by(2, performer_frames), *takes)->train;
}

TEST(TakesMix, AnyWindowIsOfATakeWithTheProbabilityOfTheShare) {
  for (const double share : {0.0, 0.1, 0.3, 0.5, 0.75, 1.0})
    for (const std::size_t index : {0U, 3U, 31U}) {
      Random random(7);
      int takes = 0;
      constexpr int kSteps = 20'000;
      for (int step = 0; step < kSteps; ++step) takes += is_from_take(index, share, random.uniform()) ? 1 : 0;
      EXPECT_NEAR(static_cast<double>(takes) / kSteps, share, share == 0 || share == 1 ? 0 : 0.015)
          << share << " at " << index;
    }
}

TEST(TakesMix, NoStepIsOffTheShareByAWindow) {
  for (const double share : {0.0, 0.1, 0.3, 0.5, 1.0})
    for (const double phase : {0.0, 0.49, 0.999999999999}) {
      double takes = 0;
      for (std::size_t i = 0; i < 32; ++i) takes += is_from_take(i, share, phase) ? 1 : 0;
      EXPECT_LT(std::abs(takes - 32 * share), 1) << share << ", " << phase;
    }
}

TEST(TakesMix, TheRecipeAndTheCommandLineMustAgree) {
  Recipe recipe = *parse_recipe(toy_recipe(1), "test");
  EXPECT_EQ(takes_share(recipe, false, "r.toml").value(), 0);
  EXPECT_EQ(takes_share(recipe, true, "r.toml").value(), 0.5) << "unless told";
  recipe.takes_share = 0.2;
  EXPECT_EQ(takes_share(recipe, true, "r.toml").value(), 0.2);
  const auto none_given = takes_share(recipe, false, "r.toml");
  ASSERT_FALSE(none_given);
  EXPECT_EQ(none_given.error().code, ErrorCode::bad_usage);
  EXPECT_NE(none_given.error().message().find("--takes"), std::string::npos);
  recipe.takes_share = 0;
  EXPECT_EQ(takes_share(recipe, false, "r.toml").value(), 0);
  EXPECT_FALSE(takes_share(recipe, true, "r.toml")) << "they would be read for nothing";
}

TEST(TakesMix, PartsShorterThanAWindowAreLeftOut) {
  dataset::TrainingData takes{.train = toy_takes(0, 1, 39), .validation = toy_takes(5, 1, 39)};
  EXPECT_EQ(as_takes(takes, 40).error().code, ErrorCode::bad_usage) << "nothing is left to train on";
  takes.train.sequences.push_back(toy_takes(1, 1, 40).sequences.front());
  const auto marked = as_takes(takes, 40);
  ASSERT_TRUE(marked) << marked.error().message();
  ASSERT_EQ(marked->train.sequences.size(), 1U);
  EXPECT_EQ(marked->train.sequences.front().performer, 1U);
  EXPECT_TRUE(marked->train.sequences.front().from_take);
  EXPECT_TRUE(marked->validation.sequences.empty());
  const auto nobody_held_out = as_takes({.train = toy_takes(0, 1), .validation = {}}, 40);
  EXPECT_TRUE(check_apart(nobody_held_out->train, nobody_held_out->validation));
}

TEST(TakesMix, PeopleGetNumbersThatNoPerformerHas) {
  const auto takes = as_takes({.train = toy_takes(0, 2), .validation = toy_takes(2, 1)}, 40);
  const auto data = synthetic::put_together(performed_by(2), *takes);
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_TRUE(check_apart(data->train, data->validation));
  std::set<std::uint32_t> performers, people;
  for (const dataset::Dataset* part : {&data->train, &data->validation})
    for (const dataset::Sequence& s : part->sequences)
      (s.from_take ? people : performers).insert(s.performer);
  EXPECT_EQ(performers, (std::set<std::uint32_t>{0, 1, 100}));
  EXPECT_EQ(people, (std::set<std::uint32_t>{101, 102, 103}));
  // Whoever is in both parts of the takes is so afterwards, and refused.
  const auto twice = as_takes({.train = toy_takes(0, 2), .validation = toy_takes(1, 1)}, 40);
  const auto bad = synthetic::put_together(performed_by(2), *twice);
  EXPECT_FALSE(check_apart(bad->train, bad->validation));
}

TEST(TakesMix, OtherSensorsAreRefused) {
  auto takes = as_takes({.train = toy_takes(0, 2), .validation = toy_takes(2, 1)}, 40);
  takes->train.sensors[0] = takes->validation.sensors[0] = "frontalis_L";
  EXPECT_EQ(synthetic::put_together(performed_by(2), *takes).error().code, ErrorCode::mismatch);
}

TEST(TakesMix, TellsHowMuchThereIs) {
  const dataset::Dataset data = mixed(200, 900);
  EXPECT_EQ(takes_in(data).people, 1U);
  EXPECT_DOUBLE_EQ(takes_in(data).minutes, 0.25) << "900 frames of 60 a second";
  EXPECT_EQ(takes_in(toy_data(0, 2)).people, 0U);
}

TEST(TakesMix, StatisticsAreWeightedAsWindowsAreDrawn) {
  for (const std::size_t frames : {60U, 3000U}) {
    const dataset::Dataset data = mixed(200, frames);
    for (const double share : {0.25, 1.0}) {
      const std::vector<float> mean = mean_pose_of(data, as_drawn(data, share));
      EXPECT_NEAR(mean[kShapeOfTakes], 0.05 + share * 0.85, 1e-4) << frames;
      const std::vector<float> covariance = weight_covariance_of(data, as_drawn(data, share));
      EXPECT_NEAR(covariance[kShapeOfTakes * (face::kShapeCount + 1)], share * (1 - share) * 0.85 * 0.85,
                  1e-3);
    }
  }
  const dataset::Dataset alone = toy_data(0, 2);
  EXPECT_EQ(mean_pose_of(alone, as_drawn(alone, 0)), mean_pose_of(alone));
  dataset::Dataset turned = mixed(200, 300);
  for (dataset::Sequence& s : turned.sequences)
    for (std::size_t f = 0; f < s.frames; ++f) s.values[f * 14 + 4] = s.from_take ? 0.4F : 0.0F;
  EXPECT_NEAR(normalisation_of(turned, 0, as_drawn(turned, 0.25)).mean[4], 0.1, 1e-5);
}

class MixedBatches : public testing::Test {
 protected:
  /// Of each step's windows, those of takes.
  [[nodiscard]] std::vector<double> takes_in_steps(const dataset::Dataset& data, std::size_t steps) const {
    const BatchMaker batches = maker(data);
    std::vector<double> counts;
    for (std::size_t step = 0; step < steps; ++step) {
      const Batch batch = batches.random_batch(10, Random(3).fork("batch", step));
      double takes = 0;
      for (std::size_t w = 0; w < batch.windows; ++w)
        takes += batch.clean[w * 40 * face::kShapeCount + kShapeOfTakes] > model::to_network(0.5F) ? 1 : 0;
      counts.push_back(takes);
    }
    return counts;
  }
  [[nodiscard]] BatchMaker maker(const dataset::Dataset& data) const {
    return {data,
            recipe_,
            {.sensors = data.sensors, .presence_flags = true},
            normalisation_of(data, recipe_.lab_noise_rad),
            skin_,
            std::vector<float>(face::kShapeCount, 0.05F)};
  }
  Recipe recipe_ = [] {
    Recipe recipe = *parse_recipe(toy_recipe(1), "test");
    recipe.architecture.outputs = face::kShapeCount;
    return recipe;
  }();
  std::optional<model::Skin> skin_;
};

TEST_F(MixedBatches, KeepTheShareHoweverManyFramesEachHas) {
  for (const std::size_t frames : {60U, 3000U}) {
    recipe_.takes_share = 0.3;
    for (const double takes : takes_in_steps(mixed(200, frames), 20)) EXPECT_EQ(takes, 3) << frames;
    recipe_.takes_share = 0.25;
    double sum = 0;
    for (const double takes : takes_in_steps(mixed(200, frames), 400)) {
      EXPECT_TRUE(takes == 2 || takes == 3) << takes;
      sum += takes;
    }
    EXPECT_NEAR(sum / 400, 2.5, 0.1) << "2.5 of 10 in expectation";
  }
}

TEST_F(MixedBatches, AreOfOneKindWhereThereIsNoOther) {
  recipe_.takes_share = 0.5;
  for (const double takes : takes_in_steps(toy_data(0, 2), 5)) EXPECT_EQ(takes, 0);
  dataset::Dataset alone = toy_takes(0, 2);
  for (dataset::Sequence& s : alone.sequences) s.from_take = true;
  for (const double takes : takes_in_steps(alone, 5)) EXPECT_EQ(takes, 10);
  EXPECT_EQ(maker(alone).places(WindowsOf::virtual_performers), 0U);
  EXPECT_EQ(maker(alone).places(WindowsOf::takes), 2U * 161U);
}

TEST_F(MixedBatches, AreAFunctionOfTheStep) {
  const dataset::Dataset data = mixed(200, 300);
  const BatchMaker batches = maker(data);
  const auto make = [&](std::uint64_t step) {
    return batches.random_batch(7, Random(3).fork("batch", step));
  };
  EXPECT_EQ(make(5).condition, make(5).condition);
  EXPECT_NE(make(5).condition, make(6).condition);
}

TEST_F(MixedBatches, TakesAreReadAsTheyAreWhereSkinsAreKnown) {
  dataset::Dataset data = mixed(200, 300);
  const std::size_t slopes = 3 * data.sensors.size() * face::kShapeCount;
  for (dataset::Sequence& s : data.sequences) {
    s.lab = false;
    if (!s.from_take) s.slopes.assign(slopes, 0.3F);
  }
  skin_ = model::Skin{.standard = std::vector<float>(slopes, 0.1F),
                      .covariance = std::vector<float>(face::kShapeCount * face::kShapeCount, 0.0F),
                      .wearer = {}};
  for (std::size_t k = 0; k < face::kShapeCount; ++k) skin_->covariance[k * (face::kShapeCount + 1)] = 0.04F;
  const auto read = [&](double known, WindowsOf whose) {
    recipe_.known_skin = known;
    return maker(data).even_batch(3, Random(1), whose).condition;
  };
  EXPECT_NE(read(0, WindowsOf::virtual_performers), read(1, WindowsOf::virtual_performers));
  EXPECT_EQ(read(0, WindowsOf::takes), read(1, WindowsOf::takes));
}

TEST_F(MixedBatches, TheHashOfTakesIsOfThemAlone) {
  const dataset::Dataset data = mixed(200, 300), other_takes = mixed(200, 301);
  dataset::Dataset others = mixed(240, 300);
  others.sequences.back().performer += 7;  // As more performers would have it.
  EXPECT_EQ(hash_of_takes(data, {}), hash_of_takes(others, {}));
  EXPECT_NE(hash_of_takes(data, {}), hash_of_takes(other_takes, {}));
  EXPECT_NE(hash_of_takes(data, {}), hash_of_takes({}, data));
  dataset::Dataset unmarked = data;
  for (dataset::Sequence& s : unmarked.sequences) s.from_take = false;
  EXPECT_NE(hash_of(data), hash_of(unmarked)) << "a score on them is another score";
}

}  // namespace
}  // namespace mien::train::takes_mix_test
