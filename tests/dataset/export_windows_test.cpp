#include "mien/dataset/export_windows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "mien/core/files.h"
#include "mien/dataset/export_folder.h"
#include "mien/model/safetensors.h"
#include "tests/dataset/written_take.h"

namespace mien::dataset::export_windows_test {
namespace {

using test::Folder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class ExportedWindows : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new Folder;
    const virt::VirtualSession session = test::talking_session(8);
    const double judged_s =
        to_seconds(std::ranges::find_if(session.truth, &take::TruthFrame::evaluated)->time -
                   session.ticks.front().frame);
    const auto line = [&](double from_s, double to_s, const std::string& json) {
      return test::line_event(session, judged_s + from_s, judged_s + to_s, json);
    };
    test::write_take(
        *folder_ / "a.mien", session,
        {.performer = "",
         .consents = "Anna | *one*",
         .events = {line(0.5, 1, R"({"name": "one", "block": "calm", "emotion": "joy", "language": "en"})"),
                    line(3, 4, R"({"name": "two", "block": "calm", "poor": ["nothing moved"]})")}});
    test::write_take(*folder_ / "b.mien", session, {.performer = "", .consents = "Ben"});
    ASSERT_TRUE(write_file(*folder_ / "foreign.mien", "<script>"));
    ASSERT_TRUE(write_file(*folder_ / "splits.toml",
                           "[split]\ntrain = [\"Anna | *one*\"]\nvalidation = [\"Ben\"]\n"));
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static ExportRequest request(const std::filesystem::path& out) {
    ExportRequest asked;
    asked.folder = folder_->path();
    asked.splits = *folder_ / "splits.toml";
    asked.out = out;
    asked.software = "mien test";
    asked.command = "mien dataset export";
    return asked;
  }
  static Folder* folder_;
};
Folder* ExportedWindows::folder_ = nullptr;

std::vector<std::string> names_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& file : std::filesystem::directory_iterator(folder))
    names.push_back(file.path().filename().string());
  std::ranges::sort(names);
  return names;
}

const model::Tensor& tensor(const model::TensorFile& file, const std::string& name) {
  return *std::ranges::find(file.tensors, name, &model::Tensor::name);
}

