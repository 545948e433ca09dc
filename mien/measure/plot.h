#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace mien::measure {

/// Colours that series have; more of them begin anew.
inline constexpr std::size_t kSeriesColours = 9;

/// One curve. Shape: x and y of equal size, x ascending; a y that is not finite breaks the curve.
struct Line {
  std::string name;
  std::vector<double> x;
  std::vector<double> y;
  bool points = false;  ///< Each is marked.
};

/// Curves over a common axis. All names are plain text in UTF-8.
struct LinePlot {
  std::string title;
  std::string x_label;  ///< With its unit: "time (s)".
  std::string y_label;
  std::vector<Line> lines;
  std::optional<double> y_low;   ///< Unset: from the data, and from 0 where all are positive.
  std::optional<double> y_high;  ///< Unset: from the data.
  int height = 260;              ///< Of the drawing, in CSS pixels; its width is the page's.
};

/// Bars side by side: in each group one bar a series. Values >= 0; one that is not finite leaves a gap.
struct BarPlot {
  struct Group {
    std::string name;
    std::vector<double> values;  ///< One a series.
    std::vector<double> spread;  ///< Empty, or one a series: drawn as value +- spread.
  };
  std::string title;
  std::string value_label;  ///< With its unit: "PVE (mm)".
  std::vector<std::string> series;
  std::vector<Group> groups;
};

/// Round numbers that divide [low, high] into about `count` parts; at least two for a non-empty range.
[[nodiscard]] std::vector<double> axis_ticks(double low, double high, int count);

/// The drawing as inline SVG. Colours are the page's CSS variables --ink, --soft, --grid and --series-1 to
/// --series-9, so that one drawing suits light and dark. The same plot gives the same text. Line plots carry
/// their numbers too, finer than they are drawn, for the script that zooms them (zoom.js).
[[nodiscard]] std::string svg(const LinePlot& plot);
[[nodiscard]] std::string svg(const BarPlot& plot);

/// Text with the characters that mean something in HTML replaced.
[[nodiscard]] std::string escaped(const std::string& text);

}  // namespace mien::measure
