#include "lab/moments.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "mien/builtin_face/builtin_face.h"

namespace mien::lab::moments_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// Two humps, the higher one at 70, the lower one at 30.
std::vector<float> humps() {
  std::vector<float> error(100, 0.1F);
  const auto add = [&](int at, float height) {
    for (int i = -8; i <= 8; ++i)
      error[static_cast<std::size_t>(at + i)] +=
          height * std::cos(static_cast<float>(i) * std::numbers::pi_v<float> / 18);
  };
  add(30, 1);
  add(70, 2);
  return error;
}

TEST(WorstMoments, AreTheHighestFirst) {
  EXPECT_THAT(worst_moments(humps(), 2, 20), ElementsAre(70, 30));
  EXPECT_THAT(worst_moments(humps(), 1, 20), ElementsAre(70));
  EXPECT_THAT(worst_moments(humps(), 0, 20), IsEmpty());
}

TEST(WorstMoments, StandApart) {
  const auto close = worst_moments(humps(), 3, 3);
  EXPECT_THAT(close, ElementsAre(70, 67, 73));
  const auto apart = worst_moments(humps(), 50, 25);
  ASSERT_GE(apart.size(), 3U);
  for (std::size_t i = 0; i < apart.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_GE(std::abs(static_cast<int>(apart[i]) - static_cast<int>(apart[j])), 25);
  // Nothing to keep apart: each frame once.
  EXPECT_EQ(worst_moments(humps(), 1'000, 0).size(), 100U);
}

TEST(WorstMoments, AreNoLoneFrames) {
  std::vector<float> error = humps();
  error[10] = 1'000;
  EXPECT_THAT(worst_moments(error, 2, 20), ElementsAre(70, 30));
  error[10] = std::numeric_limits<float>::infinity();
  EXPECT_THAT(worst_moments(error, 2, 20), ElementsAre(70, 30));
}

TEST(WorstMoments, AreWhereThereIsAFace) {
  std::vector<float> error = humps();
  for (std::size_t i = 60; i < 81; ++i) error[i] = kNone;
  EXPECT_THAT(worst_moments(error, 1, 20), ElementsAre(30));
  // A frame or two between gaps tell nothing.
  error[70] = error[71] = 50;
  EXPECT_THAT(worst_moments(error, 1, 20), ElementsAre(30));
  error[72] = 50;
  EXPECT_THAT(worst_moments(error, 2, 20), ElementsAre(70, 30)) << "of equals the earlier";
  EXPECT_THAT(worst_moments(std::vector<float>(9, kNone), 3, 1), IsEmpty());
  EXPECT_THAT(worst_moments({}, 3, 1), IsEmpty());
  EXPECT_THAT(worst_moments(std::vector<float>{1, 1}, 3, 1), IsEmpty());
}

class MomentsStrip : public ::testing::Test {
 protected:
  static constexpr int kCell = 64;

  static const face::Face& face() {
    static const face::Face face = builtin_face::make_builtin();
    return face;
  }
  /// Where cells begin: the last ones end at the right and lower edge, each with a gap of two pixels.
  static int left(const render::Image& picture, int columns, int column) {
    return picture.width - (columns - column) * (kCell + 2);
  }
  static int top(const render::Image& picture, int rows, int row) {
    return picture.height - (rows - row) * (kCell + 2);
  }
  /// Pixels of the two cells that differ clearly.
  static int different(const render::Image& picture, int x, int y, int other_x, int other_y) {
    int n = 0;
    for (int v = 0; v < kCell; ++v)
      for (int u = 0; u < kCell; ++u)
        n += std::abs(int{picture.pixel(x + u, y + v)[1]} - int{picture.pixel(other_x + u, other_y + v)[1]}) >
             12;
    return n;
  }
};

TEST_F(MomentsStrip, ShowsEachRowAtEachMoment) {
  face::BlendshapeWeights open;
  open[face::shape("jawOpen")] = 1;
  const face::BlendshapeWeights rest;
  const std::vector<MomentRow> rows = {
      {"truth", {open, rest}}, {"ours", {open, open}}, {"theirs", {std::nullopt, rest}}};
  const std::vector<std::string> captions = {"12.3 s", "a caption that is far too long for so small a cell"};
  const auto picture = moments_strip(face(), rows, captions, kCell);
  ASSERT_TRUE(picture) << picture.error().message();
  ASSERT_GT(picture->width, 2 * (kCell + 2));
  ASSERT_GT(picture->height, 3 * (kCell + 2));
  const int x0 = left(*picture, 2, 0), x1 = left(*picture, 2, 1);
  const int truth = top(*picture, 3, 0), ours = top(*picture, 3, 1), theirs = top(*picture, 3, 2);
  EXPECT_EQ(different(*picture, x0, truth, x0, ours), 0) << "the same weights, the same picture";
  EXPECT_EQ(different(*picture, x1, truth, x1, theirs), 0);
  EXPECT_GT(different(*picture, x1, truth, x1, ours), 20) << "a mouth that is open only in one";
  EXPECT_GT(different(*picture, x0, ours, x0, theirs), 500) << "no face";
  // The empty cell is pale all over but for its words.
  const std::uint8_t* corner = picture->pixel(x0 + 3, theirs + 3);
  EXPECT_GT(int{corner[0]}, 200);
  int dark = 0;
  for (int v = 0; v < kCell; ++v)
    for (int u = 0; u < kCell; ++u) dark += int{picture->pixel(x0 + u, theirs + v)[0]} < 180;
  EXPECT_GT(dark, 5);
  EXPECT_LT(dark, 400);
  // Captions stay in their columns, and the same asked twice is the same.
  for (int y = 0; y < truth; ++y) EXPECT_EQ(int{picture->pixel(x1 - 1, y)[0]}, 244) << y;
  EXPECT_EQ(*moments_strip(face(), rows, captions, kCell), *picture);
}

TEST_F(MomentsStrip, WeightsThatAreNoNumbersAreNoFace) {
  face::BlendshapeWeights wrong;
  wrong[3] = kNone;
  const std::vector<std::string> captions = {"now"};
  const auto none = moments_strip(face(), {{{"a", {std::nullopt}}}}, captions, kCell);
  EXPECT_EQ(*moments_strip(face(), {{{"a", {wrong}}}}, captions, kCell), *none);
}

TEST_F(MomentsStrip, RefusesWhatIsNoStrip) {
  const std::vector<std::string> captions = {"now"};
  const std::vector<MomentRow> one = {{"truth", {std::nullopt}}};
  const auto refused = [&](std::span<const MomentRow> rows, std::span<const std::string> words, int cell_px) {
    const auto picture = moments_strip(face(), rows, words, cell_px);
    return !picture && picture.error().code == ErrorCode::bad_usage;
  };
  EXPECT_TRUE(refused({}, captions, kCell));
  EXPECT_TRUE(refused({{{"truth", {}}}}, {}, kCell));
  EXPECT_TRUE(refused({{{"truth", {}}}}, captions, kCell)) << "a row of fewer moments";
  EXPECT_TRUE(refused(one, captions, 63));
  EXPECT_TRUE(refused(one, captions, 641));
  const std::vector<std::string> many(300, "now");
  EXPECT_TRUE(refused({{{"truth", std::vector<std::optional<face::BlendshapeWeights>>(300)}}}, many, kCell));
}

}  // namespace
}  // namespace mien::lab::moments_test
