#include "lab/headset/contact_sheet.h"

#include <gtest/gtest.h>

#include "mien/virtual/headset/headset_simulator.h"
#include "tests/project_path.h"

namespace mien::lab::contact_sheet_test {
namespace {

const sensor::Rig& rig() {
  static const sensor::Rig rig = sensor::read_rig(project_path("rigs/headset_diy.toml")).value();
  return rig;
}

TEST(ContactSheet, ShowsEveryViewOfEveryExpression) {
  const auto sheet = headset_contact_sheet({.wearers = 1, .side = 24}, rig(), no_progress);
  ASSERT_TRUE(sheet) << sheet.error().message();
  // Three cameras, five expressions, no headings.
  EXPECT_EQ(sheet->width, 5 * (3 * 24 + 2));
  EXPECT_EQ(sheet->height, 24 + 2);
  for (int view = 0; view < 3; ++view) {
    const std::uint8_t* middle = sheet->pixel(view * 24 + 12, 12);
    EXPECT_GT(int{middle[0]}, 24) << view;  // Lighter than the paper.
    EXPECT_EQ(middle[0], middle[2]);
  }
  // Closed eyes look otherwise than open ones.
  int changed = 0;
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 24; ++x)
      changed += std::abs(int{sheet->pixel(x, y)[0]} - int{sheet->pixel(74 + x, y)[0]}) > 20 ? 1 : 0;
  EXPECT_GT(changed, 5);
}

TEST(ContactSheet, HasARowAFailure) {
  const auto sheet = headset_contact_sheet({.wearers = 1, .side = 16, .failures = true}, rig(), no_progress);
  ASSERT_TRUE(sheet) << sheet.error().message();
  EXPECT_EQ(sheet->height, static_cast<int>(virt::kHeadsetFailures - 1) * (16 + 2));
}

TEST(ContactSheet, RefusesWhatIsNoSheet) {
  EXPECT_FALSE(headset_contact_sheet({.wearers = 0}, rig(), no_progress));
  EXPECT_FALSE(headset_contact_sheet({.side = 4}, rig(), no_progress));
  EXPECT_FALSE(headset_contact_sheet({.font = "/no/such/font"}, rig(), no_progress));
  const auto stopped = headset_contact_sheet({.wearers = 1, .side = 16}, rig(),
                                             [](double, std::string_view) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mien::lab::contact_sheet_test
