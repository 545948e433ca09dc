#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "mien/face/profile.h"

namespace mien::lab {

/// Frames that follow each other without a gap, at one rate.
using MotionRun = std::vector<face::BlendshapeWeights>;

/// Shapes that people move as one thing: face::ShapeRegion's, with lids and gaze apart.
enum class ShapeGroup : std::uint8_t { brows, lids, gaze, cheeks, mouth, jaw };
inline constexpr std::array<std::string_view, 6> kShapeGroupNames = {"brows",           "lids",  "gaze",
                                                                     "cheeks and nose", "mouth", "jaw"};
/// `shape`: below kShapeCount.
[[nodiscard]] ShapeGroup group_of(std::size_t shape);

/// How a face moves in time. Where nothing moves, or nobody blinks, the values are 0. A shape's rest is the
/// mean of the frames in the densest interval of 0.05: people do not rest at 0, and trackers of them less.
struct MotionRhythm {
  /// Share of time within 0.03 of rest, mean of all shapes but gaze.
  double rest_share = 0;
  /// The whole face: share of time in which no shape but lids' and gaze is further than 0.1 from rest.
  double still_share = 0;
  /// 99th percentile of the speed's magnitude over its root mean square, mean of the shapes that move
  /// (standard deviation above 0.01). A sine: 1.41; a Gaussian: 2.58; rare, quick moves among rests: more.
  double speed_tail = 0;
  /// Shares of the variance by how long changes take: beyond 4 s, 1 to 4 s, 0.25 to 1 s, quicker.
  /// (Differences of centred moving averages, all shapes together.)
  double slowest = 0, slow = 0, quick = 0, quickest = 0;
  /// Excursions of more than 0.15 from rest of all shapes but gaze and lids: median and 90th percentile, s.
  double expression_s = 0, long_expression_s = 0;
  double blinks_per_min = 0;
  /// Blinks: median time above half of the rise, s; median share of it in which lids still close.
  double blink_s = 0, blink_closing_share = 0;
  /// Medians: largest eyeBlink weight of a blink, mean of both lids; difference between the lids then.
  double blink_peak = 0, blink_side_difference = 0;
};

/// The value that `share` (0 to 1) of the others lie below; 0 of none.
[[nodiscard]] double percentile(std::vector<float> values, double share);

/// `rate_hz`: above 0. Runs shorter than a second count for nothing that takes longer.
[[nodiscard]] MotionRhythm motion_rhythm(std::span<const MotionRun> runs, double rate_hz);

}  // namespace mien::lab
