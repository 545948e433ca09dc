#include "mien/measure/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace mien::measure {
namespace {

constexpr double kWidth = 760, kLeft = 66, kRight = 14, kTop = 10, kBottom = 42;

/// Steps of the numbers that a drawing carries for zoom.js, over the whole of each axis.
constexpr double kStepsOfX = 1e6, kStepsOfY = 5e4;
/// Points that it carries: of one line, and of all lines together.
constexpr std::size_t kPointsOfLine = 6000, kPointsOfPlot = 24'000;

std::size_t colour_of(std::size_t series) {
  return series % kSeriesColours + 1;
}

/// As short as it can be at this spacing: "0.25", "12", "1e-05".
std::string tick_text(double value, double step) {
  if (std::abs(value) < 1e-9 * step) return "0";
  if (std::abs(value) >= 1e6 || step < 1e-4) return fmt::format("{:.3g}", value);
  const int digits = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  return fmt::format("{:.{}f}", value, digits);
}

struct Scale {
  double low = 0, high = 1, from = 0, to = 1;
  [[nodiscard]] double operator()(double value) const {
    return from + (value - low) / (high - low) * (to - from);
  }
};

double step_of(const std::vector<double>& ticks) {
  return ticks.size() > 1 ? ticks[1] - ticks[0] : 1;
}

/// `more`: further attributes, each with a space before it.
void open_svg(std::string& out, double height, const std::string& title, const std::string& more = "") {
  fmt::format_to(
      std::back_inserter(out),
      "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\" xmlns=\"http://www.w3.org/2000/svg\"{}>\n",
      kWidth, height, escaped(title), more);
}

void text_at(std::string& out, double x, double y, const char* anchor, const std::string& words,
             const char* more = "") {
  fmt::format_to(std::back_inserter(out), "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n",
                 x, y, anchor, more, escaped(words));
}

void value_axis(std::string& out, const std::vector<double>& ticks, const Scale& y, double right) {
  for (const double t : ticks) {
    fmt::format_to(std::back_inserter(out),
                   "<line class=\"grid\" x1=\"{}\" x2=\"{}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/>\n", kLeft, right,
                   y(t), y(t));
    text_at(out, kLeft - 8, y(t) + 4, "end", tick_text(t, step_of(ticks)));
  }
}

void value_label(std::string& out, const Scale& y, const std::string& label) {
  const double middle = 0.5 * (y.from + y.to);
  text_at(out, 13, middle, "middle", label,
          fmt::format(" transform=\"rotate(-90 13 {:.1f})\"", middle).c_str());
}

struct PlotPoint {
  double x, y;
};
using PlotRun = std::vector<PlotPoint>;

/// The stretches of a line that have numbers, each point where `place(x, y)` puts it.
template <class Place>
std::vector<PlotRun> runs_of(const Line& line, const Place& place) {
  std::vector<PlotRun> runs(1);
  for (std::size_t i = 0; i < std::min(line.x.size(), line.y.size()); ++i) {
    if (std::isfinite(line.y[i]) && std::isfinite(line.x[i]))
      runs.back().push_back(place(line.x[i], line.y[i]));
    else if (!runs.back().empty())
      runs.emplace_back();
  }
  if (runs.back().empty()) runs.pop_back();
  return runs;
}

/// The lowest and the highest point of each column of this width stand for it, so that no spike is lost.
PlotRun thinned(const PlotRun& run, double column) {
  PlotRun shown;
  for (std::size_t i = 0; i < run.size();) {
    std::size_t end = i, low = i, high = i;
    while (end < run.size() && std::floor(run[end].x / column) == std::floor(run[i].x / column)) {
      if (run[end].y < run[low].y) low = end;
      if (run[end].y > run[high].y) high = end;
      ++end;
    }
    shown.push_back(run[std::min(low, high)]);
    if (low != high) shown.push_back(run[std::max(low, high)]);
    i = end;
  }
  return shown;
}

/// A path through the points, thinned where there are far more of them than pixels.
std::string path_of(const Line& line, const Scale& x, const Scale& y) {
  std::string d;
  for (const PlotRun& run : runs_of(line, [&](double at, double value) {
         return PlotPoint{x(at), std::clamp(y(value), y.to - 2, y.from + 2)};
       })) {
    const PlotRun shown = run.size() < 1500 ? run : thinned(run, 1);
    for (std::size_t i = 0; i < shown.size(); ++i)
      fmt::format_to(std::back_inserter(d), "{}{:.1f} {:.1f}", i == 0 ? 'M' : 'L', shown[i].x, shown[i].y);
    if (shown.size() == 1) d += "h0.1";
  }
  return d;
}

/// The line for zoom.js: "x y x y ...;x y ...", a run after the other. Of each run the first point
/// counts steps from the axes' lower ends, the others steps from the point before them.
std::string numbers_of(const Line& line, Scale x, Scale y, std::size_t points) {
  x.from = y.from = 0;
  x.to = kStepsOfX;
  y.to = kStepsOfY;
  const auto steps = [](double value) {  // An axis may have been told to end far below the data.
    return std::isfinite(value) ? std::round(std::clamp(value, -1e9, 1e9)) : 0.0;
  };
  const std::vector<PlotRun> runs = runs_of(line, [&](double at, double value) {
    return PlotPoint{steps(x(at)), steps(y(value))};
  });
  std::size_t all = 0;
  for (const PlotRun& run : runs) all += run.size();
  std::string words;
  for (const PlotRun& run : runs) {
    PlotPoint last{0, 0};
    char before = words.empty() ? '\0' : ';';
    for (const PlotPoint& p :
         all > points ? thinned(run, 2 * kStepsOfX / static_cast<double>(points)) : PlotRun(run)) {
      if (before != '\0') words += before;
      fmt::format_to(std::back_inserter(words), "{} {}", std::llround(p.x - last.x),
                     std::llround(p.y - last.y));
      last = p;
      before = ' ';
    }
  }
  return words;
}

}  // namespace

