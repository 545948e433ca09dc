// What `mien study hours` keeps of its runs.
#include <gmock/gmock.h>

#include <filesystem>
#include <map>

#include "tests/app/program.h"

namespace mien::app::test::study_hours_test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// A study of one person, its figures kept in a folder of this test's own.
struct StudyHoursCommand : public ::testing::Test {
  void SetUp() override { ::setenv("XDG_CACHE_HOME", (folder / "cache").c_str(), 1); }
  void TearDown() override { ::unsetenv("XDG_CACHE_HOME"); }
  [[nodiscard]] static Outcome study(const std::string& minutes, std::vector<std::string> more = {}) {
    std::vector<std::string> all = {"study", "hours",  "--script",  "reading", "--seeds",
                                    "1",     "--json", "--minutes", minutes};
    all.insert(all.end(), more.begin(), more.end());
    return run(all);
  }
  /// When each kept file was written last.
  [[nodiscard]] std::map<std::string, fs::file_time_type> kept() const {
    std::map<std::string, fs::file_time_type> out;
    for (const auto& entry : fs::directory_iterator(folder / "cache/mien/hours"))
      out[entry.path().string()] = entry.last_write_time();
    return out;
  }
  Folder folder;
};

TEST_F(StudyHoursCommand, RunsThatWerePerformedAreNotPerformedAgain) {
  const Outcome first = study("1");
  ASSERT_EQ(first.status, 0) << first.err;
  const auto figures = kept();
  ASSERT_EQ(figures.size(), 1U);
  const Outcome second = study("1");
  EXPECT_EQ(second.out, first.out) << "all digits are kept";
  EXPECT_EQ(kept(), figures);
  // Another length is another run.
  const Outcome longer = study("1.5");
  ASSERT_EQ(longer.status, 0) << longer.err;
  EXPECT_NE(longer.out, first.out);
  EXPECT_EQ(kept().size(), 2U);
}

TEST_F(StudyHoursCommand, ADamagedFileIsMadeAnew) {
  const Outcome first = study("1");
  ASSERT_EQ(first.status, 0) << first.err;
  const std::string path = kept().begin()->first;
  const std::string whole = content(path);
  write(path, whole.substr(0, whole.size() / 2));
  EXPECT_EQ(study("1").out, first.out);
  EXPECT_EQ(content(path), whole);
}

}  // namespace
}  // namespace mien::app::test::study_hours_test
