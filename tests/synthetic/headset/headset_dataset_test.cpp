#include "mien/synthetic/headset/headset_dataset.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "mien/core/files.h"
#include "tests/folder.h"
#include "tests/project_path.h"

namespace mien::synthetic::headset_dataset_test {
namespace {

const sensor::Rig& rig() {
  static const sensor::Rig rig = sensor::read_rig(project_path("rigs/headset.toml")).value();
  return rig;
}

const HeadsetDataRecipe kSmall{.wearers = 2,
                               .validation_wearers = 1,
                               .donnings = 1,
                               .frames = 4,
                               .neutral_frames = 2,
                               .rates_hz = {10},
                               .side = 24};

TEST(HeadsetFilms, AreRenderedOnceAndTheSameOnAnyNumberOfThreads) {
  const mien::test::Folder one, two;
  const auto first = make_headset_films(kSmall, rig(), one.path(), no_progress, 1);
  ASSERT_TRUE(first) << first.error().message();
  ASSERT_EQ(first->train.size(), 2u);
  ASSERT_EQ(first->validation.size(), 1u);
  const auto second = make_headset_films(kSmall, rig(), two.path(), no_progress, 2);
  ASSERT_TRUE(second) << second.error().message();
  for (std::size_t f = 0; f < 2; ++f) {
    const HeadsetFilm &a = first->train[f], &b = second->train[f];
    ASSERT_EQ(a.frames(), b.frames());
    EXPECT_EQ(a.views(), 4u);
    EXPECT_EQ(a.side(), 24u);
    for (std::size_t frame = 0; frame < a.frames(); ++frame)
      for (std::size_t view = 0; view < 4; ++view)
        EXPECT_TRUE(std::ranges::equal(a.view(frame, view), b.view(frame, view)));
  }
  EXPECT_FALSE(std::ranges::equal(first->train[0].view(0, 0), first->train[1].view(0, 0)));

  // What stands there is taken as it is; films of another recipe are refused.
  const auto before = std::filesystem::last_write_time(one.path() / "train_00000.film");
  ASSERT_TRUE(make_headset_films(kSmall, rig(), one.path(), no_progress, 1));
  EXPECT_EQ(std::filesystem::last_write_time(one.path() / "train_00000.film"), before);
  HeadsetDataRecipe other = kSmall;
  other.seed = 2;
  const auto refused = make_headset_films(other, rig(), one.path(), no_progress, 1);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::mismatch);
}

TEST(HeadsetFilms, BeginWithTheNeutralAndTellTheTruth) {
  const mien::test::Folder folder;
  const auto films = make_headset_films(kSmall, rig(), folder.path(), no_progress, 1);
  ASSERT_TRUE(films) << films.error().message();
  const HeadsetFilm& film = films->validation[0];
  const FilmTruth rest = film.truth(0);
  EXPECT_EQ(rest.neutral, 1);
  EXPECT_EQ(*std::ranges::max_element(rest.weights), 0);
  EXPECT_FLOAT_EQ(rest.openness[0], 1);
  ASSERT_EQ(film.frames(), 6u);
  EXPECT_EQ(film.truth(1).neutral, 1);
  EXPECT_EQ(film.truth(2).neutral, 0);
  EXPECT_FLOAT_EQ(film.truth(0).time_s, 0);
  EXPECT_FLOAT_EQ(film.truth(5).time_s, 0.5F);
  bool moves = false;
  for (std::size_t frame = 0; frame < film.frames(); ++frame) {
    const FilmTruth truth = film.truth(frame);
    for (const float weight : truth.weights) {
      EXPECT_GE(weight, 0);
      EXPECT_LE(weight, 1);
    }
    moves = moves || (truth.neutral == 0 && *std::ranges::max_element(truth.weights) > 0.1F);
  }
  EXPECT_TRUE(moves);
}

TEST(HeadsetFilms, ACutOffFileIsRefused) {
  const mien::test::Folder folder;
  const std::vector<FilmFrame> frames(3, {.truth = {}, .views = {{1, 2, 3, 4}, {5, 6, 7, 8}}});
  const auto path = folder.path() / "a.film";
  ASSERT_TRUE(write_film(path, std::string(64, 'a'), 2, 2, frames));
  ASSERT_TRUE(HeadsetFilm::open(path));
  EXPECT_EQ(HeadsetFilm::open(path)->view(1, 1)[2], 7);
  const auto bytes = read_file(path).value();
  for (const std::size_t size : {bytes.size() - 1, bytes.size() / 2, std::size_t{50}, std::size_t{0}}) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(size));
    EXPECT_FALSE(HeadsetFilm::open(path)) << size;
  }
  EXPECT_FALSE(HeadsetFilm::open(folder.path() / "none.film"));
  EXPECT_FALSE(write_film(path, std::string(64, 'a'), 3, 2, frames));
}

