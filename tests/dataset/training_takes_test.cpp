#include "mien/dataset/training_takes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "mien/core/files.h"
#include "mien/dataset/recorded_take.h"
#include "tests/dataset/written_take.h"

namespace mien::dataset::training_takes_test {
namespace {

using test::Folder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::size_t frames_in(const Dataset& data) {
  std::size_t frames = 0;
  for (const Sequence& sequence : data.sequences) frames += sequence.frames;
  return frames;
}

std::set<std::uint32_t> performers_in(const Dataset& data) {
  std::set<std::uint32_t> performers;
  for (const Sequence& sequence : data.sequences) performers.insert(sequence.performer);
  return performers;
}

/// Three people, one take each, and one of nobody.
class TrainingTakes : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new Folder;
    const virt::VirtualSession session = test::talking_session(6);
    for (const char* name : {"Anna", "Ben", "Carl"})
      test::write_take(*folder_ / (std::string(name) + ".mien"), session,
                       {.performer = "", .consents = name});
    test::write_take(*folder_ / "nobody.mien", session, {.performer = ""});
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static Result<TakesData> read(const std::string& splits = {}, std::uint64_t seed = 1) {
    if (splits.empty()) return read_training_takes(folder_->path(), {}, rig(), seed, no_progress);
    const Folder other;
    EXPECT_TRUE(write_file(other / "s.toml", splits));
    return read_training_takes(folder_->path(), other / "s.toml", rig(), seed, no_progress);
  }
  static sensor::Rig rig() { return virt::test::three_sensors(); }
  static Folder* folder_;
};
Folder* TrainingTakes::folder_ = nullptr;

TEST_F(TrainingTakes, HaveEachPersonInOneSet) {
  const auto takes = read();
  ASSERT_TRUE(takes) << takes.error().message();
  EXPECT_EQ(takes->training_people.size(), 2u);
  EXPECT_EQ(takes->validation_people.size(), 1u);
  EXPECT_THAT(takes->left_out, ElementsAre(HasSubstr("nobody.mien: nobody consented")));
  for (const Dataset* data : {&takes->data.train, &takes->data.validation}) {
    EXPECT_THAT(data->sensors, ElementsAre("mentalis", "buccinator_L"));
    for (const Sequence& sequence : data->sequences) {
      EXPECT_GE(sequence.frames, kShortestStretchFrames);
      EXPECT_EQ(sequence.values.size(), sequence.frames * 14);
      EXPECT_EQ(sequence.present.size(), sequence.frames * 4);
      EXPECT_EQ(sequence.weights.size(), sequence.frames * face::kShapeCount);
      EXPECT_TRUE(sequence.slopes.empty());
    }
  }
  EXPECT_EQ(performers_in(takes->data.train).size(), 2u);
  for (const std::uint32_t performer : performers_in(takes->data.validation))
    EXPECT_FALSE(performers_in(takes->data.train).contains(performer));
  // Somebody else validates by another seed, and the same by the same.
  EXPECT_EQ(read({}, 1)->validation_people, takes->validation_people);
  std::set<std::string> validated;
  for (std::uint64_t seed = 1; seed < 12; ++seed) validated.insert(read({}, seed)->validation_people.front());
  EXPECT_EQ(validated.size(), 3u);
}

TEST_F(TrainingTakes, GoByAFileThatKeepsSomebodyForTheTest) {
  const auto takes = read("[split]\ntrain = [\"Carl\"]\nvalidation = [\"Anna\"]\ntest = [\"Ben\"]");
  ASSERT_TRUE(takes) << takes.error().message();
  EXPECT_THAT(takes->training_people, ElementsAre("Carl"));
  EXPECT_THAT(takes->validation_people, ElementsAre("Anna"));
  EXPECT_THAT(takes->left_out, ::testing::UnorderedElementsAre("Ben.mien: Ben is kept for the test",
                                                               HasSubstr("nobody.mien")));
  EXPECT_EQ(frames_in(takes->data.train), frames_in(takes->data.validation));
  const auto refused = [](const std::string& splits, ErrorCode code, const std::string& says) {
    const auto wrong = read(splits);
    ASSERT_FALSE(wrong) << splits;
    EXPECT_EQ(wrong.error().code, code);
    EXPECT_THAT(wrong.error().message(), HasSubstr(says));
  };
  refused("[split]\ntrain = [\"Carl\"]\nvalidation = [\"Anna\"]", ErrorCode::mismatch, "\"Ben\" is in none");
  refused("[split]\ntrain = [\"Karl\"]", ErrorCode::not_found, "did you mean Carl?");
  refused("[split]\ntrain = [\"Anna\", \"Ben\", \"Carl\"]", ErrorCode::not_found, "validate on");
  refused("[split]\nvalidation = [\"Anna\", \"Ben\", \"Carl\"]", ErrorCode::not_found, "train on");
}

TEST_F(TrainingTakes, AreOfTheRigThatIsTrained) {
  const sensor::Rig other = sensor::read_rig(project_path("rigs/default.toml")).value();
  const auto refused = read_training_takes(folder_->path(), {}, other, 1, no_progress);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::mismatch);
  const Folder nothing;
  ASSERT_TRUE(write_file(nothing / "foreign.mien", "x"));
  EXPECT_EQ(read_training_takes(nothing.path(), {}, rig(), 1, no_progress).error().code,
            ErrorCode::not_found);
  const auto stop = [](double, std::string_view) { return false; };
  EXPECT_EQ(read_training_takes(folder_->path(), {}, rig(), 1, stop).error().code, ErrorCode::cancelled);
}

