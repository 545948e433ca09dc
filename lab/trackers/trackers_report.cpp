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

struct TrackerColumn {
  TrackerMeasure measure;
  const char* head;
  int decimals;
  double factor;
};
constexpr std::array<TrackerColumn, 8> kTrackerColumns = {
    {{TrackerMeasure::gap_share, "in gaps, %", 1, 100},
     {TrackerMeasure::pve_seen, "PVE seen, mm", 2, 1},
     {TrackerMeasure::pve_without_lag, "without lag", 2, 1},
     {TrackerMeasure::pve_held, "held", 2, 1},
     {TrackerMeasure::pve_whole, "held, all shapes", 2, 1},
     {TrackerMeasure::landmarks_held, "landmarks, mm", 2, 1},
     {TrackerMeasure::mse_held, "MSE told", 4, 1},
     {TrackerMeasure::mse_common, "MSE common", 4, 1}}};

/// Beside it stands by how much it is above the reference's.
constexpr TrackerMeasure kAboveMeasure = TrackerMeasure::pve_whole;

/// Shapes whose curves are drawn around a worst moment.
struct DrawnShape {
  std::size_t shape;
  const char* name;
};
constexpr std::array<DrawnShape, 3> kDrawnShapes = {{{face::shape("jawOpen"), "jawOpen"},
                                                     {face::shape("mouthSmile_L"), "mouthSmile_L"},
                                                     {face::shape("eyeBlink_L"), "eyeBlink_L"}}};

/// "0.70 ± 0.09"; of one performer the figure alone.
std::string shown_mean(const std::optional<TrackerMean>& mean, int decimals, double factor) {
  if (!mean) return "-";
  if (!mean->interval) return fmt::format("{:.{}f}", factor * mean->mean, decimals);
  return fmt::format("{:.{}f} ± {:.{}f}", factor * mean->mean, decimals,
                     0.5 * factor * ((*mean->interval)[1] - (*mean->interval)[0]), decimals);
}

/// "+0.32 ± 0.09": by how much a tracker is above the one that it is held against.
std::string shown_above(const TrackerMethod& method, const TrackerMethod* reference) {
  if (reference == nullptr || reference == &method) return "-";
  const auto above = method.above(*reference, kAboveMeasure);
  return (above && above->mean >= 0 ? "+" : "") + shown_mean(above, 2, 1);
}

bool of_recordings(const TrackersStudy& study) {
  return !study.rows.empty() && study.rows.front().key == "recording";
}

/// A head across all columns.
std::string row_head(const TrackersRow& row) {
  const std::size_t performers = row.methods.empty() ? 0 : row.methods.front().performers.size();
  const std::string who =
      row.key == "recording" ? "" : fmt::format("{} performer{}, ", performers, performers == 1 ? "" : "s");
  return fmt::format("{} ({}{:.0f} s, {} common shape{})", row.title, who,
                     static_cast<double>(row.frames) / row.frames_hz, row.common, row.common == 1 ? "" : "s");
}

measure::BarPlot bars_of(const TrackersStudy& study, TrackerMeasure measure, std::string title,
                         std::string label, double factor) {
  measure::BarPlot plot{
      .title = std::move(title), .value_label = std::move(label), .series = {}, .groups = {}};
  for (const TrackersRow& row : study.rows) {
    measure::BarPlot::Group bars{row.title, {}, {}};
    plot.series.clear();
    for (const TrackerMethod& method : row.methods) {
      const std::optional<TrackerMean> mean = method.over(measure);
      plot.series.push_back(method.name);
      bars.values.push_back(mean ? factor * mean->mean : kNoValue);
      // Drawn as plus and minus; half of the interval's width stands for it.
      bars.spread.push_back(
          mean && mean->interval ? 0.5 * factor * ((*mean->interval)[1] - (*mean->interval)[0]) : kNoValue);
    }
    plot.groups.push_back(std::move(bars));
  }
  return plot;
}

