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
#include "app/seed_option.h"
#include "lab/commands/output.h"
#include "lab/trackers/trackers_report.h"
#include "lab/trackers/trackers_study.h"
#include "mien/core/excerpt.h"
#include "mien/core/nearest_word.h"
#include "mien/core/time.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"
#include "mien/take/take.h"

namespace mien::lab {
namespace {

struct StudyTrackersOptions {
  TrackersRequest request;
  std::vector<std::string> rows;
  std::string rig;
  std::string live;
  std::string truth;
  std::vector<std::string> curves;   // NAME=FILE.
  std::vector<std::string> offsets;  // NAME=SECONDS.
  std::string face = "builtin";
  bool shared_clock = false;
  bool quick = false;
  Output to;
};

/// What the study is of, for its page.
struct StudiedTrackers {
  TrackersStudy study;
  std::string subtitle;
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

Result<StudiedTrackers> compare_recordings(const StudyTrackersOptions& options) {
  const std::filesystem::path path = options.truth;
  TrackerCurves truth;
  if (path.extension() == ".mien") {
    MIEN_TRY_ASSIGN(truth, truth_of_take(path));
  } else {
    MIEN_TRY_ASSIGN(truth, curves_in(path));
  }
  truth.name = "the truth";
  std::vector<TrackerCurves> trackers;
  for (const std::string& named : options.curves) {
    MIEN_TRY_ASSIGN(const auto cut, cut_named(named, "a tracker's curves are NAME=FILE"));
    MIEN_TRY_ASSIGN(trackers.emplace_back(), curves_in(cut.second));
    trackers.back().name = cut.first;
  }
  if (!options.shared_clock) {
    truth = counted_from_start(std::move(truth));
    for (TrackerCurves& curves : trackers) curves = counted_from_start(std::move(curves));
  }
  MIEN_TRY(move_by_offsets(options.offsets, trackers));
  MIEN_TRY_ASSIGN(const face::Face face, app::chosen_face(options.face, app::face_progress(options.face)));
  const measure::Meter meter(face);
  CompareSettings settings = options.request.compare;
  settings.shared_clock = options.shared_clock;
  MIEN_TRY_ASSIGN(const CurveComparison comparison, compare_curves(meter, truth, trackers, settings));
  app::clear_progress();
  return StudiedTrackers{
      study_of(comparison, path.filename().string()),
      fmt::format("truth {}, on the face {}; over {:.1f} s that all have in common, of the "
                  "truth's {:.1f} s",
                  path.filename().string(), options.face,
                  comparison.time_s.back() - comparison.time_s.front(), truth.last_s() - truth.first_s())};
}

Result<StudiedTrackers> let_perform(StudyTrackersOptions& options) {
  MIEN_TRY_ASSIGN(options.rig, app::path_or(options.rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(options.live, app::path_or(options.live, "models/live.safetensors"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(options.rig));
  MIEN_TRY_ASSIGN(const model::ModelFile model, model::read_model(options.live));
  MIEN_TRY_ASSIGN(TrackersStudy study,
                  study_trackers(options.request, rig, model, app::terminal_progress("trackers")));
  app::clear_progress();
  return StudiedTrackers{
      std::move(study),
      fmt::format("model {}, rig {}, {} virtual performer{} of {:g} s, seed {}; camera trackers modelled",
                  std::filesystem::path(options.live).filename().string(), rig.name,
                  options.request.performers, options.request.performers == 1 ? "" : "s",
                  options.request.seconds, options.request.seed)};
}

app::Json mean_json(const std::optional<TrackerMean>& mean) {
  if (!mean) return {};
  app::Json out = {{"mean", mean->mean}, {"low", app::Json()}, {"high", app::Json()}};
  if (mean->interval) {
    out["low"] = (*mean->interval)[0];
    out["high"] = (*mean->interval)[1];
  }
  return out;
}

app::Json method_json(const TrackerMethod& method, const TrackerMethod* reference) {
  app::Json out = {{"name", method.name}, {"told_shapes", method.told}};
  for (std::size_t m = 0; m < kTrackerMeasureCount; ++m) {
    const auto measure = static_cast<TrackerMeasure>(m);
    app::Json& figure = out[std::string(tracker_measure_name(measure))] = mean_json(method.over(measure));
    if (figure.is_null()) continue;
    figure["performers"] = app::Json::array();
    for (const TrackerFigures& figures : method.performers)
      figure["performers"].push_back(figures[m] ? app::Json(*figures[m]) : app::Json());
  }
  out["pve_whole_above_reference_mm"] = reference != nullptr && reference != &method
                                            ? mean_json(method.above(*reference, TrackerMeasure::pve_whole))
                                            : app::Json();
  return out;
}

app::Json row_json(const TrackersRow& row, const std::string& reference) {
  app::Json trackers = app::Json::array();
  for (const TrackerMethod& method : row.methods)
    trackers.push_back(method_json(method, row.find(reference)));
  app::Json worst;
  if (row.moment)
    worst = {{"performer", row.moment->performer},
             {"time_s", row.moment->worst_s},
             {"tracker", row.moment->worst},
             {"pve_mm", row.moment->pve_mm},
             {"above_reference_mm", reference.empty() ? app::Json() : app::Json(row.moment->above_mm)}};
  return {{"condition", row.key},        {"title", row.title},        {"frames", row.frames},
          {"common_shapes", row.common}, {"worst", std::move(worst)}, {"trackers", std::move(trackers)}};
}

app::Json sources_json() {
  app::Json out = app::Json::array();
  for (const ModelledTracker& tracker : modelled_trackers())
    for (const ModelledNumber& number : tracker.numbers)
      out.push_back({{"tracker", tracker.name},
                     {"number", number.what},
                     {"value", number.value},
                     {"source", number.source},
                     {"assumed", number.assumed()}});
  return out;
}

app::Json study_json(const TrackersStudy& study, const StudyTrackersOptions& options) {
  app::Json out = {{"modelled", study.modelled}, {"search_s", options.request.compare.search_s}};
  if (study.modelled) {
    out["rig"] = options.rig;
    out["live"] = options.live;
    out["seed"] = options.request.seed;
    out["performers"] = options.request.performers;
    out["seconds"] = options.request.seconds;
    out["reference"] = study.reference;
    out["notice"] = modelled_notice();
  } else {
    out["truth"] = options.truth;
    out["curves"] = options.curves;
    out["offsets"] = options.offsets;
    out["shared_clock"] = options.shared_clock;
    out["offset_unknown"] = study.offset_unknown;
    out["face"] = options.face;
  }
  out["rows"] = app::Json::array();
  for (const TrackersRow& row : study.rows) out["rows"].push_back(row_json(row, study.reference));
  if (study.modelled) out["sources"] = sources_json();
  return out;
}

/// Pictures of the worst moments. Where they cannot be drawn, or that is stopped, the page is without them;
/// stderr says so.
std::vector<TrackerPicture> pictures_of(const TrackersStudy& study, const std::string& what) {
  std::vector<TrackerPicture> out;
  const auto without = [](const Error& error) {
    app::clear_progress();
    fmt::print(stderr, "mien: no pictures of the worst moments: {}\n", without_controls(error.message()));
    return std::vector<TrackerPicture>();
  };
  const auto face = app::chosen_face(what);
  if (!face) return without(face.error());
  const Progress progress = app::terminal_progress("pictures");
  for (const TrackersRow& row : study.rows) {
    if (!progress(static_cast<double>(out.size()) / static_cast<double>(study.rows.size()), row.title))
      return without({.code = ErrorCode::cancelled, .what = "stopped"});
    auto picture = tracker_picture(*face, row);
    if (!picture) return without(picture.error());
    out.push_back(std::move(*picture));
  }
  progress(1, "drawn");
  app::clear_progress();
  return out;
}

Result<void> run_study_trackers(StudyTrackersOptions options) {
  for (const std::string& row : options.rows) {
    MIEN_TRY_ASSIGN(options.request.conditions.emplace_back(), parse_tracker_condition(row));
  }
  if (options.quick) {
    options.request.performers = std::min(options.request.performers, 2);
    options.request.seconds = std::min(options.request.seconds, 10.0);
  }
  StudiedTrackers studied;
  if (options.truth.empty()) {
    MIEN_TRY_ASSIGN(studied, let_perform(options));
  } else {
    MIEN_TRY_ASSIGN(studied, compare_recordings(options));
  }
  if (options.quick) studied.subtitle += "; quick, compares nothing";
  MIEN_TRY(app::make_private_folders(options.to.out));
  MIEN_TRY_ASSIGN(const measure::Report report,
                  trackers_report(studied.study, without_controls(studied.subtitle),
                                  pictures_of(studied.study, options.face)));
  return put_out_in_folder(options.to, "trackers", report, study_json(studied.study, options));
}

}  // namespace

void add_study_trackers(app::Commands& commands, app::Command study) {
  auto options = std::make_shared<StudyTrackersOptions>();
  const app::Command command = commands.add_under(
      study, "trackers", "Camera trackers beside ours on one time line: by condition, gaps, lag and error",
      "mien study trackers --out trackers\n  mien study trackers --truth take.mien --curves ours=solved.csv "
      "phone=MySlate_3.csv webcam=scores.jsonl --out trackers",
      [options] { return run_study_trackers(*options); });
  TrackersRequest& request = options->request;
  const app::Option rows = command.add_option(
      "--rows", options->rows,
      "Only these conditions, by name: talking, hand, turned_away, dark, walking, eating, rapid");
  const app::Option performers = command.add_option("--performers", request.performers, "Virtual performers")
                                     .in_range(1, 10000)
                                     .show_default();
  const app::Option seconds =
      command.add_option("--seconds", request.seconds, "Length of each performance after the prologue")
          .number_between(3.0, 3600.0)
          .show_default();
  const app::Option rig = app::add_rig_option(command, options->rig);
  const app::Option live =
      command.add_option("--live", options->live, "The live model (default: models/live.safetensors)");
  const app::Option quick =
      command.add_flag("--quick", options->quick, "Fewer and shorter performances, for a first look");
  const app::Option seed =
      app::add_seed_option(command, request.seed, "Of the performers, their devices and the cameras");
  const app::Option truth = command.add_option(
      "--truth", options->truth,
      "Compare recordings instead: a take with truth, or any curves that are to be the truth");
  const app::Option curves =
      command.add_option("--curves", options->curves,
                         "Trackers' recordings as NAME=FILE: Live Link Face CSVs (`mien "
                         "solve` writes ours so), MediaPipe's scores, "
                         "OpenSeeFace's recordings");
  truth.needs(curves);
  curves.needs(truth);
  for (const app::Option& drawn : {rows, performers, seconds, rig, live, quick, seed}) truth.excludes(drawn);
  command
      .add_option("--offset", options->offsets, "Move recordings later, as NAME=SECONDS; negative is earlier")
      .needs(truth);
  command
      .add_flag(
          "--shared-clock", options->shared_clock,
          "The files' times are of one clock; else each is counted from its first row, and the lag that "
          "is found of it is taken out of its errors, since it has in it when somebody began to record")
      .needs(truth);
  command
      .add_option("--face", options->face, "Face on which the recordings are measured, as mien face takes it")
      .needs(truth)
      .show_default();
  command.add_option("--search", request.compare.search_s, "Seek lags within plus and minus so many seconds")
      .number_between(0.05, 5.0)
      .show_default();
  command
      .add_option("--out", options->to.out,
                  "Folder for trackers.html, trackers.txt and trackers.json; made where it is not")
      .required();
  app::add_json_flag(command, options->to.json);
}

}  // namespace mien::lab
