#include "mien/dataset/splits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mien/core/files.h"
#include "tests/folder.h"

namespace mien::dataset::splits_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> people(std::size_t count) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) names.push_back("p" + std::to_string(100 + i));
  return names;
}

std::size_t size_of(const Splits& splits, Split split) {
  return splits.of(split).size();
}

TEST(Splits, PutEverybodyIntoOneSet) {
  for (const std::size_t count : {1u, 2u, 3u, 4u, 10u, 57u}) {
    const Splits splits = draw_splits(people(count), {}, 3).value();
    std::vector<std::string> all;
    for (const auto& set : splits.people) {
      EXPECT_TRUE(std::ranges::is_sorted(set));
      all.insert(all.end(), set.begin(), set.end());
    }
    std::ranges::sort(all);
    EXPECT_EQ(all, people(count)) << count;
  }
  const Splits splits = draw_splits(people(57), {.validation = 0.1, .test = 0.2}, 3).value();
  EXPECT_EQ(size_of(splits, Split::validation), 6u);
  EXPECT_EQ(size_of(splits, Split::test), 11u);
  EXPECT_EQ(splits.where(splits.of(Split::test)[3]), Split::test);
  EXPECT_EQ(splits.where("nobody"), std::nullopt);
}

TEST(Splits, OfFewPeopleTrainFirst) {
  const auto sizes = [](std::size_t count) {
    const Splits splits = draw_splits(people(count), {}, 1).value();
    return std::vector<std::size_t>{size_of(splits, Split::train), size_of(splits, Split::validation),
                                    size_of(splits, Split::test)};
  };
  EXPECT_THAT(sizes(0), ElementsAre(0u, 0u, 0u));
  EXPECT_THAT(sizes(1), ElementsAre(1u, 0u, 0u));
  EXPECT_THAT(sizes(2), ElementsAre(1u, 1u, 0u));
  EXPECT_THAT(sizes(3), ElementsAre(1u, 1u, 1u));
  const Splits none = draw_splits(people(9), {.validation = 0, .test = 0}, 1).value();
  EXPECT_EQ(size_of(none, Split::train), 9u);
}

TEST(Splits, AreDrawnFromTheSeedAlone) {
  std::vector<std::string> turned = people(20);
  std::ranges::reverse(turned);
  EXPECT_EQ(draw_splits(people(20), {}, 5).value(), draw_splits(turned, {}, 5).value());
  EXPECT_NE(draw_splits(people(20), {}, 5).value(), draw_splits(people(20), {}, 6).value());
  for (const SplitShares& shares : {SplitShares{0.5, 0.5}, SplitShares{-0.1, 0.1}, SplitShares{NAN, 0.1}}) {
    const auto refused = draw_splits(people(5), shares, 1);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::out_of_range);
  }
}

TEST(Splits, ComeBackFromTheirFile) {
  const std::vector<std::string> names = {"Anna", "B\xC3\xA9n", "a \"b\" \\ c", "\xF0\x9F\x99\x82",
                                          "virtual:3"};
  Splits splits;
  splits.people = {{{names[0], names[2]}, {names[1]}, {names[3], names[4]}}};
  for (auto& set : splits.people) std::ranges::sort(set);
  const std::string toml = write_splits(splits, "as drawn");
  EXPECT_TRUE(std::ranges::all_of(toml, [](char c) { return static_cast<unsigned char>(c) < 0x80; }));
  const test::Folder folder;
  ASSERT_TRUE(write_file(folder / "splits.toml", toml));
  const auto read = read_splits(folder / "splits.toml", names);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(*read, splits);
  // Sets may be left out.
  const auto few = parse_splits("[split]\ntest = [\"Anna\"]\n", "few", names);
  ASSERT_TRUE(few);
  EXPECT_THAT(few->of(Split::test), ElementsAre("Anna"));
  EXPECT_THAT(few->of(Split::train), IsEmpty());
}

TEST(Splits, SayWhatIsWrongWithTheirFile) {
  const std::vector<std::string> names = {"Anna", "Ben"};
  const auto refused = [&](const std::string& toml, ErrorCode code) {
    const auto read = parse_splits(toml, "s.toml", names);
    EXPECT_FALSE(read) << toml;
    if (read) return std::string();
    EXPECT_EQ(read.error().code, code) << read.error().message();
    return read.error().message();
  };
  EXPECT_THAT(refused("[split]\ntrain = [\"Ana\"]", ErrorCode::not_found),
              ::testing::AllOf(HasSubstr("s.toml, line 2"), HasSubstr("did you mean Anna?")));
  EXPECT_THAT(refused("[split]\ntrain = [\"Anna\"]\ntest = [\"Ben\",\n\"Anna\"]", ErrorCode::mismatch),
              ::testing::AllOf(HasSubstr("line 4"), HasSubstr("train and in test")));
  EXPECT_THAT(refused("[split]\ntrain = [\"Anna\", \"Anna\"]", ErrorCode::mismatch), HasSubstr("twice"));
  EXPECT_THAT(refused("[split]\ntrain = \"Anna\"", ErrorCode::malformed), HasSubstr("no list"));
  EXPECT_THAT(refused("[split]\ntrain = [3]", ErrorCode::malformed), HasSubstr("no name"));
  EXPECT_THAT(refused("[split]\ntrian = []", ErrorCode::malformed), HasSubstr("trian"));
  EXPECT_THAT(refused("train = []", ErrorCode::malformed), HasSubstr("train"));
  EXPECT_THAT(refused("", ErrorCode::malformed), HasSubstr("[split]"));
  refused("[split", ErrorCode::malformed);
  EXPECT_EQ(read_splits("nowhere.toml", names).error().code, ErrorCode::not_found);

  Splits splits;
  splits.people[0] = {"Anna"};
  EXPECT_EQ(split_of(splits, "Anna", "s.toml").value(), Split::train);
  const auto nowhere = split_of(splits, "Ben", "s.toml");
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().code, ErrorCode::mismatch);
  EXPECT_THAT(nowhere.error().message(), HasSubstr("\"Ben\" is in none of the sets"));
}

}  // namespace
}  // namespace mien::dataset::splits_test
