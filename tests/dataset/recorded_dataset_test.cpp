#include "mien/dataset/recorded_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mien/core/files.h"
#include "tests/dataset/written_take.h"

namespace mien::dataset::recorded_dataset_test {
namespace {

using test::Folder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A folder with three takes that count, of two people, and five that do not.
class RecordedDatasets : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new Folder;
    const virt::VirtualSession session = test::talking_session(6);
    const auto write = [&](const std::string& name, const test::WrittenTake& what) {
      test::write_take(*folder_ / name, session, what);
    };
    write("b.mien", {.performer = "", .consents = "Ben"});
    write("a.mien", {.performer = "", .consents = "Anna"});
    write("c.mien", {.performer = "", .consents = "Anna"});
    write("nobody.mien", {.performer = "somebody"});
    write("other.mien", {.performer = "", .rig_toml = test::rig_of_one_face_sensor(), .consents = "Carl"});
    const std::vector<std::byte> whole = read_file(*folder_ / "a.mien").value();
    ASSERT_TRUE(write_file(*folder_ / "cut.mien", std::span(whole).first(whole.size() / 2)));
    ASSERT_TRUE(write_file(*folder_ / "foreign.mien", "Not a take at all.\n"));
    ASSERT_TRUE(write_file(*folder_ / "notes.txt", "Not looked at.\n"));
    std::filesystem::create_directory(*folder_ / "within.mien");
    // One that is being recorded, and holds nothing yet.
    take::Header header;
    header.performer = "virtual:1";
    header.rig_toml = virt::test::kRig;
    growing_ = new take::TakeWriter(take::TakeWriter::create(*folder_ / "now.mien", header, false).value());
  }
  static void TearDownTestSuite() {
    delete growing_;
    growing_ = nullptr;
    delete folder_;
    folder_ = nullptr;
  }
  static Folder* folder_;
  static take::TakeWriter* growing_;
};
Folder* RecordedDatasets::folder_ = nullptr;
take::TakeWriter* RecordedDatasets::growing_ = nullptr;

TEST_F(RecordedDatasets, KnowWhoseTakesTheyAreBeforeTheyAreRead) {
  const auto found = find_takes(folder_->path(), {}, no_progress);
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_THAT(found->sensors, ElementsAre("mentalis", "buccinator_L"));
  ASSERT_EQ(found->takes.size(), 4u);
  EXPECT_EQ(found->takes[0].path.filename(), "a.mien");
  EXPECT_EQ(found->takes[1].performer, "Ben");
  EXPECT_THAT(found->people(), ElementsAre("Anna", "Ben", "Carl", "virtual:1"));
  ASSERT_EQ(found->left_out.size(), 4u);
  EXPECT_EQ(found->left_out[0].path.filename(), "cut.mien");
  EXPECT_EQ(found->left_out[1].sentence(), "foreign.mien: this is not a take");
  EXPECT_THAT(found->left_out[2].sentence(), HasSubstr("nobody.mien: nobody consented"));
  EXPECT_EQ(found->left_out[3].sentence(),
            "other.mien: it has other sensors on the face: mastoid_L too many, buccinator_L missing");

  const auto others = find_takes(folder_->path(), {"mentalis", "mastoid_L"}, no_progress);
  ASSERT_TRUE(others);
  ASSERT_EQ(others->takes.size(), 1u);
  EXPECT_EQ(others->takes[0].performer, "Carl");
  const auto turned = find_takes(folder_->path(), {"buccinator_L", "mentalis"}, no_progress);
  ASSERT_TRUE(turned);
  EXPECT_TRUE(turned->takes.empty());
  EXPECT_THAT(turned->left_out.front().why, HasSubstr("in another order"));
}

TEST_F(RecordedDatasets, ListPeopleWithTheirTakesAndWhatIsLeftOut) {
  const FoundTakes found = find_takes(folder_->path(), {}, no_progress).value();
  std::size_t frames = 0;
  const auto dataset = read_dataset(found, no_progress, [&](RecordedTake& take) -> Result<void> {
    for (const CountedStretch& stretch : take.stretches) frames += stretch.sequence.frames;
    take.stretches.clear();  // As who keeps them does.
    return {};
  });
  ASSERT_TRUE(dataset) << dataset.error().message();
  ASSERT_EQ(dataset->people.size(), 2u);
  EXPECT_EQ(dataset->people[0].name, "Anna");
  EXPECT_THAT(dataset->people[0].takes, ElementsAre(0u, 2u));
  EXPECT_THAT(dataset->people[1].takes, ElementsAre(1u));
  ASSERT_EQ(dataset->takes.size(), 3u);
  double counted_s = 0;
  for (const TakeOverview& take : dataset->takes) counted_s += take.seconds.counted;
  EXPECT_GT(counted_s, 3 * 4);
  EXPECT_NEAR(static_cast<double>(frames) / 60, counted_s, 1e-6);
  EXPECT_EQ(dataset->ranges, dataset->takes[0].ranges);  // They are all the same performance.
  ASSERT_EQ(dataset->left_out.size(), 5u);
  EXPECT_EQ(dataset->left_out[3].sentence(), "now.mien: the take has no frames");
  EXPECT_EQ(dataset->left_out[3].performer, "virtual:1");
}

TEST_F(RecordedDatasets, StopWhenAsked) {
  const FoundTakes found = find_takes(folder_->path(), {}, no_progress).value();
  const auto stop = [](double, std::string_view) { return false; };
  EXPECT_EQ(find_takes(folder_->path(), {}, stop).error().code, ErrorCode::cancelled);
  EXPECT_EQ(read_dataset(found, stop).error().code, ErrorCode::cancelled);
  const auto refuse = [](RecordedTake&) -> Result<void> { return fail(ErrorCode::io, "the disk is full"); };
  EXPECT_EQ(read_dataset(found, no_progress, refuse).error().what, "the disk is full");
}

TEST(RecordedDataset, IsAFolderWithTakes) {
  const Folder folder;
  EXPECT_EQ(find_takes(folder / "nowhere", {}, no_progress).error().code, ErrorCode::not_found);
  const auto empty = find_takes(folder.path(), {}, no_progress);
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().code, ErrorCode::not_found);
  EXPECT_THAT(empty.error().message(), HasSubstr("no take (*.mien)"));
  // Takes that are all left out are a dataset in which nobody is.
  ASSERT_TRUE(write_file(folder / "foreign.mien", "x"));
  const auto found = find_takes(folder.path(), {}, no_progress);
  ASSERT_TRUE(found);
  const auto dataset = read_dataset(*found, no_progress);
  ASSERT_TRUE(dataset);
  EXPECT_TRUE(dataset->people.empty());
  EXPECT_EQ(dataset->left_out.size(), 1u);
}

}  // namespace
}  // namespace mien::dataset::recorded_dataset_test