/// One shape around a row's worst moment; gaps are breaks.
measure::LinePlot curves_around(const TrackersRow& row, const DrawnShape& drawn) {
  const TrackerMoment& moment = *row.moment;
  measure::LinePlot plot{.title = fmt::format("{}: {} around its worst moment", row.title, drawn.name),
                         .x_label = "time (s)",
                         .y_label = "weight",
                         .lines = {},
                         .y_low = 0.0,
                         .y_high = 1.0,
                         .height = 200};
  measure::Line truth{"truth", moment.time_s, {}};
  for (const face::BlendshapeWeights& weights : moment.truth)
    truth.y.push_back(static_cast<double>(weights[drawn.shape]));
  plot.lines.push_back(std::move(truth));
  for (const TrackerMoment::Line& line : moment.lines) {
    if (!line.told[drawn.shape]) continue;
    measure::Line curve{line.name, moment.time_s, {}};
    for (std::size_t f = 0; f < line.shown.size(); ++f)
      curve.y.push_back(line.saw[f] ? static_cast<double>(line.shown[f][drawn.shape]) : kNoValue);
    plot.lines.push_back(std::move(curve));
  }
  return plot;
}

std::vector<measure::KeyFigure> tracker_key_figures(const TrackersStudy& study) {
  std::vector<measure::KeyFigure> out;
  for (const TrackersRow& row : study.rows) {
    const TrackerMethod* own = row.find(study.reference);
    if (own == nullptr) {
      const char* offset = study.shared_clock ? "" : ", its offset taken out";
      for (const TrackerMethod& method : row.methods) {
        const auto held = method.over(TrackerMeasure::pve_whole);
        out.push_back({fmt::format("{}, {}", method.name, row.title),
                       held ? fmt::format("{:.2f} mm", held->mean) : "-",
                       fmt::format("{}; {:.1f} % of the frames in gaps",
                                   held ? fmt::format("vertex error, gaps held, all shapes{}", offset)
                                        : "its offset was not found",
                                   100 * method.over(TrackerMeasure::gap_share)->mean)});
      }
      continue;
    }
    // The best of the others is what ours is held against.
    const TrackerMethod* best = nullptr;
    double least = 0;
    for (const TrackerMethod& method : row.methods) {
      const auto mean = method.over(TrackerMeasure::pve_whole);
      if (&method == own || !mean || (best != nullptr && mean->mean >= least)) continue;
      best = &method;
      least = mean->mean;
    }
    const auto mean = own->over(TrackerMeasure::pve_whole);
    if (mean)
      out.push_back({fmt::format("{}, {}", own->name, row.title), fmt::format("{:.2f} mm", mean->mean),
                     best != nullptr ? fmt::format("vertex error, gaps held; {} {:.2f}", best->name, least)
                                     : "vertex error"});
  }
  return out;
}

Result<void> add_pictures(const TrackersRow& row, std::span<const TrackerPicture> pictures,
                          measure::Report& report) {
  for (const TrackerPicture& picture : pictures) {
    if (picture.row != row.key || !picture.strip) continue;
    MIEN_TRY_ASSIGN(const std::vector<std::byte> png, render::encode_png(*picture.strip));
    report.image(png, picture.caption);
  }
  return {};
}

