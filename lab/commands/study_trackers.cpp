#include "lab/commands/studies.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/chosen_face.h"
#include "app/json_output.h"
#include "app/private_folder.h"
#include "lab/commands/output.h"
#include "lab/trackers/trackers_report.h"
#include "mien/core/excerpt.h"
#include "mien/core/nearest_word.h"
#include "mien/core/time.h"
#include "mien/take/take.h"

namespace mien::lab {
namespace {

struct StudyTrackersOptions {
  CompareSettings compare;
  std::string truth;
  std::vector<std::string> curves;   // NAME=FILE.
  std::vector<std::string> offsets;  // NAME=SECONDS.
  std::string face = "builtin";
  Output to;
};

/// "NAME=VALUE".
Result<std::pair<std::string, std::string>> cut_named(const std::string& named, const char* what) {
  const std::size_t sign = named.find('=');
  if (sign == std::string::npos || sign == 0 || sign + 1 == named.size())
    return fail(ErrorCode::bad_usage, what, excerpt(named));
  return std::pair(without_controls(named.substr(0, sign)), named.substr(sign + 1));
}

/// The truth of a take: what is not evaluated is left out of the comparison, as if no face had been seen.
Result<TrackerCurves> truth_of_take(const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(path));
  MIEN_TRY_ASSIGN(const std::vector<take::TruthFrame> truth, take.truth());
  if (truth.empty())
    return fail(ErrorCode::not_found, "this take holds no truth", path.string(),
                "give one that was recorded with a phone as truth, or the phone's own CSV");
  TrackerCurves out{.name = "truth", .rows = {}, .told = {}, .warnings = {}};
  out.told.set();
  for (const take::TruthFrame& frame : truth) {
    TrackerRow row{.time_s = to_seconds(frame.time.time_since_epoch()), .weights = {}};
    if (frame.has_face && frame.evaluated) row.weights = frame.weights;
    MIEN_TRY(add_row(out, row, path.string()));
  }
  return out;
}

Result<TrackerCurves> curves_in(const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(TrackerCurves curves, read_tracker_curves(path));
  for (const std::string& warning : curves.warnings)
    fmt::print(stderr, "mien: {}: {}\n", without_controls(path.string()), without_controls(warning));
  return curves;
}

/// By how much each recording is moved, s; 0 where nothing is said.
Result<void> move_by_offsets(const std::vector<std::string>& offsets, std::vector<TrackerCurves>& trackers) {
  std::vector<std::string> names;
  for (const TrackerCurves& curves : trackers) names.push_back(curves.name);
  for (const std::string& offset : offsets) {
    MIEN_TRY_ASSIGN(const auto named, cut_named(offset, "an offset is NAME=SECONDS"));
    double seconds = 0;
    const std::string& text = named.second;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), seconds);
    if (code != std::errc{} || end != text.data() + text.size() || !(std::abs(seconds) <= 1e6))
      return fail(ErrorCode::bad_usage, "an offset is NAME=SECONDS, within a million", excerpt(offset));
    const auto found = std::ranges::find(trackers, named.first, &TrackerCurves::name);
    if (found == trackers.end())
      return fail(ErrorCode::bad_usage, fmt::format("no --curves are called '{}'{}", excerpt(named.first),
                                                    did_you_mean(named.first, names)));
    for (TrackerRow& row : found->rows) row.time_s += seconds;
  }
  return {};
}

/// What is compared, on one time line.
struct Recordings {
  TrackerCurves truth;
  std::vector<TrackerCurves> trackers;
};

Result<Recordings> read_recordings(const StudyTrackersOptions& options) {
  Recordings out;
  const std::filesystem::path path = options.truth;
  MIEN_TRY_ASSIGN(out.truth, path.extension() == ".mien" ? truth_of_take(path) : curves_in(path));
  out.truth.name = "the truth";
  for (const std::string& named : options.curves) {
    MIEN_TRY_ASSIGN(const auto cut, cut_named(named, "a tracker's curves are NAME=FILE"));
    MIEN_TRY_ASSIGN(out.trackers.emplace_back(), curves_in(cut.second));
    out.trackers.back().name = cut.first;
  }
  if (!options.compare.shared_clock) {
    out.truth = counted_from_start(std::move(out.truth));
    for (TrackerCurves& curves : out.trackers) curves = counted_from_start(std::move(curves));
  }
  MIEN_TRY(move_by_offsets(options.offsets, out.trackers));
  return out;
}

/// Of one recording the mean is the figure, and no interval is known.
app::Json tracker_json(const CurveScore& score) {
  app::Json out = json_of(score, tracker_columns());
  for (auto& [name, figure] : out.items())
    if (figure.is_number() && name != "told_shapes")
      figure = {{"mean", figure},
                {"low", app::Json()},
                {"high", app::Json()},
                {"performers", app::Json::array({figure})}};
  out["pve_whole_above_reference_mm"] = app::Json();
  return out;
}