TEST(HeadsetDataRecipe, IsReadAndRefused) {
  const auto recipe =
      parse_headset_data_recipe("wearers = 7\nframes = 50\nside = 64\nrates_hz = [15, 29.97]", "r");
  ASSERT_TRUE(recipe) << recipe.error().message();
  EXPECT_EQ(recipe->wearers, 7);
  EXPECT_EQ(recipe->side, 64);
  EXPECT_EQ(recipe->frames, 50);
  EXPECT_EQ(recipe->rates_hz, (std::vector<double>{15, 29.97}));
  for (const char* wrong : {"wearers = 0", "wearers = 1.5", "side = 1000", "failing = 2", "winks = -1",
                            "closed_lips = true", "frames = \"many\"", "rates_hz = 30", "rates_hz = []",
                            "rates_hz = [30, 0]", "rates_hz = [\"a\"]", "people = 3"})
    EXPECT_FALSE(parse_headset_data_recipe(wrong, "r")) << wrong;
}

TEST(HeadsetDataRecipe, PosesHaveShares) {
  const auto recipe = parse_headset_data_recipe("eyes_alone = 0.5\nwinks = 0.25\nclosed_lips = 0", "r");
  ASSERT_TRUE(recipe) << recipe.error().message();
  EXPECT_EQ(recipe->poses, (PoseShares{.eyes_alone = 0.5, .winks = 0.25}));
  EXPECT_EQ(parse_headset_data_recipe("eyes_alone = 0.6\nwinks = 0.5", "r").error().code,
            ErrorCode::out_of_range);
}

/// Frames of a motion in which what is asked holds.
template <class Holds>
double share_of(const PoseShares& shares, const Holds& holds) {
  const face::Motion motion = headset_motion(60, Random(4), shares);
  return static_cast<double>(std::ranges::count_if(motion.frames, holds)) /
         static_cast<double>(motion.frames.size());
}

TEST(HeadsetMotion, ShowsMoreOfWhatHasAShare) {
  const auto winks = [](const face::MotionFrame& frame) {
    return std::abs(frame.weights[face::shape("eyeBlink_L")] - frame.weights[face::shape("eyeBlink_R")]) >
           0.6F;
  };
  EXPECT_GT(share_of({.winks = 1}, winks), 0.2);
  EXPECT_LT(share_of({}, winks), 0.05);
  const auto closed_lips = [](const face::MotionFrame& frame) {
    return frame.weights[face::shape("mouthClose")] > 0.1F;
  };
  EXPECT_GT(share_of({.closed_lips = 1}, closed_lips), 0.2);
  EXPECT_LT(share_of({}, closed_lips), 0.1);
  const auto looks_alone = [](const face::MotionFrame& frame) {
    float face = frame.tongue_out, look = 0;
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      float& most = face::kShapeNames[k].starts_with("eyeLook") ? look : face;
      most = std::max(most, frame.weights[k]);
    }
    return look > 0.2F && face < 0.02F;
  };
  EXPECT_GT(share_of({.eyes_alone = 1}, looks_alone), 0.15);
  EXPECT_LT(share_of({}, looks_alone), 0.05);
}

TEST(HeadsetDataRecipe, TestsFailOtherwiseThanTraining) {
  for (const virt::HeadsetFailure failure : test_failures()) {
    const auto known = training_failures();
    EXPECT_EQ(std::ranges::count(known, failure), 0) << virt::failure_name(failure);
  }
}

}  // namespace
}  // namespace mien::synthetic::headset_dataset_test
