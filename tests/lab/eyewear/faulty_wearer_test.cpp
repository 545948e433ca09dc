#include "lab/eyewear/faulty_wearer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/lab/eyewear/untrained.h"

namespace mien::lab::faulty_wearer_test {
namespace {

const eyewear::MarkedFace& marked() {
  static const eyewear::MarkedFace face =
      eyewear::MarkedFace::create("all", eyewear::mark_builtin(test::all_markers()).value()).value();
  return face;
}

TEST(FaultyWearers, EveryFaultBefallsTheSamePerformance) {
  const auto group =
      faulty_wearers(test::untrained(), marked(), test::eyewear_rig(), "people", 1, 4, false, 7);
  ASSERT_TRUE(group) << group.error().message();
  EXPECT_EQ(std::set<std::string>(group->faults.begin(), group->faults.end()).size(), group->faults.size());
  EXPECT_EQ(group->faults.front(), "clean");
  std::vector<synthetic::Watched> seen;
  const auto done = group->people.front()->watch_each(
      [&](std::size_t, const synthetic::Watched& watched) { seen.push_back(watched); });
  ASSERT_TRUE(done) << done.error().message();
  ASSERT_EQ(seen.size(), group->faults.size());
  for (std::size_t f = 0; f < seen.size(); ++f) {
    EXPECT_EQ(seen[f].truth, seen[0].truth) << group->faults[f];
    EXPECT_EQ(seen[f].answer.size(), seen[f].truth.size());
    if (f > 0) {
      EXPECT_FALSE(seen[f].answer == seen[0].answer) << "nothing befell: " << group->faults[f];
    }
  }
  const auto silent = std::ranges::find(group->faults, "silent for 2 s") - group->faults.begin();
  const auto& coverage = seen[static_cast<std::size_t>(silent)].coverage;
  EXPECT_NEAR(static_cast<double>(std::ranges::count(coverage, tracker::Coverage{})), 114, 10)
      << "two seconds, less the tenth in which the last light stands";
}

}  // namespace
}  // namespace mien::lab::faulty_wearer_test
