#include "mien/study/imu/dataset_part.h"

#include <gtest/gtest.h>

#include <array>

#include "tests/study/imu/toy_training_data.h"

namespace mien::study::dataset_part_test {
namespace {

TEST(FewerSensors, KeepTheirOwnNumbers) {
  const Dataset all = test::toy_dataset({"a", "b", "c"}, 4);
  const auto part = with_sensors(all, std::array<std::string, 2>{"c", "a"});
  ASSERT_TRUE(part) << part.error().message();
  EXPECT_EQ(part->sensors, (std::vector<std::string>{"c", "a"}));
  for (std::size_t i = 0; i < all.sequences.size(); ++i) {
    const Sequence &whole = all.sequences[i], &few = part->sequences[i];
    ASSERT_EQ(few.frames, whole.frames);
    ASSERT_EQ(few.values.size(), few.frames * 7 * 2);
    ASSERT_EQ(few.present.size(), few.frames * 2 * 2);
    EXPECT_EQ(few.weights, whole.weights);
    for (std::size_t f = 0; f < few.frames; ++f)
      for (std::size_t s = 0; s < 2; ++s) {
        const std::size_t was = s == 0 ? 2 : 0;
        for (std::size_t v = 0; v < 7; ++v)
          EXPECT_EQ(few.values[(f * 2 + s) * 7 + v], whole.values[(f * 3 + was) * 7 + v]);
        for (const std::size_t kind : {0, 1})  // Rotations, then accelerations.
          EXPECT_EQ(few.present[f * 4 + kind * 2 + s], whole.present[f * 6 + kind * 3 + was]);
      }
    if (whole.slopes.empty()) continue;
    ASSERT_EQ(few.slopes.size(), 2 * 3 * face::kShapeCount);
    EXPECT_EQ(few.slopes[0], whole.slopes[2 * 3 * face::kShapeCount]);
  }
  EXPECT_EQ(part->standard_slopes.size(), 2 * 3 * face::kShapeCount);
}

TEST(FewerSensors, OfAnUnknownNameAreRefused) {
  const Dataset all = test::toy_dataset({"mentalis", "frontalis_L"}, 1);
  const auto part = with_sensors(all, std::array<std::string, 1>{"mentalus"});
  ASSERT_FALSE(part);
  EXPECT_EQ(part.error().code, ErrorCode::not_found);
  EXPECT_NE(part.error().what.find("did you mean mentalis?"), std::string::npos);
  EXPECT_EQ(with_sensors(all, {}).error().code, ErrorCode::bad_usage);
}

TEST(OneInPeople, AreOthersForEachPart) {
  const Dataset all = test::toy_dataset({"a"}, 10);
  std::size_t sum = 0;
  for (std::size_t which = 0; which < 3; ++which) {
    const Dataset part = one_in_people(all, 3, which);
    for (const Sequence& s : part.sequences) EXPECT_EQ(s.performer % 3, which);
    sum += part.sequences.size();
  }
  EXPECT_EQ(sum, all.sequences.size());
  EXPECT_TRUE(test::same(one_in_people(all, 1, 0), all));
  EXPECT_TRUE(test::same(one_in_people(all, 3, 4), one_in_people(all, 3, 1)));
}

}  // namespace
}  // namespace mien::study::dataset_part_test