std::string moment_caption(const TrackersRow& row, const std::string& reference) {
  const std::string who =
      row.key == "recording" ? "" : fmt::format(" Performer {}.", row.moment->performer + 1);
  const std::string above = row.find(reference) == nullptr ? ""
                                                           : fmt::format(", {:.2f} mm above that of {}",
                                                                         row.moment->above_mm, reference);
  return fmt::format(
      "{}: {} is worst at {:.2f} s, with a vertex error of {:.2f} mm over that second{}, gaps held.{} Lines "
      "break where a tracker saw no face.",
      row.title, row.moment->worst, row.moment->worst_s, row.moment->pve_mm, above, who);
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

measure::Table sources_table(const ModelledTracker& tracker) {
  measure::Table table;
  table.caption = tracker.name + ": where its numbers come from";
  table.columns = {"number", "value", "source"};
  for (const ModelledNumber& number : tracker.numbers)
    table.rows.push_back({number.what, number.value, number.source});
  return table;
}

std::string trackers_legend(const TrackersStudy& study) {
  std::string out =
      "All on one time line: the truth's frames in the time that all recordings share. In gaps: frames "
      "without a face, or more than three periods without a row. PVE seen: vertex error over the frames that "
      "the tracker saw, its lag in it; without lag: the same moved by the lag that was found; held: over all "
      "frames, an avatar keeping the last face in gaps. Up to there, and for landmarks, shapes that a "
      "tracker does not tell are taken from the truth; all shapes: they stay 0. MSE told: over the shapes "
      "that it tells, held; common: over those that all tell.";
  if (!study.shared_clock)
    out +=
        " These recordings share no clock. Each is counted from its first row, so that its lag has in it "
        "when somebody began to record; what is found of it is taken out of all but PVE seen, of every "
        "tracker alike, and no tracker's own lateness counts.";
  if (!study.reference.empty())
    out += fmt::format(
        " Above {}: by how much its error of all shapes is higher, performer by performer, so that what they "
        "have in common cancels; its interval is that of the differences.",
        study.reference);
  if (!of_recordings(study)) out += " Behind ±: half of the 95 % interval over performers (Student's t).";
  return out + " All else: docs/reference/tracker_curves.md.";
}

std::vector<std::string> offset_notices(const TrackersStudy& study) {
  std::vector<std::string> out;
  for (const std::string& name : study.offset_unknown)
    out.push_back(fmt::format(
        "{}: how much earlier or later it began than the truth was not found (not within --search, or too "
        "little agrees), so its errors over all frames are left out; its PVE seen has that offset in it.",
        name));
  return out;
}

}  // namespace

std::string modelled_notice() {
  return "Modelled, not measured: no camera looked at anybody here. The camera trackers are models, made of "
         "what is published of each and of assumptions where nothing is; the numbers that matter most stand "
         "below with their sources. Their delays have a camera's exposure and a webcam's buffer in them, "
         "ours no radio. Ours is measured on simulated sensors that are worn by virtual performers. What "
         "these figures say is where trackers of each kind must fail and what that costs; how large their "
         "errors are on real faces only recordings tell (mien study trackers --truth FILE --curves "
         "NAME=FILE).";
}

measure::Table trackers_table(const TrackersStudy& study) {
  measure::Table table;
  table.caption = study.modelled       ? "Errors by condition; camera trackers are modelled"
                  : study.shared_clock ? "Errors"
                                       : "Errors; each recording's offset is taken out of all but PVE seen";
  table.columns = {"", "shapes"};
  const bool compares = !study.reference.empty();
  for (const TrackerColumn& column : kTrackerColumns) {
    table.columns.emplace_back(column.head);
    if (compares && column.measure == kAboveMeasure) table.columns.push_back("above " + study.reference);
  }
  for (const TrackersRow& row : study.rows) {
    table.strong_rows.push_back(table.rows.size());
    table.rows.push_back({row_head(row)});
    for (const TrackerMethod& method : row.methods) {
      std::vector<std::string>& cells = table.rows.emplace_back();
      cells = {method.name, std::to_string(method.told)};
      for (const TrackerColumn& column : kTrackerColumns) {
        cells.push_back(shown_mean(method.over(column.measure), column.decimals, column.factor));
        if (compares && column.measure == kAboveMeasure)
          cells.push_back(shown_above(method, row.find(study.reference)));
      }
    }
  }
  return table;
}