TEST(TrainingTakesOfOne, ValidateWithTheEndOfEachTake) {
  const Folder folder;
  const virt::VirtualSession session = test::talking_session(24);
  test::write_take(folder / "a.mien", session, {.performer = "", .consents = "Anna"});
  const auto takes = read_training_takes(folder.path(), {}, virt::test::three_sensors(), 1, no_progress);
  ASSERT_TRUE(takes) << takes.error().message();
  EXPECT_THAT(takes->training_people, ElementsAre("Anna"));
  EXPECT_THAT(takes->validation_people, ElementsAre("Anna"));
  EXPECT_THAT(takes->left_out, ElementsAre(HasSubstr("Anna is alone")));
  const RecordedTake take = read_recorded_take(take::Take::open(folder / "a.mien").value()).value();
  ASSERT_EQ(take.stretches.size(), 1u);
  const Sequence& whole = take.stretches[0].sequence;
  ASSERT_EQ(takes->data.train.sequences.size(), 1u);
  ASSERT_EQ(takes->data.validation.sequences.size(), 1u);
  const Sequence& trains = takes->data.train.sequences[0];
  const Sequence& validates = takes->data.validation.sequences[0];
  EXPECT_NE(trains.performer, validates.performer);
  EXPECT_NEAR(static_cast<double>(validates.frames), 0.2 * static_cast<double>(whole.frames), 1);
  EXPECT_EQ(whole.frames - trains.frames - validates.frames, 120u);
  EXPECT_TRUE(std::equal(trains.weights.begin(), trains.weights.end(), whole.weights.begin()));
  EXPECT_TRUE(std::equal(validates.weights.rbegin(), validates.weights.rend(), whole.weights.rbegin()));
  EXPECT_TRUE(std::equal(validates.values.rbegin(), validates.values.rend(), whole.values.rbegin()));

  // Too short for a fifth that lasts two seconds.
  const Folder brief;
  test::write_take(brief / "a.mien", test::talking_session(7), {.performer = "", .consents = "Anna"});
  const auto refused = read_training_takes(brief.path(), {}, virt::test::three_sensors(), 1, no_progress);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace mien::dataset::training_takes_test
