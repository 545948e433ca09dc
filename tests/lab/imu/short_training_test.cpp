#include "lab/imu/short_training.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/toml.h"
#include "mien/core/units.h"
#include "tests/project_path.h"
#include "tests/synthetic/imu/toy_training_data.h"
#include "tests/tracker/tiny_model.h"
#include "tests/tracker/turning_sensors.h"

namespace mien::lab::short_training_test {
namespace {

TEST(ShortRecipes, HaveTheDataThatTheyAreToldToHave) {
  synthetic::DataRecipe data = short_data(7);
  data.performers = 31;
  const auto read = synthetic::parse_data_recipe(data_table(data), "recipe");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->performers, 31);
  EXPECT_EQ(read->seed, 7U);
  EXPECT_EQ(read->device_share, data.device_share);
  EXPECT_NEAR(read->kinematics.direction_rad, data.kinematics.direction_rad, 1e-6);
}

TEST(ShortRecipes, AreTomlAndNoTwoAlike) {
  std::set<std::string> texts;
  for (const ShortNetwork network :
       {ShortNetwork::recurrent, ShortNetwork::transformer, ShortNetwork::diffusion})
    for (const std::size_t window : {30, 120})
      for (const std::uint64_t seed : {1, 2}) {
        const std::string text =
            short_recipe({.seed = seed, .steps = 60, .network = network, .window = window}, short_data(1));
        const auto table = parse_toml(text, "recipe");
        ASSERT_TRUE(table) << table.error().message();
        EXPECT_EQ((*table)["budget"]["steps"].value<std::int64_t>(), 60);
        const auto batch = (*table)["optimiser"]["batch"].value<std::int64_t>();
        EXPECT_EQ(batch.value_or(0) * static_cast<std::int64_t>(window), 3840);
        EXPECT_TRUE(texts.insert(text).second);
      }
}

TEST(TrainingSeed, IsWhatARecipeTakes) {
  EXPECT_EQ(training_seed(1, 0), 100U);
  EXPECT_EQ(training_seed(7, 2), 702U);
  constexpr std::uint64_t kHuge = std::numeric_limits<std::uint64_t>::max();
  EXPECT_EQ(recipe_seed(kHuge >> 1U), kHuge >> 1U);
  synthetic::DataRecipe data = short_data(recipe_seed(kHuge));
  EXPECT_TRUE(synthetic::parse_data_recipe(data_table(data), "recipe"));
  for (const std::uint64_t seed : {kHuge, kHuge - 1, kHuge >> 1U, kHuge / 100}) {
    const auto table = parse_toml(short_recipe({.seed = training_seed(seed, 99)}, data), "recipe");
    ASSERT_TRUE(table) << table.error().message();
    EXPECT_GE((*table)["seed"].value<std::int64_t>().value_or(-1), 0) << seed;
  }
}

const std::vector<std::string> kSensors = {"mentalis", "buccinator_L"};

synthetic::ImuPerson someone(float weight) {
  synthetic::ImuPerson out;
  out.features = tracker::test::turning(70);
  out.truth.resize(70);
  for (face::BlendshapeWeights& truth : out.truth)
    for (std::size_t k = 0; k < face::kShapeCount; ++k) truth[k] = weight;
  return out;
}

const measure::Meter& meter() {
  static const measure::Meter made(builtin_face::make_builtin());
  return made;
}

TEST(PersonErrors, AreOfTheModelsOwnAnswers) {
  const model::ModelFile model = tracker::test::tiny_causal_model(kSensors);
  synthetic::ImuPerson right = someone(0);
  right.truth = *synthetic::answers_of(model, kSensors, right.features);
  const auto errors = errors_of_people(model, kSensors, std::vector{right, someone(1)}, meter());
  ASSERT_TRUE(errors) << errors.error().message();
  EXPECT_NEAR((*errors)[0].mse, 0, 1e-9);
  EXPECT_NEAR((*errors)[0].pve_mm, 0, 1e-4);
  EXPECT_GT((*errors)[1].mse, 0.05);
  EXPECT_GT((*errors)[1].pve_mm, 1);
  EXPECT_GT((*errors)[1].lmk_mm, 1);
}

TEST(PersonErrors, AreTheSameForAnyNumberOfThreads) {
  const model::ModelFile model = tracker::test::tiny_causal_model(kSensors);
  const std::vector people = {someone(0), someone(0.3F), someone(0.6F), someone(1)};
  const auto alone = errors_of_people(model, kSensors, people, meter(), synthetic::WindowJoin::overlap, 1);
  const auto together = errors_of_people(model, kSensors, people, meter(), synthetic::WindowJoin::overlap, 3);
  ASSERT_TRUE(alone && together);
  for (std::size_t p = 0; p < people.size(); ++p) {
    EXPECT_EQ((*alone)[p].pve_mm, (*together)[p].pve_mm);
    EXPECT_EQ((*alone)[p].mse, (*together)[p].mse);
    EXPECT_EQ((*alone)[p].jitter, (*together)[p].jitter);
  }
}

TEST(PersonErrors, OfWindowsSideBySideAreThoseOfEachAlone) {
  // Windows of 16 frames: 70 frames are four of them and a short one.
  const model::ModelFile model = tracker::test::tiny_model(kSensors);
  synthetic::ImuPerson person = someone(0);
  person.truth.clear();
  for (std::size_t begin = 0; begin < 70; begin += 16) {
    const auto part = synthetic::answers_of(
        model, kSensors, std::span(person.features).subspan(begin, std::min<std::size_t>(16, 70 - begin)));
    person.truth.insert(person.truth.end(), part->begin(), part->end());
  }
  const auto apart =
      errors_of_people(model, kSensors, std::vector{person}, meter(), synthetic::WindowJoin::side_by_side);
  const auto joined = errors_of_people(model, kSensors, std::vector{person}, meter());
  ASSERT_TRUE(apart && joined);
  EXPECT_NEAR((*apart)[0].mse, 0, 1e-9);
  EXPECT_GT((*joined)[0].mse, 1e-7);
}

TEST(WatchedInLab, HaveADegreeOfNoise) {
  dataset::Dataset data;
  data.sensors = {"mentalis"};
  data.sequences.resize(2);  // The other profile's is left out.
  dataset::Sequence& lab = data.sequences[1];
  lab.lab = true;
  std::vector<model::SensorFeature> still(1);
  still[0].has_rotation = true;
  for (int f = 0; f < 2000; ++f) dataset::append_frame(still, {}, lab);
  const std::vector<synthetic::ImuPerson> people = watched_in_lab(data, 5);
  ASSERT_EQ(people.size(), 1U);
  double square = 0;
  for (const model::FeatureFrame& frame : people[0].features)
    for (int axis = 1; axis < 4; ++axis)
      square += std::pow(2 * frame.sensors[0].rotation[static_cast<std::size_t>(axis)], 2) / 6000;
  EXPECT_NEAR(std::sqrt(square), kRadPerDeg, 0.05 * kRadPerDeg);
  EXPECT_EQ(watched_in_lab(data, 5)[0].features[7].sensors[0].rotation,
            people[0].features[7].sensors[0].rotation);
}

const sensor::Rig& default_rig() {
  static const sensor::Rig rig = sensor::read_rig(project_path("rigs/default.toml")).value();
  return rig;
}

TEST(RigWithSensors, HasTheMarginalOfTheSkin) {
  const auto part =
      rig_with_sensors(default_rig(), std::array<std::string, 2>{"mentalis", "zygomaticus_lower_R"});
  ASSERT_TRUE(part) << part.error().message();
  // The rig's order, and the head's sensor.
  EXPECT_EQ(part->face_sensor_names(), (std::vector<std::string>{"zygomaticus_lower_R", "mentalis"}));
  EXPECT_TRUE(part->head_sensor());
  EXPECT_EQ(part->reference, default_rig().reference);
  const sensor::SkinMotion &whole = *default_rig().skin, &few = *part->skin;
  ASSERT_EQ(few.sensors, part->face_sensor_names());
  const Eigen::MatrixXd all = whole.factor_deg * whole.factor_deg.transpose(),
                        left = few.factor_deg * few.factor_deg.transpose();
  for (Eigen::Index a = 0; a < 3; ++a) {
    EXPECT_EQ(few.mean_deg[a], whole.mean_deg[18 + a]);      // zygomaticus_lower_R is the seventh.
    EXPECT_EQ(few.mean_deg[3 + a], whole.mean_deg[30 + a]);  // mentalis is the eleventh.
    for (Eigen::Index b = 0; b < 3; ++b) {
      EXPECT_NEAR(left(a, b), all(18 + a, 18 + b), 1e-9);
      EXPECT_NEAR(left(a, 3 + b), all(18 + a, 30 + b), 1e-9);
    }
  }
  const auto read = sensor::parse_rig(sensor::write_rig(*part), "part");
  ASSERT_TRUE(read) << read.error().message();
}

TEST(RigWithSensors, OfAllIsTheRig) {
  const auto same = rig_with_sensors(default_rig(), default_rig().face_sensor_names());
  ASSERT_TRUE(same);
  EXPECT_EQ(sensor::write_rig(*same), sensor::write_rig(default_rig()));
}

TEST(RigWithSensors, RefusesWhatItHasNot) {
  EXPECT_EQ(rig_with_sensors(default_rig(), {}).error().code, ErrorCode::bad_usage);
  const auto unknown = rig_with_sensors(default_rig(), std::array<std::string, 1>{"mastoid_L"});
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace mien::lab::short_training_test