measure::Table lag_table(const TrackersStudy& study) {
  measure::Table table;
  table.caption =
      !study.shared_clock
          ? "Behind the truth, ms: lag and, since recordings share no clock, how much earlier each began"
      : of_recordings(study) ? "Lag behind the truth, ms"
                             : "Lag behind the truth, ms; found: performances in which it could be told";
  table.columns = {"", "lag", "standard error of one", "found"};
  for (const TrackersRow& row : study.rows) {
    table.strong_rows.push_back(table.rows.size());
    table.rows.push_back({row.title});
    for (const TrackerMethod& method : row.methods) {
      const std::optional<TrackerMean> lag = method.over(TrackerMeasure::lag);
      table.rows.push_back({method.name, shown_mean(lag, 0, 1),
                            lag ? fmt::format("{:.0f}", method.over(TrackerMeasure::lag_sigma)->mean) : "-",
                            fmt::format("{} of {}", lag ? lag->performers : 0, method.performers.size())});
    }
  }
  return table;
}

Result<measure::Report> trackers_report(const TrackersStudy& study, const std::string& subtitle,
                                        std::span<const TrackerPicture> pictures) {
  measure::Report report(
      study.modelled ? "Camera trackers beside the IMUs (modelled)" : "Trackers on one time line", subtitle);
  if (study.modelled) report.text(modelled_notice());
  for (const std::string& notice : offset_notices(study)) report.text(notice);
  report.key_figures(tracker_key_figures(study));
  report.bars(bars_of(study, TrackerMeasure::pve_whole,
                      study.shared_clock ? "Vertex error by condition, gaps held, all shapes"
                                         : "Vertex error, gaps held, all shapes, offsets taken out",
                      "PVE (mm)", 1));
  report.bars(bars_of(study, TrackerMeasure::gap_share, "Frames in gaps", "share (%)", 100));
  report.table(trackers_table(study));
  report.table(lag_table(study));
  const auto has_moment = [](const TrackersRow& row) { return row.moment.has_value(); };
  if (std::ranges::any_of(study.rows, has_moment)) report.heading("Worst moments");
  for (const TrackersRow& row : study.rows) {
    if (!row.what.empty()) report.text(row.title + ": " + row.what);
    if (!row.moment || row.moment->time_s.empty()) continue;
    report.text(moment_caption(row, study.reference));
    MIEN_TRY(add_pictures(row, pictures, report));
    for (const DrawnShape& drawn : kDrawnShapes) report.plot(curves_around(row, drawn));
  }
  report.heading("How to read this");
  report.text(trackers_legend(study));
  if (study.modelled) {
    report.heading("Where the numbers of the modelled trackers come from");
    for (const ModelledTracker& tracker : modelled_trackers()) report.table(sources_table(tracker));
  }
  return report;
}

Result<TrackerPicture> tracker_picture(const face::Face& face, const TrackersRow& row) {
  TrackerPicture out{.row = row.key, .strip = {}, .caption = {}};
  if (!row.moment || row.moment->time_s.empty()) return out;
  const TrackerMoment& moment = *row.moment;
  std::vector<std::size_t> frames;
  std::vector<std::string> captions;
  for (const double aside_s : kStripTimes_s) {
    frames.push_back(nearest_frame(moment.time_s, moment.worst_s + aside_s));
    captions.push_back(fmt::format("{:.2f} s", moment.time_s[frames.back()]));
  }
  std::vector<MomentRow> rows;
  MomentRow& truth = rows.emplace_back();
  truth.name = "truth";
  for (const std::size_t f : frames) truth.weights.emplace_back(moment.truth[f]);
  for (const TrackerMoment::Line& line : moment.lines) {
    MomentRow& shown = rows.emplace_back();
    shown.name = letters_of(line.name);
    for (const std::size_t f : frames)
      shown.weights.push_back(line.saw[f] ? std::optional(line.shown[f]) : std::nullopt);
  }
  MIEN_TRY_ASSIGN(out.strip, moments_strip(face, rows, captions, kStripCell_px));
  out.caption = fmt::format("{}: the worst moment. Pale: the tracker saw no face.", row.title);
  return out;
}

}  // namespace mien::lab
