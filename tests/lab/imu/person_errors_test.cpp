#include "lab/imu/person_errors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/units.h"
#include "tests/synthetic/imu/toy_training_data.h"
#include "tests/tracker/tiny_model.h"
#include "tests/tracker/turning_sensors.h"

namespace mien::lab::person_errors_test {
namespace {

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

}  // namespace
}  // namespace mien::lab::person_errors_test
