#include "mien/live/dataset_shelf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <future>

#include "mien/take/take.h"
#include "tests/folder.h"
#include "tests/take/example_take.h"

namespace mien::live::dataset_shelf_test {
namespace {

using ::testing::HasSubstr;

session::Prompt line(const std::string& name, const std::string& text) {
  session::Prompt prompt;
  prompt.name = name;
  prompt.text = text;
  prompt.block = "calm";
  return prompt;
}

Result<std::vector<RecordingScript>> scripts() {
  RecordingScript english{"english", {}};
  english.script.name = "English";
  english.script.prompts = {line("one", "One."), line("two", "Two."), line("three", "Three.")};
  RecordingScript german{"german", {}};
  german.script.prompts = {line("one", "Eins.")};
  return std::vector{english, german};
}

const session::Consent kAnna{"Anna", "a theatre", "to learn a face", true};

/// A finished take in which somebody recorded these lines, poor ones with a reason.
void write_take(const std::filesystem::path& path, const session::Consent& consent,
                const std::vector<std::pair<session::Prompt, bool>>& lines) {
  std::filesystem::create_directories(path.parent_path());
  auto writer = take::TakeWriter::create(path, take::test::example_header(), true);
  ASSERT_TRUE(writer) << writer.error().message();
  writer->add_event({"consent", DeviceTime(), DeviceTime(), session::consent_event_json(consent)});
  for (const auto& [prompt, good] : lines) {
    const std::vector<std::string> poor = {"chin was lost"};
    writer->add_event({"prompt", DeviceTime(), DeviceTime(),
                       session::prompt_event_json(prompt, good ? std::span<const std::string>() : poor)});
  }
  ASSERT_TRUE(writer->finish());
}

struct Stage {
  explicit Stage(const std::filesystem::path& folder) : shelf(folder, scripts) {}
  Result<DatasetShelf::Contents> list(const std::filesystem::path& growing = {}) {
    std::promise<Result<DatasetShelf::Contents>> answer;
    shelf.list(growing,
               [&](Result<DatasetShelf::Contents> contents) { answer.set_value(std::move(contents)); });
    return answer.get_future().get();
  }
  Result<DatasetPlan> plan(DatasetWish wish, const std::filesystem::path& growing = {}) {
    std::promise<Result<DatasetPlan>> answer;
    shelf.plan(std::move(wish), growing,
               [&](Result<DatasetPlan> plan) { answer.set_value(std::move(plan)); });
    return answer.get_future().get();
  }
  DatasetShelf shelf;
};

TEST(DatasetShelf, TellsWhoHasRecordedHowMuchInWhichDataset) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  write_take(folder / "faces/anna_1.mien", kAnna,
             {{line("one", "One."), true}, {line("two", "Two."), false}});
  write_take(folder / "faces/anna_2.mien", kAnna, {{line("two", "Two."), true}, {line("one", "One."), true}});
  write_take(folder / "faces/bert.mien", {"Bert", "a theatre", "to learn a face", false}, {});
  write_take(folder / "other/growing.mien", kAnna, {{line("one", "One."), true}});
  std::ofstream(folder / "faces/broken.mien") << "no take";
  std::filesystem::create_directories(folder / "films");
  Stage stage(folder.path());
  const auto contents = stage.list(folder / "other/growing.mien");
  ASSERT_TRUE(contents) << contents.error().message();
  ASSERT_EQ(contents->datasets.size(), 1u) << "the other one's take still grows";
  EXPECT_EQ(contents->datasets[0].name, "faces");
  ASSERT_EQ(contents->datasets[0].performers.size(), 2u);
  EXPECT_EQ(contents->datasets[0].performers.at("Anna").takes, 2u);
  EXPECT_EQ(contents->datasets[0].performers.at("Anna").lines, 2u);
  EXPECT_EQ(contents->datasets[0].performers.at("Bert").lines, 0u);
  EXPECT_EQ(contents->scripts.size(), 2u);
}

TEST(DatasetShelf, PlansWhatAPerformerHasNotRecordedWellYet) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  write_take(folder / "faces/anna.mien", kAnna, {{line("one", "One."), true}, {line("two", "Two."), false}});
  Stage stage(folder.path());
  const auto left = stage.plan({"faces", "english", kAnna, true});
  ASSERT_TRUE(left) << left.error().message();
  ASSERT_EQ(left->prompts.size(), 2u);
  EXPECT_EQ(left->prompts[0].name, "two");
  EXPECT_EQ(left->prompts[1].name, "three");
  EXPECT_EQ(left->done, 1u);
  EXPECT_EQ(left->take.parent_path(), folder / "faces");
  EXPECT_THAT(left->take.filename().string(), HasSubstr("Anna_"));
  EXPECT_FALSE(std::filesystem::exists(left->take));

  const auto german = stage.plan({"faces", "german", kAnna, false});
  ASSERT_TRUE(german) << german.error().message();
  EXPECT_EQ(german->prompts.size(), 1u) << "a line of the same name and another text";
  session::Consent other = kAnna;
  other.performer = "../../Bert";
  const auto bert = stage.plan({"faces", "english", other, false});
  ASSERT_TRUE(bert) << bert.error().message();
  EXPECT_EQ(bert->prompts.size(), 3u);
  EXPECT_EQ(bert->take.parent_path(), folder / "faces") << "a name is no path";

  write_take(folder / "faces/more.mien", kAnna,
             {{line("two", "Two."), true}, {line("three", "Three."), true}});
  const auto all = stage.plan({"faces", "english", kAnna, true});
  ASSERT_FALSE(all);
  EXPECT_THAT(all.error().message(), HasSubstr("has recorded all 3 lines"));
}

TEST(DatasetShelf, RefusesEachMistakeAlone) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Stage stage(folder.path());
  const auto refused = [&stage](const DatasetWish& wish) {
    const auto plan = stage.plan(wish);
    return plan ? std::string() : plan.error().message();
  };
  EXPECT_EQ(refused({"faces", "english", kAnna, false}), "");
  for (const char* name : {"", "..", "../faces", ".hidden", "a/b", "a\\b", "a\nb"})
    EXPECT_THAT(refused({name, "english", kAnna, false}), HasSubstr("not a name for a dataset")) << name;
  EXPECT_THAT(refused({"faces", "klingon", kAnna, false}), HasSubstr("no recording script"));
  session::Consent nobody = kAnna;
  nobody.performer = " ";
  EXPECT_THAT(refused({"faces", "english", nobody, false}), HasSubstr("the performer is empty"));
  session::Consent by_nobody = kAnna;
  by_nobody.recorded_by = "";
  EXPECT_THAT(refused({"faces", "english", by_nobody, false}), HasSubstr("who records is empty"));
  session::Consent for_nothing = kAnna;
  for_nothing.purpose = std::string(1001, 'a');
  EXPECT_THAT(refused({"faces", "english", for_nothing, false}), HasSubstr("the purpose is empty, or not"));
}

}  // namespace
}  // namespace mien::live::dataset_shelf_test