std::string escaped(const std::string& text) {
  constexpr std::pair<char, const char*> kSigns[] = {
      {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}};
  std::string out;
  for (const char c : text) {
    const auto* const sign = std::ranges::find(kSigns, c, &std::pair<char, const char*>::first);
    if (sign != std::end(kSigns))
      out += sign->second;
    else
      out += c;
  }
  return out;
}

std::vector<double> axis_ticks(double low, double high, int count) {
  if (!std::isfinite(low) || !std::isfinite(high) || !(high > low)) return {low};
  const double rough = (high - low) / std::max(1, count);
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double part = rough / power;
  const double step = power * (part < 1.5 ? 1 : part < 3.5 ? 2 : part < 7.5 ? 5 : 10);
  std::vector<double> ticks;
  // Multiples of the step, each computed afresh, so that no rounding piles up.
  for (double i = std::ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i)
    ticks.push_back(i * step);
  if (ticks.size() < 2) return {low, high};
  return ticks;
}

std::string svg(const LinePlot& plot) {
  const double height = std::max(120, plot.height);
  double x_low = std::numeric_limits<double>::infinity(), x_high = -x_low, y_low = x_low, y_high = -x_low;
  for (const Line& line : plot.lines)
    for (std::size_t i = 0; i < std::min(line.x.size(), line.y.size()); ++i) {
      if (!std::isfinite(line.y[i]) || !std::isfinite(line.x[i])) continue;
      x_low = std::min(x_low, line.x[i]);
      x_high = std::max(x_high, line.x[i]);
      y_low = std::min(y_low, line.y[i]);
      y_high = std::max(y_high, line.y[i]);
    }
  if (!(x_high >= x_low)) x_low = y_low = 0, x_high = y_high = 1;
  if (x_high == x_low) x_high = x_low + 1;
  if (y_low > 0) y_low = 0;
  y_low = plot.y_low.value_or(y_low);
  y_high = plot.y_high.value_or(y_high);
  if (!(y_high > y_low)) y_high = y_low + 1;
  auto y_ticks = axis_ticks(y_low, y_high, 5);
  // The axis ends at a round number above the data unless it was told where.
  if (!plot.y_high && y_ticks.back() < y_high) {
    y_ticks.push_back(y_ticks.back() + step_of(y_ticks));
    y_high = y_ticks.back();
  }
  if (!plot.y_low && y_low < 0 && y_ticks.front() > y_low) {
    y_ticks.insert(y_ticks.begin(), y_ticks.front() - step_of(y_ticks));
    y_low = y_ticks.front();
  }

  const Scale x{x_low, x_high, kLeft, kWidth - kRight}, y{y_low, y_high, height - kBottom, kTop};
  std::string out;
  open_svg(out, height, plot.title,
           fmt::format(" data-x=\"{} {}\" data-y=\"{} {}\" data-told=\"{:d} {:d}\" data-frame=\"{} {} {} "
                       "{}\" data-steps=\"{} {}\"",
                       x_low, x_high, y_low, y_high, plot.y_low.has_value(), plot.y_high.has_value(), x.from,
                       x.to, y.from, y.to, kStepsOfX, kStepsOfY));
  value_label(out, y, plot.y_label);
  text_at(out, 0.5 * (kLeft + kWidth - kRight), height - 6, "middle", plot.x_label, " class=\"along\"");
  out += "<g class=\"whole\">\n";
  value_axis(out, y_ticks, y, kWidth - kRight);
  const auto x_ticks = axis_ticks(x_low, x_high, 8);
  for (const double t : x_ticks)
    text_at(out, x(t), height - kBottom + 18, "middle", tick_text(t, step_of(x_ticks)));
  const std::size_t points =
      std::min(kPointsOfLine, kPointsOfPlot / std::max<std::size_t>(1, plot.lines.size()));
  // The first is drawn last: what matters most lies on top.
  for (std::size_t i = plot.lines.size(); i-- > 0;) {
    const Line& line = plot.lines[i];
    fmt::format_to(std::back_inserter(out),
                   "<path class=\"line\" stroke=\"var(--series-{})\" d=\"{}\" data-points=\"{:d}\" "
                   "data-runs=\"{}\"><title>{}</title></path>\n",
                   colour_of(i), path_of(line, x, y), line.points, numbers_of(line, x, y, points),
                   escaped(line.name));
    for (std::size_t p = 0; line.points && p < std::min(line.x.size(), line.y.size()); ++p)
      if (std::isfinite(line.x[p]) && std::isfinite(line.y[p]))
        fmt::format_to(std::back_inserter(out),
                       "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" fill=\"var(--series-{})\"/>\n",
                       x(line.x[p]), y(line.y[p]), colour_of(i));
  }
  return out + "</g>\n</svg>\n";
}

