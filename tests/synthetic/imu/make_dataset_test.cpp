#include "mien/synthetic/imu/make_dataset.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "mien/core/files.h"
#include "mien/face/livelink_csv.h"
#include "tests/folder.h"
#include "tests/virtual/three_sensors.h"

namespace mien::synthetic::make_dataset_test {
namespace {

using ::testing::HasSubstr;

DataRecipe small_recipe() {
  DataRecipe recipe;
  recipe.seed = 9;
  recipe.performers = 2;
  recipe.validation_performers = 1;
  recipe.seconds = 2;
  recipe.device_seconds = 1;
  recipe.device_long_share = 0;
  return recipe;
}

sensor::Rig rig_with_faults() {
  sensor::Rig rig = virt::test::three_sensors();
  rig.faults_toml = "mount_rotation_deg = 180\ngyro_noise_dps_sqrt_hz = 0.015\npacket_loss = 0.01\n";
  return rig;
}

/// Made once: its making is most of what these tests cost.
const dataset::TrainingData& small_data() {
  static const dataset::TrainingData data =
      make_dataset(small_recipe(), "builtin", rig_with_faults(), no_progress, 1).value();
  return data;
}

void expect_same(const dataset::Dataset& a, const dataset::Dataset& b) {
  EXPECT_EQ(a.sensors, b.sensors);
  ASSERT_EQ(a.sequences.size(), b.sequences.size());
  for (std::size_t i = 0; i < a.sequences.size(); ++i) {
    EXPECT_EQ(a.sequences[i].performer, b.sequences[i].performer);
    EXPECT_EQ(a.sequences[i].lab, b.sequences[i].lab);
    EXPECT_EQ(a.sequences[i].values, b.sequences[i].values);
    EXPECT_EQ(a.sequences[i].present, b.sequences[i].present);
    EXPECT_EQ(a.sequences[i].weights, b.sequences[i].weights);
  }
}

TEST(MakeDataset, GivesTheSameBitsOnTwoThreads) {
  const dataset::TrainingData two =
      make_dataset(small_recipe(), "builtin", rig_with_faults(), no_progress, 2).value();
  expect_same(small_data().train, two.train);
  expect_same(small_data().validation, two.validation);
}

TEST(MakeDataset, TrainingPerformersAloneMayPerformRecordings) {
  face::Motion recording;
  for (int i = 0; i < 90; ++i) {
    recording.frames.push_back({.time_s = i / 30.0});
    for (const std::size_t cheek : {face::shape("cheekPuff_L"), face::shape("cheekPuff_R")})
      recording.frames.back().weights[cheek] = 0.5F + 0.4F * std::sin(0.2F * static_cast<float>(i));
  }
  DataRecipe recipe = small_recipe();
  recipe.recorded_share = 1;
  const std::array recorded = {recording};
  const dataset::TrainingData data =
      make_dataset(recipe, "builtin", rig_with_faults(), no_progress, 1, recorded).value();
  expect_same(small_data().validation, data.validation);
  for (const dataset::Sequence& s : data.train.sequences) {
    float most = 0, least = 1;
    for (std::size_t f = 0; f < s.frames; ++f) {
      const float puffed = s.weights[f * face::kShapeCount + face::shape("cheekPuff_L")];
      most = std::max(most, puffed);
      least = std::min(least, puffed);
    }
    EXPECT_GT(most - least, 0.2);
  }
  // Without the recordings all performances are drawn.
  expect_same(small_data().train, make_dataset(recipe, "builtin", rig_with_faults()).value().train);
}

TEST(MakeDataset, ARecordingThatIsNoneIsNamed) {
  mien::test::Folder folder;
  DataRecipe recipe = small_recipe();
  recipe.recorded = {"away.csv"};
  const auto away = read_recorded(recipe, folder.path());
  ASSERT_FALSE(away);
  EXPECT_THAT(away.error().message(), HasSubstr("away.csv"));
  ASSERT_TRUE(write_file(folder / "short.csv", face::format_livelink_csv(face::Motion{
                                                   .name = "short", .frames = {{.time_s = 0}}})));
  recipe.recorded = {"short.csv"};
  const auto brief = read_recorded(recipe, folder.path());
  ASSERT_FALSE(brief);
  EXPECT_EQ(brief.error().code, ErrorCode::out_of_range);
}

TEST(MakeDataset, HoldsPeopleOut) {
  std::set<std::uint32_t> trained;
  for (const dataset::Sequence& s : small_data().train.sequences) trained.insert(s.performer);
  EXPECT_EQ(trained, (std::set<std::uint32_t>{0, 1}));
  EXPECT_EQ(small_data().train.sequences.size(), 4U);  // Lab and device, each.
  ASSERT_EQ(small_data().validation.sequences.size(), 2U);
  for (const dataset::Sequence& s : small_data().validation.sequences) EXPECT_EQ(s.performer, 2U);
}

TEST(MakeDataset, IsWhatItsCommentsSay) {
  const std::vector<std::string> sensors = {"mentalis", "buccinator_L"};
  for (const dataset::Dataset* data : {&small_data().train, &small_data().validation}) {
    EXPECT_EQ(data->sensors, sensors);
    for (const dataset::Sequence& s : data->sequences) {
      EXPECT_NEAR(static_cast<double>(s.frames), s.lab ? 120 : 60, 2);
      ASSERT_EQ(s.values.size(), s.frames * 14);
      ASSERT_EQ(s.present.size(), s.frames * 4);
      ASSERT_EQ(s.weights.size(), s.frames * face::kShapeCount);
      for (const float w : s.weights) ASSERT_TRUE(w >= 0 && w <= 1) << w;
      std::size_t rotations = 0;
      for (std::size_t f = 0; f < s.frames; ++f)
        for (std::size_t sensor = 0; sensor < 2; ++sensor) {
          const float* v = &s.values[14 * f + 7 * sensor];
          for (int i = 0; i < 7; ++i) ASSERT_TRUE(std::isfinite(v[i]));
          ASSERT_NEAR(v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6], 1, 1e-4);
          ASSERT_GE(v[3], 0);
          const bool has_rotation = s.present[4 * f + sensor] == 1;
          const bool has_accel = s.present[4 * f + 2 + sensor] == 1;
          ASSERT_LE(s.present[4 * f + sensor], 1);
          rotations += has_rotation ? 1 : 0;
          if (s.lab) {
            ASSERT_TRUE(has_rotation && !has_accel);
          }
        }
      EXPECT_GT(rotations, s.frames);  // Both sensors, mostly.
    }
  }
}

TEST(MakeDataset, PeopleAreDifferent) {
  const auto& sequences = small_data().train.sequences;
  EXPECT_NE(sequences[0].values, sequences[2].values);
  EXPECT_NE(sequences[0].weights, sequences[2].weights);
}

TEST(MakeDataset, SaysHowFarItIsAndStopsWhenAsked) {
  const auto data = make_dataset(
      small_recipe(), "builtin", rig_with_faults(), [](double, std::string_view) { return false; }, 1);
  ASSERT_FALSE(data);
  EXPECT_EQ(data.error().code, ErrorCode::cancelled);
}

TEST(MakeDataset, RefusesAFaceOrFaultsThatAreNone) {
  EXPECT_FALSE(make_dataset(small_recipe(), "no/such/folder", rig_with_faults()));
  sensor::Rig rig = rig_with_faults();
  rig.faults_toml = "packet_loss = 2\n";
  const auto data = make_dataset(small_recipe(), "builtin", rig);
  ASSERT_FALSE(data);
  EXPECT_THAT(data.error().message(), HasSubstr("packet_loss"));
}

TEST(DataRecipe, ReadsEveryKey) {
  const DataRecipe recipe = parse_data_recipe(
                                "seed = 7\nperformers = 3\nvalidation_performers = 2\nseconds = 40\n"
                                "device_seconds = 20.5\ndevice_share = 0.25\nidentities = false\n"
                                "placement_mm = 1.5\nkinematics_gain = 0.1\nkinematics_deg = 90\n"
                                "recorded_share = 0.5\nrecorded = [\"a.csv\", \"b.csv\"]\n",
                                "r.toml")
                                .value();
  DataRecipe expected;
  expected.seed = 7;
  expected.performers = 3;
  expected.validation_performers = 2;
  expected.seconds = 40;
  expected.device_seconds = 20.5;
  expected.device_share = 0.25;
  expected.identities = false;
  expected.placement_mm = 1.5;
  expected.kinematics.gain = 0.1;
  expected.kinematics.direction_rad = recipe.kinematics.direction_rad;
  expected.recorded_share = 0.5;
  expected.recorded = {"a.csv", "b.csv"};
  EXPECT_EQ(recipe, expected);
  EXPECT_NEAR(recipe.kinematics.direction_rad, M_PI / 2, 1e-12);
  EXPECT_EQ(parse_data_recipe("", "r.toml").value(), DataRecipe{});
}

TEST(DataRecipe, EveryWrongSettingIsRefusedByName) {
  for (const auto& [text, name] : std::vector<std::pair<std::string, std::string>>{
           {"seed = -1", "seed"},
           {"seed = 1.5", "seed"},
           {"seed = \"one\"", "seed"},
           {"performers = 0", "performers"},
           {"performers = 2000000", "performers"},
           {"performers = 2.5", "performers"},
           {"validation_performers = 0", "validation_performers"},
           {"validation_performers = []", "validation_performers"},
           {"seconds = -1", "seconds"},
           {"seconds = 0.5", "seconds"},
           {"seconds = inf", "seconds"},
           {"seconds = nan", "seconds"},
           {"seconds = 1e9", "seconds"},
           {"device_seconds = true", "device_seconds"},
           {"device_seconds = 1e9", "device_seconds"},
           {"device_share = 1.5", "device_share"},
           {"device_share = -0.5", "device_share"},
           {"identities = 1", "identities"},
           {"placement_mm = 100", "placement_mm"},
           {"placement_mm = nan", "placement_mm"},
           {"kinematics_gain = -0.1", "kinematics_gain"},
           {"kinematics_deg = 181", "kinematics_deg"},
           {"recorded_share = 1.5\nrecorded = [\"a.csv\"]", "recorded_share"},
           {"recorded_share = 0.5", "recorded"},
           {"recorded = [\"a.csv\"]", "recorded_share"},
           {"recorded_share = 0.5\nrecorded = []", "recorded"},
           {"recorded_share = 0.5\nrecorded = [3]", "recorded"},
           {"recorded_share = 0.5\nrecorded = \"a.csv\"", "recorded"},
           {"recorded_share = 0.5\nrecorded = [\"../a.csv\"]", "without a folder"},
           {"minutes = 3", "minutes"},
           {"seconds = 0\ndevice_seconds = 0", "nothing to perform"},
           {"seconds =", "line 1"}}) {
    const auto recipe = parse_data_recipe(text, "r.toml");
    ASSERT_FALSE(recipe) << text;
    EXPECT_THAT(recipe.error().message(), HasSubstr(name)) << text;
    EXPECT_THAT(recipe.error().message(), HasSubstr("r.toml")) << text;
    EXPECT_EQ(recipe.error().message().find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace mien::synthetic::make_dataset_test
