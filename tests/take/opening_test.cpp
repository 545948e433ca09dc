// Files that are no take, or no longer one: each is refused with one line, none is believed, none brings us
// down.

#include <gmock/gmock.h>

#include "mien/core/random.h"
#include "mien/take/opening.h"
#include "mien/take/take.h"
#include "tests/take/example_take.h"

namespace mien::take::opening_test {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Opening : public ::testing::Test {
 protected:
  void SetUp() override { test::copy_example(path_); }
  Error open_error() {
    const auto take = Take::open(path_);
    return take ? Error{ErrorCode::internal, "it opened", "", ""} : take.error();
  }

  mien::test::Folder folder_;
  std::filesystem::path path_ = folder_ / "a.mien";
};

TEST_F(Opening, NamesWhatIsNoFile) {
  EXPECT_EQ(Take::open(folder_ / "absent.mien").error().code, ErrorCode::not_found);
  EXPECT_EQ(Take::open(folder_.path()).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(Take::open("/dev/null").error().code, ErrorCode::bad_usage);
  EXPECT_EQ(Take::open("").error().code, ErrorCode::not_found);
  EXPECT_EQ(Take::open("file:a.mien?mode=memory").error().code, ErrorCode::not_found);
}

TEST_F(Opening, NamesOtherKindsOfFiles) {
  test::write_raw(path_, "");
  EXPECT_THAT(open_error().message(), HasSubstr("the file is empty"));
  test::write_raw(path_, "time,eyeBlinkLeft\n0,0\n");
  EXPECT_THAT(open_error().message(), HasSubstr("this is not a take"));
  test::write_raw(path_, std::string(100'000, '\xA5'));
  EXPECT_THAT(open_error().message(), HasSubstr("this is not a take"));
  std::filesystem::remove(path_);
  test::run_sql(path_, "CREATE TABLE t(a)");
  const auto foreign = test::read_raw(path_);
  EXPECT_THAT(open_error().message(), HasSubstr("another program"));
  EXPECT_EQ(test::read_raw(path_), foreign);
}

TEST_F(Opening, NamesOtherVersions) {
  test::run_sql(path_, "PRAGMA user_version=3");
  EXPECT_EQ(open_error().code, ErrorCode::unsupported);
  EXPECT_THAT(open_error().message(), AllOf(HasSubstr("version 3"), HasSubstr("newer")));
}

TEST_F(Opening, RefusesWalMode) {
  test::run_sql(path_, "PRAGMA journal_mode=WAL; INSERT INTO note VALUES(99,'a','b')");
  EXPECT_THAT(open_error().message(), HasSubstr("WAL"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.mien-shm"));
}

TEST_F(Opening, RefusesAnythingThatCouldRun) {
  const auto clean = test::read_raw(path_);
  for (const char* sql : {"CREATE TABLE more(a)", "CREATE VIEW peek AS SELECT * FROM log",
                          "CREATE TRIGGER t AFTER INSERT ON log BEGIN DELETE FROM log; END",
                          "CREATE INDEX i ON log(abs(arrival_ns))", "CREATE VIRTUAL TABLE f USING fts5(a)"}) {
    test::write_raw(path_, clean);
    test::run_sql(path_, sql);
    EXPECT_EQ(open_error().code, ErrorCode::malformed) << sql;
    EXPECT_THAT(open_error().message(), HasSubstr("which no take has")) << sql;
  }
}

TEST_F(Opening, TellsOnOneLineWhatAFileCallsItsTables) {
  test::run_sql(path_, "CREATE TABLE \"a\nb\x1B[2J\"(c)");
  EXPECT_EQ(open_error().what, "it holds a table \"a b?[2J\", which no take has");
}

TEST_F(Opening, RefusesTablesThatDifferByALetter) {
  const auto clean = test::read_raw(path_);
  for (const char* sql :
       {"ALTER TABLE log RENAME COLUMN bytes TO data", "ALTER TABLE tick ADD COLUMN extra TEXT",
        "DROP TABLE sample; CREATE TABLE sample(id INTEGER PRIMARY KEY)",
        "PRAGMA writable_schema=1; UPDATE sqlite_schema SET sql=replace(sql,'log(','log (')"}) {
    test::write_raw(path_, clean);
    test::run_sql(path_, sql);
    EXPECT_THAT(open_error().message(), HasSubstr("not as takes have it")) << sql;
  }
  test::write_raw(path_, clean);
  test::run_sql(path_, "DROP TABLE event");
  EXPECT_THAT(open_error().message(), HasSubstr("a table is missing"));
  // A view under a table's name, whose reading would run what it says.
  test::write_raw(path_, clean);
  test::run_sql(path_, "DROP TABLE event; CREATE VIEW event AS SELECT 1");
  EXPECT_THAT(open_error().message(), HasSubstr("not as takes have it"));
}

TEST_F(Opening, RefusesRowsWithOneNumber) {
  // The log's second row gets the number of its first.
  auto bytes = test::read_raw(path_);
  // Row number; the record's header: its size, the types of NULL, of 3 bytes, of the number 1, of 22 bytes;
  // 2,000,000 ns.
  const auto row = bytes.find(std::string("\x02\x05\0\x03\x09\x38\x1E\x84\x80", 9));
  ASSERT_NE(row, std::string::npos);
  bytes[row] = 1;
  test::write_raw(path_, bytes);
  EXPECT_EQ(open_error().code, ErrorCode::malformed);
  EXPECT_THAT(open_error().message(), HasSubstr("Rowid 1 out of order)"));
  EXPECT_THAT(open_error().message(), Not(HasSubstr("***")));
}

TEST(JudgePages, SaysWhatIsWrongAndNotWhere) {
  EXPECT_TRUE(judge_pages("ok", "a.mien"));
  const auto said = [](const char* verdict) { return judge_pages(verdict, "a.mien").error().what; };
  EXPECT_EQ(said("*** in database main ***\nTree 5 page 3: Rowid 1 out of order\nmore"),
            "the file is damaged (Tree 5 page 3: Rowid 1 out of order)");
  EXPECT_EQ(said("row 2 missing from index"), "the file is damaged (row 2 missing from index)");
  EXPECT_EQ(said("*** in database main ***"), "the file is damaged");
}

TEST_F(Opening, SurvivesEveryTruncation) {
  const auto whole = test::read_raw(path_);
  for (std::size_t size = 0; size < whole.size(); size += size < 200 ? 1 : 509) {
    test::write_raw(path_, std::string_view(whole).substr(0, size));
    const auto take = Take::open(path_);
    ASSERT_FALSE(take) << size;
    EXPECT_THAT(take.error().message(), HasSubstr("a.mien"));
    EXPECT_THAT(take.error().message(), Not(HasSubstr("disk image")));
    EXPECT_THAT(take.error().message(), Not(HasSubstr("\n")));
  }
}

TEST_F(Opening, SurvivesFlippedBytes) {
  const auto whole = test::read_raw(path_);
  Random random(20260102);
  int opened = 0;
  for (int round = 0; round < 1000; ++round) {
    auto bytes = whole;
    const auto flips = 1 + random.below(4);
    for (std::uint64_t i = 0; i < flips; ++i)
      bytes[random.below(bytes.size())] = static_cast<char>(random.bits());
    test::write_raw(path_, bytes);
    const std::string error = test::read_everything(path_);
    opened += error.empty() ? 1 : 0;
    EXPECT_THAT(error, Not(HasSubstr("\n")));
  }
  // Some flips meet unused bytes or a value that is as good as another.
  EXPECT_GT(opened, 0);
  EXPECT_LT(opened, 1000);
}

struct Doctored {
  const char* name;
  const char* sql;
  const char* message;
};

class OpeningDoctored : public ::testing::TestWithParam<Doctored> {};

TEST_P(OpeningDoctored, SaysWhichRowIsWrong) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  test::copy_example(path);
  test::run_sql(path, GetParam().sql);
  const std::string error = test::read_everything(path);
  EXPECT_THAT(error, HasSubstr(GetParam().message));
  EXPECT_THAT(error, HasSubstr("a.mien"));
}

INSTANTIATE_TEST_SUITE_P(
    All, OpeningDoctored,
    ::testing::Values(
        Doctored{"nan_truth", "UPDATE truth SET weights=CAST(x'0000c07f'||substr(weights,5) AS BLOB)",
                 "truth 5"},
        Doctored{"infinite_tongue", "UPDATE truth SET tongue_out=9e999", "tongue_out"},
        Doctored{"short_weights", "UPDATE truth SET weights=x'00000000'", "weights are 4 bytes"},
        Doctored{"long_weights", "UPDATE truth SET weights=zeroblob(216)", "weights is 216 bytes"},
        Doctored{"face_of_two", "UPDATE truth SET has_face=2", "has_face is 2"},
        Doctored{"nan_sample", "UPDATE sample SET reading=x'0000c07f' WHERE id=3", "sample 3"},
        Doctored{"half_float", "UPDATE sample SET reading=x'0000c07f00' WHERE id=3", "not whole floats"},
        Doctored{"many_values", "UPDATE sample SET reading=zeroblob(68) WHERE id=3", "more than 64"},
        Doctored{"unknown_sensor", "UPDATE sample SET sensor=2 WHERE id=3", "sensor is 2"},
        Doctored{"negative_sensor", "UPDATE sample SET sensor=-1 WHERE id=3", "sensor is -1"},
        Doctored{"kind_of_256", "UPDATE sample SET kind=256 WHERE id=3", "kind is 256"},
        Doctored{"sequence_too_large", "UPDATE sample SET sequence=4294967296 WHERE id=3", "sequence"},
        Doctored{"sample_of_no_entry", "UPDATE sample SET entry=65 WHERE id=64", "entry is 65"},
        Doctored{"samples_out_of_order", "UPDATE sample SET entry=9 WHERE id=3", "sample 4: entry is 4"},
        Doctored{"time_too_far", "UPDATE sample SET time_ns=9223372036854775807 WHERE id=3", "time_ns"},
        Doctored{"time_too_early", "UPDATE tick SET fired_ns=-9223372036854775807-1", "fired_ns"},
        Doctored{"entry_missing", "DELETE FROM log WHERE id=2", "entry 2 is missing"},
        Doctored{"arrival_backwards", "UPDATE log SET arrival_ns=0 WHERE id=5", "log 5: arrival_ns is 0"},
        Doctored{"unknown_source", "UPDATE log SET source=2 WHERE id=5", "source is 2"},
        Doctored{"entry_too_long", "UPDATE log SET bytes=zeroblob(16777217) WHERE id=5",
                 "more than 16777216"},
        Doctored{"entry_far_too_long", "UPDATE log SET bytes=zeroblob(100000000) WHERE id=5",
                 "larger than any"},
        Doctored{"tick_after_no_entry", "UPDATE tick SET after_entry=65 WHERE frame=4", "after_entry is 65"},
        Doctored{"ticks_out_of_order", "UPDATE tick SET after_entry=60 WHERE frame=2", "tick 3: after_entry"},
        Doctored{"frames_out_of_order", "UPDATE tick SET time_ns=0 WHERE frame=3", "tick 3: time_ns"},
        Doctored{"frame_too_far", "UPDATE tick SET frame=9223372036854775807 WHERE frame=4", "frame is"},
        Doctored{"event_ends_first", "UPDATE event SET end_ns=begin_ns-1", "end_ns"},
        Doctored{"long_kind", "UPDATE event SET kind=printf('%.*c',300,'x')", "kind is 300 bytes"},
        Doctored{"not_utf8", "UPDATE event SET json=CAST(x'ff41' AS TEXT)", "json is not UTF-8"},
        Doctored{"audio_rate", "UPDATE audio SET rate_hz=0", "rate_hz is 0"},
        Doctored{"audio_nan", "UPDATE audio SET pcm=x'0000c07f'", "audio 1"},
        Doctored{"audio_gap", "INSERT INTO audio VALUES(2,8000,99000000000,x'00000000')",
                 "does not begin where"},
        Doctored{"audio_empty", "UPDATE audio SET pcm=x''", "not whole floats"},
        Doctored{"two_headers",
                 "INSERT INTO header SELECT 2,software,performer,script,devices,face,face_parameters,"
                 "prologue,seed,rig_toml,created_utc,profile FROM header",
                 "2 headers"},
        Doctored{"no_header", "DELETE FROM header", "0 headers"},
        Doctored{"other_profile", "UPDATE header SET profile='arkit52'", "of a profile"},
        Doctored{"bad_rig", "UPDATE header SET rig_toml='name='", "rig"},
        Doctored{"sources_not_from_one", "UPDATE source SET id=7", "numbered from 1"},
        Doctored{"long_source", "UPDATE source SET name=printf('%.*c',300,'x')", "name is 300 bytes"},
        Doctored{"count_differs", "DELETE FROM truth WHERE has_face", "when it was finished it held"}),
    [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace mien::take::opening_test
