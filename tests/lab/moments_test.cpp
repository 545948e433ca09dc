#include "lab/moments.h"

#include <gmock/gmock.h>

#include <limits>

#include <cmath>

#include "mien/builtin_face/builtin_face.h"

namespace mien::lab::moments_test {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

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