std::string svg(const BarPlot& plot) {
  // Many or long names stand better beneath each other: then bars lie.
  std::size_t longest = 0;
  for (const auto& group : plot.groups) longest = std::max(longest, group.name.size());
  const std::size_t series = std::max<std::size_t>(1, plot.series.size());
  const std::size_t groups = std::max<std::size_t>(1, plot.groups.size());
  const bool lying =
      static_cast<double>(groups) * (7.0 * static_cast<double>(longest) + 12) > kWidth - kLeft - kRight;

  double high = 0;
  for (const auto& group : plot.groups)
    for (std::size_t i = 0; i < group.values.size(); ++i)
      if (std::isfinite(group.values[i])) {
        const double spread = i < group.spread.size() && std::isfinite(group.spread[i]) ? group.spread[i] : 0;
        high = std::max(high, group.values[i] + spread);
      }
  if (!(high > 0)) high = 1;
  auto ticks = axis_ticks(0, high, 5);
  if (ticks.back() < high) ticks.push_back(ticks.back() + step_of(ticks));
  high = ticks.back();

  const double thick = lying ? std::clamp(26.0 / static_cast<double>(series), 5.0, 14.0) : 0;
  const double group_height = thick * static_cast<double>(series) + 7;
  const double height = lying ? kTop + group_height * static_cast<double>(groups) + kBottom : 260;
  const double names = lying ? std::min(0.45 * kWidth, 7.0 * static_cast<double>(longest) + 16) : kLeft;
  std::string out;
  open_svg(out, height, plot.title);
  const auto bar_title = [&](const BarPlot::Group& group, std::size_t i) {
    const std::string name = i < plot.series.size() ? plot.series[i] + ", " : "";
    return escaped(fmt::format("{}{}: {:.4g}", name, group.name, group.values[i]));
  };
  if (lying) {
    const Scale x{0, high, names, kWidth - kRight - 12};
    for (const double t : ticks) {
      fmt::format_to(std::back_inserter(out),
                     "<line class=\"grid\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2:.1f}\"/>\n", x(t),
                     kTop, height - kBottom);
      text_at(out, x(t), height - kBottom + 18, "middle", tick_text(t, step_of(ticks)));
    }
    text_at(out, 0.5 * (x.from + x.to), height - 6, "middle", plot.value_label);
    for (std::size_t g = 0; g < plot.groups.size(); ++g) {
      const auto& group = plot.groups[g];
      const double top = kTop + group_height * static_cast<double>(g) + 3.5;
      text_at(out, names - 8, top + 0.5 * (group_height - 7) + 4, "end", group.name);
      for (std::size_t i = 0; i < group.values.size(); ++i) {
        if (!std::isfinite(group.values[i])) continue;
        const double y = top + thick * static_cast<double>(i);
        fmt::format_to(std::back_inserter(out),
                       "<rect fill=\"var(--series-{})\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" "
                       "height=\"{:.1f}\" rx=\"1.5\"><title>{}</title></rect>\n",
                       colour_of(i), names, y, std::max(0.0, x(group.values[i]) - names), thick - 1,
                       bar_title(group, i));
        if (i < group.spread.size() && group.spread[i] > 0)
          fmt::format_to(std::back_inserter(out), "<path class=\"spread\" d=\"M{:.1f} {:.1f}H{:.1f}\"/>\n",
                         x(std::max(0.0, group.values[i] - group.spread[i])), y + 0.5 * thick,
                         x(group.values[i] + group.spread[i]));
      }
    }
    return out + "</svg>\n";
  }
  const Scale y{0, high, height - kBottom, kTop};
  value_axis(out, ticks, y, kWidth - kRight);
  value_label(out, y, plot.value_label);
  const double room = (kWidth - kRight - kLeft) / static_cast<double>(groups);
  const double width = std::min(46.0, 0.74 * room / static_cast<double>(series));
  for (std::size_t g = 0; g < plot.groups.size(); ++g) {
    const auto& group = plot.groups[g];
    const double middle = kLeft + room * (static_cast<double>(g) + 0.5);
    text_at(out, middle, height - kBottom + 20, "middle", group.name);
    const double left = middle - 0.5 * width * static_cast<double>(group.values.size());
    for (std::size_t i = 0; i < group.values.size(); ++i) {
      if (!std::isfinite(group.values[i])) continue;
      const double at = left + width * static_cast<double>(i);
      fmt::format_to(std::back_inserter(out),
                     "<rect fill=\"var(--series-{})\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" "
                     "height=\"{:.1f}\" rx=\"2\"><title>{}</title></rect>\n",
                     colour_of(i), at + 1, y(group.values[i]), width - 2,
                     std::max(0.0, y.from - y(group.values[i])), bar_title(group, i));
      if (i < group.spread.size() && group.spread[i] > 0)
        fmt::format_to(std::back_inserter(out), "<path class=\"spread\" d=\"M{:.1f} {:.1f}V{:.1f}\"/>\n",
                       at + 0.5 * width, y(std::max(0.0, group.values[i] - group.spread[i])),
                       y(group.values[i] + group.spread[i]));
    }
  }
  return out + "</svg>\n";
}

}  // namespace mien::measure
