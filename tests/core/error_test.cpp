#include "mien/core/error.h"

#include <gtest/gtest.h>

#include <memory>

namespace mien::error_test {
namespace {

Result<int> half(int number) {
  if (number % 2 != 0) return fail(ErrorCode::out_of_range, "the number is odd", "half", "give an even one");
  return number / 2;
}
Result<void> check(int number) {
  MIEN_TRY(half(number));
  return {};
}
Result<int> quarter(int number) {
  MIEN_TRY_ASSIGN(const int once, half(number));
  MIEN_TRY_ASSIGN(const int twice, half(once));
  return twice;
}
Result<std::unique_ptr<int>> boxed(int number) {
  return std::make_unique<int>(number);
}
Result<int> unboxed(int number) {
  MIEN_TRY_ASSIGN(const auto box, boxed(number));
  return *box;
}

TEST(Error, SaysWhereWhatAndWhatToDo) {
  EXPECT_EQ((Error{ErrorCode::io, "the disk is full", "a.mien", "free some space"}.message()),
            "a.mien: the disk is full; free some space");
  EXPECT_EQ((Error{ErrorCode::io, "the disk is full", "", ""}.message()), "the disk is full");
}

TEST(Error, TravelsUpUnchanged) {
  EXPECT_EQ(quarter(12).value(), 3);
  EXPECT_EQ(quarter(6).error(), half(3).error());
  EXPECT_TRUE(check(2).has_value());
  EXPECT_EQ(check(1).error().what, "the number is odd");
  EXPECT_EQ(unboxed(5).value(), 5);
}

TEST(Error, TellsBadInputFromFailure) {
  EXPECT_TRUE(is_bad_input(ErrorCode::bad_usage));
  EXPECT_TRUE(is_bad_input(ErrorCode::malformed));
  EXPECT_FALSE(is_bad_input(ErrorCode::io));
  EXPECT_FALSE(is_bad_input(ErrorCode::cancelled));
  EXPECT_FALSE(is_bad_input(ErrorCode::internal));
}

}  // namespace
}  // namespace mien::error_test
