#include "mien/synthetic/imu/dataset_part.h"

#include <gtest/gtest.h>

#include "tests/synthetic/imu/toy_training_data.h"

namespace mien::synthetic::dataset_part_test {
namespace {

TEST(OneInPeople, AreOthersForEachPart) {
  const dataset::Dataset all = test::toy_dataset({"a"}, 10);
  std::size_t sum = 0;
  for (std::size_t which = 0; which < 3; ++which) {
    const dataset::Dataset part = one_in_people(all, 3, which);
    for (const dataset::Sequence& s : part.sequences) EXPECT_EQ(s.performer % 3, which);
    sum += part.sequences.size();
  }
  EXPECT_EQ(sum, all.sequences.size());
  EXPECT_TRUE(test::same(one_in_people(all, 1, 0), all));
  EXPECT_TRUE(test::same(one_in_people(all, 3, 4), one_in_people(all, 3, 1)));
}

}  // namespace
}  // namespace mien::synthetic::dataset_part_test