TEST_F(ExportedWindows, AreTheTakesFramesOneByOne) {
  const Folder out;
  const auto exported = export_windows(request(out / "windows"), no_progress);
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_THAT(names_in(out / "windows"),
              ElementsAre("datasheet.md", "train.safetensors", "validation.safetensors"));
  const RecordedTake take = read_recorded_take(take::Take::open(*folder_ / "a.mien").value()).value();
  ASSERT_EQ(take.stretches.size(), 2u);
  const auto file = model::read_safetensors(out / "windows/train.safetensors");
  ASSERT_TRUE(file) << file.error().message();
  const std::size_t windows = exported->sets[0].windows;
  ASSERT_GE(windows, 3u);
  EXPECT_THAT(tensor(*file, "condition").shape, ElementsAre(windows, 120u, 18u));
  EXPECT_THAT(tensor(*file, "weights").shape, ElementsAre(windows, 120u, face::kShapeCount));
  EXPECT_THAT(tensor(*file, "line").shape, ElementsAre(windows, 120u));
  std::size_t window = 0;
  bool lined = false;
  double covered = 0;
  for (const CountedStretch& stretch : take.stretches) {
    std::size_t reached = 0;
    for (std::size_t first = 0; first + 120 <= stretch.sequence.frames; first += 60, ++window) {
      ASSERT_LT(window, windows);
      for (std::size_t f = 0; f < 120; ++f) {
        const float* condition = tensor(*file, "condition").values.data() + (window * 120 + f) * 18;
        for (std::size_t i = 0; i < 14; ++i)
          ASSERT_EQ(condition[i], stretch.sequence.values[(first + f) * 14 + i]);
        for (std::size_t i = 0; i < 4; ++i)
          ASSERT_EQ(condition[14 + i], stretch.sequence.present[(first + f) * 4 + i]);
        const float* weights =
            tensor(*file, "weights").values.data() + (window * 120 + f) * face::kShapeCount;
        for (std::size_t k = 0; k < face::kShapeCount; ++k)
          ASSERT_EQ(weights[k], stretch.sequence.weights[(first + f) * face::kShapeCount + k]);
        const float line = tensor(*file, "line").values[window * 120 + f];
        ASSERT_EQ(line, static_cast<float>(stretch.line[first + f]));
        lined = lined || line == 0;
      }
      EXPECT_EQ(tensor(*file, "take").values[window], 0);
      EXPECT_NEAR(tensor(*file, "begin_s").values[window],
                  to_seconds(stretch.begin - take.first_frame) + static_cast<double>(first) / 60, 1e-3);
      reached = first + 120;
    }
    covered += static_cast<double>(reached) / 60;
  }
  EXPECT_EQ(window, windows);
  EXPECT_TRUE(lined);
  EXPECT_NEAR(exported->sets[0].seconds, covered, 1e-9);
  using nlohmann::json;
  EXPECT_EQ(file->metadata.at("format"), "mien windows 1");
  EXPECT_EQ(file->metadata.at("split"), "train");
  EXPECT_EQ(json::parse(file->metadata.at("sensors")), json({"mentalis", "buccinator_L"}));
  EXPECT_EQ(json::parse(file->metadata.at("shapes")).size(), face::kShapeCount);
  EXPECT_EQ(json::parse(file->metadata.at("takes")),
            json::array({{{"file", "a.mien"}, {"person", "Anna | *one*"}}}));
  EXPECT_EQ(json::parse(file->metadata.at("lines"))[0]["emotion"], "joy");
  EXPECT_EQ(exported->sets[2].windows, 0u);
  // The same again is the same.
  ExportRequest again = request(out / "again");
  ASSERT_TRUE(export_windows(again, no_progress));
  for (const std::string& name : names_in(out / "windows"))
    EXPECT_EQ(read_text(out / "windows" / name).value(), read_text(out / "again" / name).value()) << name;
}

TEST_F(ExportedWindows, ComeWithADatasheet) {
  const Folder out;
  ASSERT_TRUE(export_windows(request(out / "w"), no_progress));
  const std::string sheet = read_text(out / "w/datasheet.md").value();
  EXPECT_THAT(sheet, HasSubstr("2 people, 2 takes"));
  // What people wrote is no sign in a table.
  EXPECT_THAT(sheet, HasSubstr("| Anna \\| \\*one\\* | train | 1 |"));
  EXPECT_THAT(sheet, HasSubstr("| a theatre | to \\*train\\* \\| models | yes |"));
  EXPECT_THAT(sheet, HasSubstr("| foreign.mien | this is not a take |"));
  EXPECT_THAT(sheet, HasSubstr("| emotion | joy | 1 |"));
  EXPECT_THAT(sheet, HasSubstr("| in lines that were poor | 0.0 |"));
  EXPECT_THAT(sheet, HasSubstr("mentalis, buccinator\\_L"));
  EXPECT_THAT(sheet, Not(HasSubstr("A phone's truth")));
}

