#include "lab/speech/phone_labels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mien::lab::phone_labels_test {
namespace {

using testing::HasSubstr;

TEST(PhoneLabels, ReadsNestedAlignments) {
  const auto closures = parse_phone_labels(
      R"({"b":0,"d":1,"t":"map","w":[{"b":0,"d":1,"t":"map","w":[{"b":0.1,"d":0.05,"t":"M"},)"
      R"({"b":0.15,"d":0.2,"t":"AE"},{"b":0.35,"d":0.08,"t":"P"}]}]})",
      "x");
  ASSERT_TRUE(closures) << closures.error().message();
  ASSERT_EQ(closures->size(), 2U);
  EXPECT_NEAR((*closures)[1].begin_s, 0.35, 1e-12);
  EXPECT_NEAR((*closures)[1].end_s, 0.43, 1e-12);
}

TEST(PhoneLabels, ReadsHtksLabelsPlainAndInContext) {
  const auto closures = parse_phone_labels(
      "0 1000000 sil\n1000000 1500000 m\r\n\n1500000 2000000 sil^m-p+ae=t@1_2/A:0-0+0\n2000000 3000000 "
      "a^p-ae+b=x@1\n",
      "x");
  ASSERT_TRUE(closures) << closures.error().message();
  ASSERT_EQ(closures->size(), 2U);
  EXPECT_NEAR((*closures)[0].begin_s, 0.1, 1e-12);
  EXPECT_NEAR((*closures)[1].end_s, 0.2, 1e-12);
}

TEST(PhoneLabels, SaysWhatIsWrong) {
  const auto complaint = [](std::string_view text) {
    const auto labels = parse_phone_labels(text, "talk.lab");
    return labels ? std::string() : labels.error().message();
  };
  EXPECT_THAT(complaint("0 10 m\n20 x p\n"), HasSubstr("talk.lab, line 2"));
  EXPECT_THAT(complaint("0 10\n"), HasSubstr("begin, end, label"));
  EXPECT_THAT(complaint("10 5 m\n"), HasSubstr("from"));
  EXPECT_THAT(complaint("0 99999999999999 m\n"), HasSubstr("from"));
  EXPECT_THAT(complaint("{"), HasSubstr("no JSON"));
  EXPECT_THAT(complaint(R"({"w":[3]})"), HasSubstr("no alignment"));
  EXPECT_THAT(complaint(R"({"b":0,"t":"M"})"), HasSubstr("lacks"));
  EXPECT_TRUE(parse_phone_labels("", "x"));
}

}  // namespace
}  // namespace mien::lab::phone_labels_test
