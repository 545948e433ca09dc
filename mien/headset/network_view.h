#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "mien/core/error.h"
#include "mien/headset/grey_picture.h"

namespace mien::headset {

/// What of a camera's picture a network sees, and how it is turned.
struct NetworkViewSettings {
  int side =
      96;  ///< Pixels of the view, 1 to 512. Raising shows the network more, at the square of the cost.
  /// The part that is seen, in shares of the picture, 0 at its left and upper edge and 1 at the other; left
  /// below right, top below bottom. It is stretched to a square.
  double left = 0;
  double top = 0;
  double right = 1;
  double bottom = 1;
  int quarter_turns = 0;  ///< Clockwise, of what was cut out, 0 to 3.
  bool mirror = false;    ///< Left and right changed, of what was turned.
  bool operator==(const NetworkViewSettings&) const = default;
};

/// Width and height of the smallest picture of which a view is made, nine tenths of a pixel for each of its
/// own.
[[nodiscard]] std::pair<int, int> least_size(const NetworkViewSettings& settings);

/// Makes the square view of a network out of pictures: cut out, turned, mirrored, each pixel the mean of what
/// it covers (by area, so also of parts of pixels), and stretched so that the levels that 2 % and 98 % of the
/// view's pixels do not exceed are 0 and 1; what is beyond is 0 or 1. A view with hardly any contrast, as of
/// a lens that is covered, is 0.5 all over rather than noise. The same bits always. No allocation in make().
/// Thread: one at a time.
class NetworkView {
 public:
  /// The least difference of the two levels, of 0 to 1: four steps of 8 bits, about what the noise of a dark
  /// picture and its JPEG have.
  static constexpr float kLeastContrast = 4.0F / 255;

  /// Errors: out_of_range.
  [[nodiscard]] static Result<NetworkView> create(const NetworkViewSettings& settings);

  /// Of a picture of 1 x 1 to kMaxPictureWidth x kMaxPictureHeight. `view`: side x side numbers, 0 to 1, row
  /// by row from the top.
  void make(const GreyPicture& picture, std::span<float> view);
  /// The same in steps of 1/255, rounded.
  void make(const GreyPicture& picture, std::span<std::uint8_t> view);

  [[nodiscard]] const NetworkViewSettings& settings() const { return settings_; }

 private:
  /// What of a row or column of pixels one of the view covers: the first pixel, how many, and the share of
  /// the mean that each has.
  struct Cover {
    int first = 0;
    int count = 0;
    float first_share = 0;
    float middle_share = 0;
    float last_share = 0;
  };
  static void cover(int pixels, double from, double to, std::span<Cover> covers);

  explicit NetworkView(const NetworkViewSettings& settings);
  /// Into view_: the means alone, and stretched.
  void average(const GreyPicture& picture);
  void see(const GreyPicture& picture);

  NetworkViewSettings settings_;
  int width_ = 0;  // Of the pictures that the covers are for.
  int height_ = 0;
  std::vector<Cover> columns_, rows_;
  std::vector<float> row_;  // One of the view's, as wide as the picture.
  std::vector<float> view_;
  std::vector<std::uint8_t> steps_;  // Its levels, for the histogram.
};

}  // namespace mien::headset