TEST_F(ExportedWindows, AreDividedIntoFilesThatFit) {
  const Folder out;
  ExportRequest asked = request(out / "w");
  asked.most_bytes = 100'000;  // A window is 120 x 72 numbers of four bytes.
  asked.stride = 30;
  const auto exported = export_windows(asked, no_progress);
  ASSERT_TRUE(exported) << exported.error().message();
  const ExportedSplit& train = exported->sets[0];
  ASSERT_GE(train.files.size(), 2u);
  EXPECT_EQ(train.files[0], "train.safetensors");
  EXPECT_EQ(train.files[1], "train-2.safetensors");
  std::size_t windows = 0;
  for (const std::string& name : train.files) {
    const model::TensorFile file = model::read_safetensors(out / "w" / name).value();
    windows += tensor(file, "take").values.size();
    EXPECT_EQ(nlohmann::json::parse(file.metadata.at("takes")).size(), 1u);
    for (const float line : tensor(file, "line").values)
      EXPECT_LT(line, static_cast<float>(nlohmann::json::parse(file.metadata.at("lines")).size()));
  }
  EXPECT_EQ(windows, train.windows);
  // Replaced by one that fits: nothing of the larger one is left, and what is not an export's stays.
  ASSERT_TRUE(write_file(out / "w/notes.txt", "mine"));
  asked.most_bytes = std::size_t{1} << 30U;
  const auto refused = export_windows(asked, no_progress);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::bad_usage);
  EXPECT_THAT(refused.error().message(), HasSubstr("--force"));
  asked.force = true;
  ASSERT_TRUE(export_windows(asked, no_progress));
  EXPECT_THAT(names_in(out / "w"),
              ElementsAre("datasheet.md", "notes.txt", "train.safetensors", "validation.safetensors"));
}

TEST_F(ExportedWindows, LeaveNothingBehindWhenTheyFail) {
  const Folder out;
  const auto refused = [&](const ExportRequest& asked, ErrorCode code) {
    const auto exported = export_windows(asked, no_progress);
    ASSERT_FALSE(exported);
    EXPECT_EQ(exported.error().code, code) << exported.error().message();
    EXPECT_TRUE(names_in(out.path()).empty());
  };
  ExportRequest asked = request(out / "w");
  asked.window = 1024;
  refused(asked, ErrorCode::not_found);
  asked.window = 1;
  refused(asked, ErrorCode::out_of_range);
  asked.window = 1025;
  refused(asked, ErrorCode::out_of_range);
  asked = request(out / "w");
  asked.stride = 0;
  refused(asked, ErrorCode::out_of_range);
  refused(request(out / "nowhere/w"), ErrorCode::not_found);
  asked = request(out / "w");
  asked.splits = *folder_ / "none.toml";
  refused(asked, ErrorCode::not_found);
  // Somebody is in no set: found when their take comes.
  const Folder other;
  ASSERT_TRUE(write_file(other / "s.toml", "[split]\ntrain = [\"Anna | *one*\"]\n"));
  asked.splits = other / "s.toml";
  refused(asked, ErrorCode::mismatch);
  // Stopped in the middle of it.
  int calls = 0;
  const auto stop = [&](double, std::string_view what) { return what != "reading takes" || ++calls < 2; };
  const auto stopped = export_windows(request(out / "w"), stop);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
  EXPECT_TRUE(names_in(out.path()).empty());
  // An older one stands.
  ASSERT_TRUE(export_windows(request(out / "w"), no_progress));
  const std::string before = read_text(out / "w/train.safetensors").value();
  asked = request(out / "w");
  asked.force = true;
  asked.window = 1024;
  ASSERT_FALSE(export_windows(asked, no_progress));
  EXPECT_EQ(read_text(out / "w/train.safetensors").value(), before);
  EXPECT_THAT(names_in(out / "w"),
              ElementsAre("datasheet.md", "train.safetensors", "validation.safetensors"));
  ASSERT_TRUE(write_file(out / "file", "x"));
  EXPECT_EQ(export_windows(request(out / "file"), no_progress).error().code, ErrorCode::bad_usage);
}

TEST(ExportFolder, KnowsItsOwnFiles) {
  for (const char* name :
       {"datasheet.md", "train.safetensors", "validation-12.safetensors", "test.safetensors"})
    EXPECT_TRUE(is_exports_name(name)) << name;
  for (const char* name : {"train.safetensors.bak", "train-.safetensors", "train-x.safetensors",
                           "model.safetensors", "trains.safetensors", ".safetensors", "datasheet"})
    EXPECT_FALSE(is_exports_name(name)) << name;
}

}  // namespace
}  // namespace mien::dataset::export_windows_test