app::Json comparison_json(const CurveComparison& comparison, const StudyTrackersOptions& options,
                          const std::string& title) {
  app::Json worst;
  if (const auto moment = worst_moment(comparison))
    worst = {{"performer", 0},
             {"time_s", moment->time_s},
             {"tracker", moment->tracker},
             {"pve_mm", moment->pve_mm},
             {"above_reference_mm", app::Json()}};
  app::Json unknown = app::Json::array(), trackers = app::Json::array();
  for (const CurveScore& score : comparison.scores) {
    if (score.offset_unknown) unknown.push_back(score.name);
    trackers.push_back(tracker_json(score));
  }
  app::Json out = {{"modelled", false},
                   {"search_s", options.compare.search_s},
                   {"truth", options.truth},
                   {"curves", options.curves},
                   {"offsets", options.offsets},
                   {"shared_clock", options.compare.shared_clock},
                   {"offset_unknown", std::move(unknown)},
                   {"face", options.face},
                   {"rows", app::Json::array()}};
  out["rows"].push_back({{"condition", "recording"},
                         {"title", title},
                         {"frames", comparison.time_s.size()},
                         {"common_shapes", comparison.common.count()},
                         {"worst", std::move(worst)},
                         {"trackers", std::move(trackers)}});
  return out;
}

/// The worst moment's picture. Where it cannot be drawn the page is without it; stderr says so.
std::optional<render::Image> strip_of(const face::Face& face, const CurveComparison& comparison) {
  const auto moment = worst_moment(comparison);
  if (!moment) return std::nullopt;
  auto strip = moment_strip(face, comparison, *moment);
  if (strip) return std::move(*strip);
  app::clear_progress();
  fmt::print(stderr, "mien: no picture of the worst moment: {}\n", without_controls(strip.error().message()));
  return std::nullopt;
}

Result<void> run_study_trackers(const StudyTrackersOptions& options) {
  MIEN_TRY_ASSIGN(const Recordings recorded, read_recordings(options));
  MIEN_TRY_ASSIGN(const face::Face face, app::chosen_face(options.face, app::face_progress(options.face)));
  MIEN_TRY_ASSIGN(const CurveComparison comparison,
                  compare_curves(measure::Meter(face), recorded.truth, recorded.trackers, options.compare));
  app::clear_progress();
  MIEN_TRY(app::make_private_folders(options.to.out));
  const std::string title = std::filesystem::path(options.truth).filename().string();
  const std::string subtitle =
      fmt::format("truth {}, on the face {}; over {:.1f} s that all have in common, of the truth's {:.1f} s",
                  title, options.face, comparison.time_s.back() - comparison.time_s.front(),
                  recorded.truth.last_s() - recorded.truth.first_s());
  MIEN_TRY_ASSIGN(const measure::Report report,
                  trackers_report(comparison, title, without_controls(subtitle), strip_of(face, comparison)));
  return put_out_in_folder(options.to, "trackers", report, comparison_json(comparison, options, title));
}

}  // namespace

void add_study_trackers(app::Commands& commands, app::Command study) {
  auto options = std::make_shared<StudyTrackersOptions>();
  options->compare.shared_clock = false;
  const app::Command command = commands.add_under(
      study, "trackers", "Recordings of face trackers on one time line: gaps, lag and error",
      "mien study trackers --truth take.mien --curves ours=solved.csv phone=MySlate_3.csv "
      "webcam=scores.jsonl --out trackers",
      [options] { return run_study_trackers(*options); });
  command.add_option("--truth", options->truth, "A take with truth, or any curves that are to be the truth")
      .required();
  command
      .add_option("--curves", options->curves,
                  "Trackers' recordings as NAME=FILE: Live Link Face CSVs (`mien "
                  "solve` writes ours so), MediaPipe's scores, "
                  "OpenSeeFace's recordings")
      .required();
  command.add_option("--offset", options->offsets,
                     "Move recordings later, as NAME=SECONDS; negative is earlier");
  command.add_flag("--shared-clock", options->compare.shared_clock,
                   "The files' times are of one clock; else each is counted from its first row, and the lag "
                   "that is found of it is taken out of its errors, since it has in it when somebody began "
                   "to record");
  command
      .add_option("--face", options->face, "Face on which the recordings are measured, as mien face takes it")
      .show_default();
  command.add_option("--search", options->compare.search_s, "Seek lags within plus and minus so many seconds")
      .number_between(0.05, 5.0)
      .show_default();
  command
      .add_option("--out", options->to.out,
                  "Folder for trackers.html, trackers.txt and trackers.json; made where it is not")
      .required();
  app::add_json_flag(command, options->to.json);
}

}  // namespace mien::lab
