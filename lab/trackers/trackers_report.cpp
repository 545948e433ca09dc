#include "lab/trackers/trackers_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "lab/moments.h"

namespace mien::lab {
namespace {

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();
/// Seconds over which the worst moment is sought, and that are kept each way.
constexpr double kMoment_s = 1, kMomentEachWay_s = 2.5;

/// Shapes whose curves are drawn around a worst moment.
struct DrawnShape {
  std::size_t shape;
  const char* name;
};
constexpr std::array<DrawnShape, 3> kDrawnShapes = {{{face::shape("jawOpen"), "jawOpen"},
                                                     {face::shape("mouthSmile_L"), "mouthSmile_L"},
                                                     {face::shape("eyeBlink_L"), "eyeBlink_L"}}};

/// How late each tracker is, and how sure that is.
const Columns<CurveScore>& lag_columns() {
  static const Columns<CurveScore> columns = {
      {"", "", "{}", &CurveScore::name},
      {"", "lag", "{:.0f}", [](const CurveScore& s) { return s.lag ? Json(1e3 * s.lag->lag_s) : Json(); }},
      {"", "standard error", "{:.0f}",
       [](const CurveScore& s) { return s.lag ? Json(1e3 * s.lag->sigma_s) : Json(); }}};
  return columns;
}

/// One bar a tracker.
measure::BarPlot tracker_bars(const CurveComparison& comparison, const std::string& group, std::string title,
                              std::string label, double (*value)(const CurveScore&)) {
  measure::BarPlot plot{
      .title = std::move(title), .value_label = std::move(label), .series = {}, .groups = {{group, {}, {}}}};
  for (const CurveScore& score : comparison.scores) {
    plot.series.push_back(score.name);
    plot.groups[0].values.push_back(value(score));
  }
  return plot;
}

/// One shape around the worst moment; gaps are breaks.
measure::LinePlot curves_around(const CurveComparison& comparison, const WorstMoment& moment,
                                const std::string& title, const DrawnShape& drawn) {
  measure::LinePlot plot{.title = fmt::format("{}: {} around its worst moment", title, drawn.name),
                         .x_label = "time (s)",
                         .y_label = "weight",
                         .lines = {},
                         .y_low = 0.0,
                         .y_high = 1.0,
                         .height = 200};
  const auto add = [&](const std::string& name, const auto& weight_of) {
    measure::Line& line = plot.lines.emplace_back(measure::Line{name, {}, {}});
    for (std::size_t f = moment.begin; f < moment.end; ++f) {
      line.x.push_back(comparison.time_s[f]);
      line.y.push_back(weight_of(f));
    }
  };
  add("truth", [&](std::size_t f) { return double{comparison.truth[f][drawn.shape]}; });
  for (const CurveScore& score : comparison.scores)
    if (score.told_shapes[drawn.shape])
      add(score.name,
          [&](std::size_t f) { return score.saw[f] ? double{score.shown[f][drawn.shape]} : kNoValue; });
  return plot;
}

std::vector<measure::KeyFigure> tracker_key_figures(const CurveComparison& comparison,
                                                    const std::string& title) {
  std::vector<measure::KeyFigure> out;
  for (const CurveScore& score : comparison.scores) {
    const std::string of_what = score.offset_unknown ? "its offset was not found"
                                : comparison.shared_clock
                                    ? "vertex error, gaps held, all shapes"
                                    : "vertex error, gaps held, all shapes, its offset taken out";
    out.push_back({fmt::format("{}, {}", score.name, title),
                   score.offset_unknown ? "-" : fmt::format("{:.2f} mm", score.pve_whole_mm),
                   fmt::format("{}; {:.1f} % of the frames in gaps", of_what, 100 * score.gap_share)});
  }
  return out;
}

constexpr int kStripCell_px = 160;
constexpr std::array<double, 3> kStripTimes_s = {-0.33, 0, 0.33};

/// Printable ASCII, as strips are lettered.
std::string letters_of(std::string name) {
  std::ranges::replace_if(
      name, [](char c) { return c < ' ' || c > '~'; }, '?');
  return name;
}

std::size_t nearest_frame(const std::vector<double>& time_s, double sought_s) {
  const auto nearest = std::ranges::min_element(
      time_s, {}, [sought_s](double frame_s) { return std::abs(frame_s - sought_s); });
  return static_cast<std::size_t>(nearest - time_s.begin());
}

std::string trackers_legend(bool shared_clock) {
  std::string out =
      "All on one time line: the truth's frames in the time that all recordings share. In gaps: frames "
      "without a face, or more than three periods without a row. PVE seen: vertex error over the frames that "
      "the tracker saw, its lag in it; without lag: the same moved by the lag that was found; held: over all "
      "frames, an avatar keeping the last face in gaps. Up to there, and for landmarks, shapes that a "
      "tracker does not tell are taken from the truth; all shapes: they stay 0. MSE told: over the shapes "
      "that it tells, held; common: over those that all tell.";
  if (!shared_clock)
    out +=
        " These recordings share no clock. Each is counted from its first row, so that its lag has in it "
        "when somebody began to record; what is found of it is taken out of all but PVE seen, of every "
        "tracker alike, and no tracker's own lateness counts.";
  return out + " All else: docs/reference/tracker_curves.md.";
}

}  // namespace

const Columns<CurveScore>& tracker_columns() {
  using S = CurveScore;
  const auto of = [](std::optional<CurveErrors> S::*errors, double CurveErrors::*figure) {
    return [=](const S& score) { return score.*errors ? Json((*(score.*errors)).*figure) : Json(); };
  };
  // Over all frames.
  const auto held = [](const auto& figure) {
    return [=](const S& score) { return score.offset_unknown ? Json() : Json(figure(score)); };
  };
  static const Columns<S> columns = {
      {"name", "", "{}", &S::name},
      {"told_shapes", "shapes", "{}", [](const S& s) { return s.told_shapes.count(); }},
      {"", "in gaps, %", "{:.1f}", &S::gap_share, 100},
      {"pve_seen_mm", "PVE seen, mm", "{:.2f}", of(&S::as_told, &CurveErrors::pve_mm)},
      {"pve_without_lag_mm", "without lag", "{:.2f}", of(&S::without_lag, &CurveErrors::pve_mm)},
      {"pve_held_mm", "held", "{:.2f}", held([](const S& s) { return s.held.pve_mm; })},
      {"pve_whole_mm", "held, all shapes", "{:.2f}", held([](const S& s) { return s.pve_whole_mm; })},
      {"pve_face_held_mm", "", "", held([](const S& s) { return or_null(s.held.pve_face_mm); })},
      {"landmarks_held_mm", "landmarks, mm", "{:.2f}",
       held([](const S& s) { return or_null(s.held.landmarks_mm); })},
      {"mse_seen", "", "", of(&S::as_told, &CurveErrors::mse_told)},
      {"mse_without_lag", "", "", of(&S::without_lag, &CurveErrors::mse_told)},
      {"mse_held", "MSE told", "{:.4f}", held([](const S& s) { return s.held.mse_told; })},
      {"mse_common", "MSE common", "{:.4f}", held([](const S& s) { return or_null(s.held.mse_common); })},
      {"mse_whole", "", "", held([](const S& s) { return s.mse_whole; })},
      {"gap_share", "", "", &S::gap_share},
      {"lag_ms", "", "", [](const S& s) { return s.lag ? Json(1e3 * s.lag->lag_s) : Json(); }},
      {"lag_sigma_ms", "", "", [](const S& s) { return s.lag ? Json(1e3 * s.lag->sigma_s) : Json(); }}};
  return columns;
}

std::optional<WorstMoment> worst_moment(const CurveComparison& comparison) {
  std::optional<WorstMoment> out;
  const std::vector<double>& time_s = comparison.time_s;
  for (const CurveScore& score : comparison.scores) {
    if (score.offset_unknown) continue;
    // A window that slides over the time: what comes in at its end leaves at its beginning.
    double sum_mm = 0;
    std::size_t begin = 0;
    for (std::size_t end = 0; end < time_s.size(); ++end) {
      sum_mm += score.pve_mm[end];
      for (; time_s[end] - time_s[begin] > kMoment_s; ++begin) sum_mm -= score.pve_mm[begin];
      const double mean_mm = sum_mm / static_cast<double>(end - begin + 1);
      const bool whole = time_s[end] - time_s[begin] > 0.9 * kMoment_s || end + 1 == time_s.size();
      if (whole && (!out || mean_mm > out->pve_mm))
        out = {.tracker = score.name, .time_s = 0.5 * (time_s[begin] + time_s[end]), .pve_mm = mean_mm};
    }
  }
  if (!out) return out;
  const auto is_near = [&](double frame_s) { return std::abs(frame_s - out->time_s) <= kMomentEachWay_s; };
  const auto first = std::ranges::find_if(time_s, is_near);
  out->begin = static_cast<std::size_t>(first - time_s.begin());
  out->end = static_cast<std::size_t>(std::find_if_not(first, time_s.end(), is_near) - time_s.begin());
  return out;
}

Result<measure::Report> trackers_report(const CurveComparison& comparison, const std::string& title,
                                        const std::string& subtitle,
                                        const std::optional<render::Image>& strip) {
  measure::Report report("Trackers on one time line", subtitle);
  for (const CurveScore& score : comparison.scores)
    if (score.offset_unknown)
      report.text(fmt::format(
          "{}: how much earlier or later it began than the truth was not found (not within --search, or too "
          "little agrees), so its errors over all frames are left out; its PVE seen has that offset in it.",
          score.name));
  report.key_figures(tracker_key_figures(comparison, title));
  const bool shared = comparison.shared_clock;
  report.bars(tracker_bars(comparison, title,
                           shared ? "Vertex error, gaps held, all shapes"
                                  : "Vertex error, gaps held, all shapes, offsets taken out",
                           "PVE (mm)", [](const CurveScore& score) {
                             return score.offset_unknown ? kNoValue : score.pve_whole_mm;
                           }));
  report.bars(tracker_bars(comparison, title, "Frames in gaps", "share (%)",
                           [](const CurveScore& score) { return 100 * score.gap_share; }));
  report.table(
      table_of(fmt::format("Errors; all tell {} shapes{}", comparison.common.count(),
                           shared ? "" : "; each recording's offset is taken out of all but PVE seen"),
               comparison.scores, tracker_columns()));
  report.table(table_of(shared ? "Lag behind the truth, ms"
                               : "Behind the truth, ms: lag and, since recordings share no clock, how much "
                                 "earlier each began",
                        comparison.scores, lag_columns()));
  if (const auto moment = worst_moment(comparison)) {
    report.heading("Worst moments");
    report.text(
        fmt::format("{}: {} is worst at {:.2f} s, with a vertex error of {:.2f} mm over that second, gaps "
                    "held. Lines break where a tracker saw no face.",
                    title, moment->tracker, moment->time_s, moment->pve_mm));
    if (strip) {
      MIEN_TRY_ASSIGN(const std::vector<std::byte> png, render::encode_png(*strip));
      report.image(png, fmt::format("{}: the worst moment. Pale: the tracker saw no face.", title));
    }
    for (const DrawnShape& drawn : kDrawnShapes)
      report.plot(curves_around(comparison, *moment, title, drawn));
  }
  report.heading("How to read this");
  report.text(trackers_legend(shared));
  return report;
}

Result<render::Image> moment_strip(const face::Face& face, const CurveComparison& comparison,
                                   const WorstMoment& moment) {
  std::vector<std::string> captions;
  std::vector<MomentRow> rows = {{"truth", {}}};
  for (const CurveScore& score : comparison.scores) rows.push_back({letters_of(score.name), {}});
  for (const double aside_s : kStripTimes_s) {
    const std::size_t f = nearest_frame(comparison.time_s, moment.time_s + aside_s);
    captions.push_back(fmt::format("{:.2f} s", comparison.time_s[f]));
    rows[0].weights.emplace_back(comparison.truth[f]);
    for (std::size_t i = 0; i < comparison.scores.size(); ++i) {
      const CurveScore& score = comparison.scores[i];
      rows[i + 1].weights.push_back(score.saw[f] ? std::optional(score.shown[f]) : std::nullopt);
    }
  }
  return moments_strip(face, rows, captions, kStripCell_px);
}

}  // namespace mien::lab
