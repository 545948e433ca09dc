#include "lab/trackers/trackers_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "lab/interval.h"
#include "lab/performance_count.h"
#include "mien/core/excerpt.h"
#include "mien/core/median.h"
#include "mien/core/minimum_jerk.h"
#include "mien/core/nearest_word.h"
#include "mien/core/time.h"
#include "mien/core/units.h"
#include "mien/measure/evaluation.h"
#include "mien/performer/head_motion.h"
#include "mien/performer/performer.h"
#include "mien/performer/script.h"
#include "mien/solve/trace_features.h"
#include "mien/synthetic/imu/watched_person.h"
#include "mien/tracker/causal_tracker.h"
#include "mien/virtual/imu/device_faults.h"
#include "mien/virtual/performance.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

constexpr std::array<std::string_view, kTrackerMeasureCount> kTrackerMeasureNames = {
    "pve_seen_mm",       "pve_without_lag_mm", "pve_held_mm",     "pve_whole_mm", "pve_face_held_mm",
    "landmarks_held_mm", "mse_seen",           "mse_without_lag", "mse_held",     "mse_common",
    "mse_whole",         "gap_share",          "lag_ms",          "lag_sigma_ms"};
/// Seconds over which the worst moment is sought, and that are kept each way.
constexpr double kMoment_s = 1, kMomentEachWay_s = 2.5;

std::vector<double> values_of(const std::vector<TrackerFigures>& performers, TrackerMeasure measure) {
  std::vector<double> out;
  for (const TrackerFigures& figures : performers)
    if (const auto& value = figures[static_cast<std::size_t>(measure)]) out.push_back(*value);
  return out;
}

double frame_rate(const std::vector<double>& time_s) {
  if (time_s.size() < 2) return 60;
  std::vector<double> steps;
  for (std::size_t i = 1; i < time_s.size(); ++i) steps.push_back(time_s[i] - time_s[i - 1]);
  return 1 / upper_median(std::move(steps));
}

constexpr double kShortestPerformance_s = 3;

struct ConditionWords {
  std::string_view name, title, what;
};
constexpr std::array<ConditionWords, kTrackerConditionCount> kConditionWords = {{
    {"talking", "talking", "Reading aloud, the face before the camera."},
    {"hand", "hand before the face",
     "As talking, a hand before the mouth for one to three seconds at a time. It touches no sensor, so our "
     "curves are those of talking "
     "by construction."},
    {"turned_away", "turned away", "As talking, the head 45 to 80 degrees aside half of the time."},
    {"dark", "dark",
     "As talking, without light. No sensor needs any, so our curves are those of talking by construction."},
    {"walking", "walking", "As talking, walking throughout, the camera held in the hand before the face."},
    {"eating", "eating", "A meal: hand and cup hide the mouth, and touch no sensor."},
    {"rapid", "rapid motion", "The fastest motions of faces, and a head that darts aside."},
}};

const ConditionWords& words_of(TrackerCondition condition) {
  return kConditionWords[static_cast<std::size_t>(condition)];
}

/// Which condition's performance a condition shares.
TrackerCondition performed_as(TrackerCondition condition) {
  const bool as_talking = condition == TrackerCondition::hand || condition == TrackerCondition::dark;
  return as_talking ? TrackerCondition::talking : condition;
}

/// A performance, and what the sensors made of it.
struct FeltPerformance {
  face::Motion motion;  // As the camera sees it, on its own time.
  TrackerCurves truth;  // One row a tick that counts.
  TrackerCurves own;
};

/// All that is the same for everyone.
struct TrackersSetting {
  const TrackersRequest& request;
  const sensor::Rig& rig;
  const model::ModelFile& model;
  virt::DeviceFaults faults;
  std::vector<TrackerCondition> conditions;
};

/// One performer, from the first condition to the last.
class WatchedByCameras {
 public:
  WatchedByCameras(const TrackersSetting& setting, std::size_t index)
      : setting_(setting),
        root_(Random(setting.request.seed).fork("trackers study", index)),
        person_(virt::draw_person(root_)),
        meter_(person_.face) {}

  Result<CurveComparison> meet(TrackerCondition condition) {
    const TrackerCondition performed = performed_as(condition);
    auto felt = felt_.find(performed);
    if (felt == felt_.end()) {
      MIEN_TRY_ASSIGN(FeltPerformance made, perform(performed));
      felt = felt_.emplace(performed, std::move(made)).first;
    }
    const FeltPerformance& performance = felt->second;
    TrackerScene scene{.motion = &performance.motion, .hands = {}};
    if (condition == TrackerCondition::hand)
      scene.hands = draw_hands(setting_.request.seconds, root_.fork("hands"));
    if (condition == TrackerCondition::eating) scene.hands = eating_hands(performance.motion);
    scene.dark = condition == TrackerCondition::dark;
    scene.held_in_hand = condition == TrackerCondition::walking;
    std::vector<TrackerCurves> all = {performance.own};
    for (const ModelledTracker& tracker : modelled_trackers())
      all.push_back(
          model_tracker(tracker, scene, root_.fork("camera", static_cast<std::uint64_t>(tracker.kind))));
    return compare_curves(meter_, performance.truth, all, setting_.request.compare);
  }

 private:
  face::Motion motion_for(TrackerCondition condition) const {
    const auto played = [&](performer::Block block) {
      return performer::perform(performer::default_script(block, setting_.request.seconds), person_.style,
                                root_.fork(performer::block_name(block)));
    };
    switch (condition) {
      case TrackerCondition::turned_away:
        return with_head_turned_away(played(performer::Block::reading), root_.fork("turned away"));
      case TrackerCondition::walking: {
        const std::array episodes = {performer::HeadEpisode{0, performer::HeadActivity::walking}};
        return performer::with_head_motion(played(performer::Block::reading), episodes,
                                           root_.fork("walking"));
      }
      case TrackerCondition::eating:
        return played(performer::Block::eating);
      case TrackerCondition::rapid:
        return played(performer::Block::rapid);
      default:
        return played(performer::Block::reading);
    }
  }

  Result<FeltPerformance> perform(TrackerCondition condition) const {
    FeltPerformance out;
    out.motion = motion_for(condition);
    // The camera must see the same head as the sensors feel.
    if (!out.motion.has_head) out.motion = performer::with_head_motion(out.motion, root_.fork("head"));
    // Skin as unlike the standard one's as that of whom live models learn from: each by an even share.
    Random unlike = root_.fork("unlike");
    const virt::Wearing wearing{.faults = setting_.faults,
                                .kinematics = virt::KinematicsSpread().times(unlike.uniform())};
    MIEN_TRY_ASSIGN(const virt::Performance performance,
                    virt::perform_with(wearing, person_.face, out.motion, setting_.rig, root_.fork("worn")));
    const virt::VirtualSession& session = performance.session;
    MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> features,
                    solve::trace_features(setting_.rig, session.events, session.entries, session.ticks));
    const auto motion_time = [&](const take::TruthFrame& frame) {
      return to_seconds(frame.time - session.motion_start);
    };
    out.truth.name = "truth";
    out.truth.told.set();
    for (const auto& [begin, end] : measure::evaluated_runs(session.truth))
      for (std::size_t f = begin; f < end; ++f)
        out.truth.rows.push_back({motion_time(session.truth[f]), session.truth[f].weights});
    out.own.name = kOwnCurves;
    out.own.told.set();
    MIEN_TRY_ASSIGN(const std::vector<face::BlendshapeWeights> answers,
                    synthetic::answers_of(setting_.model, setting_.rig.face_sensor_names(), features));
    for (std::size_t f = 0; f < answers.size(); ++f)
      out.own.rows.push_back({motion_time(session.truth[f]), answers[f]});
    return out;
  }

  const TrackersSetting& setting_;
  Random root_;
  virt::VirtualPerson person_;
  measure::Meter meter_;
  std::map<TrackerCondition, FeltPerformance> felt_;
};

/// What is kept of one performer under one condition.
struct MetCameras {
  std::size_t frames = 0;
  std::size_t common = 0;
  std::vector<std::string> names;
  std::vector<ToldShapes> told;
  std::vector<TrackerFigures> figures;
  TrackerMoment moment;
};

MetCameras kept_of(const CurveComparison& comparison, std::size_t performer) {
  MetCameras out;
  out.frames = comparison.time_s.size();
  out.common = comparison.common.count();
  for (const CurveScore& score : comparison.scores) {
    out.names.push_back(score.name);
    out.told.push_back(score.told_shapes);
    out.figures.push_back(figures_of(score));
  }
  out.moment = worst_moment(comparison, kOwnCurves);
  out.moment.performer = performer;
  return out;
}

TrackersRow condition_row(TrackerCondition condition, std::size_t at,
                          const std::vector<std::vector<MetCameras>>& met) {
  const ConditionWords& words = words_of(condition);
  TrackersRow row;
  row.key = words.name;
  row.title = words.title;
  row.what = words.what;
  row.frames_hz = kFrameRateHz;
  for (const std::vector<MetCameras>& performer : met) {
    const MetCameras& one = performer[at];
    row.frames += one.frames;
    row.common = one.common;
    for (std::size_t m = 0; m < one.names.size(); ++m) {
      if (row.methods.size() == m) row.methods.push_back({one.names[m], one.told[m].count(), {}});
      row.methods[m].performers.push_back(one.figures[m]);
    }
    row.keep_worst(one.moment);
  }
  return row;
}

Result<void> check_trackers_request(const TrackersRequest& request, const sensor::Rig& rig,
                                    const model::ModelFile& model) {
  if (request.performers < 1) return fail(ErrorCode::bad_usage, "nobody performs", "trackers study");
  if (!(request.seconds >= kShortestPerformance_s))
    return fail(ErrorCode::bad_usage,
                fmt::format("a performance is at least {} s long", kShortestPerformance_s), "trackers study");
  const auto made = tracker::CausalTracker::create(model, rig.face_sensor_names());
  if (!made) return std::unexpected(made.error());
  return {};
}

}  // namespace

std::string_view tracker_measure_name(TrackerMeasure measure) {
  return kTrackerMeasureNames[static_cast<std::size_t>(measure)];
}

TrackerFigures figures_of(const CurveScore& score) {
  TrackerFigures out;
  const auto put = [&out](TrackerMeasure measure, std::optional<double> value) {
    out[static_cast<std::size_t>(measure)] = value;
  };
  if (score.as_told) {
    put(TrackerMeasure::pve_seen, score.as_told->pve_mm);
    put(TrackerMeasure::mse_seen, score.as_told->mse_told);
  }
  if (score.without_lag) {
    put(TrackerMeasure::pve_without_lag, score.without_lag->pve_mm);
    put(TrackerMeasure::mse_without_lag, score.without_lag->mse_told);
  }
  if (!score.offset_unknown) {
    put(TrackerMeasure::pve_held, score.held.pve_mm);
    put(TrackerMeasure::pve_whole, score.pve_whole_mm);
    put(TrackerMeasure::pve_face_held, score.held.pve_face_mm);
    put(TrackerMeasure::landmarks_held, score.held.landmarks_mm);
    put(TrackerMeasure::mse_held, score.held.mse_told);
    put(TrackerMeasure::mse_common, score.held.mse_common);
    put(TrackerMeasure::mse_whole, score.mse_whole);
  }
  put(TrackerMeasure::gap_share, score.gap_share);
  if (score.lag) {
    put(TrackerMeasure::lag, 1e3 * score.lag->lag_s);
    put(TrackerMeasure::lag_sigma, 1e3 * score.lag->sigma_s);
  }
  return out;
}

std::optional<TrackerMean> mean_over_performers(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  const Interval of = mean_interval({values});
  TrackerMean out{.mean = of.mean, .performers = values.size(), .interval = {}};
  if (values.size() > 1) out.interval = {of.low, of.high};
  return out;
}

std::optional<TrackerMean> TrackerMethod::over(TrackerMeasure measure) const {
  return mean_over_performers(values_of(performers, measure));
}

std::optional<TrackerMean> TrackerMethod::above(const TrackerMethod& other, TrackerMeasure measure) const {
  std::vector<double> differences;
  for (std::size_t p = 0; p < std::min(performers.size(), other.performers.size()); ++p) {
    const auto& own = performers[p][static_cast<std::size_t>(measure)];
    const auto& its = other.performers[p][static_cast<std::size_t>(measure)];
    if (own && its) differences.push_back(*own - *its);
  }
  return mean_over_performers(differences);
}

TrackerMoment worst_moment(const CurveComparison& comparison, std::string_view reference) {
  TrackerMoment out;
  const std::vector<double>& time_s = comparison.time_s;
  if (time_s.empty()) return out;
  const auto beside = std::ranges::find(comparison.scores, reference, &CurveScore::name);
  for (const CurveScore& score : comparison.scores) {
    if (score.offset_unknown) continue;
    if (beside != comparison.scores.end() && score.name == beside->name && comparison.scores.size() > 1)
      continue;
    // A window that slides over the time: what comes in at its end leaves at its beginning.
    double own = 0, its = 0;
    std::size_t begin = 0;
    for (std::size_t end = 0; end < time_s.size(); ++end) {
      own += score.pve_mm[end];
      if (beside != comparison.scores.end()) its += beside->pve_mm[end];
      for (; time_s[end] - time_s[begin] > kMoment_s; ++begin) {
        own -= score.pve_mm[begin];
        if (beside != comparison.scores.end()) its -= beside->pve_mm[begin];
      }
      const auto count = static_cast<double>(end - begin + 1);
      const bool whole = time_s[end] - time_s[begin] > 0.9 * kMoment_s || end + 1 == time_s.size();
      if (!whole || (!out.worst.empty() && (own - its) / count <= out.above_mm)) continue;
      out.above_mm = (own - its) / count;
      out.worst_s = 0.5 * (time_s[begin] + time_s[end]);
      out.pve_mm = own / count;
      out.worst = score.name;
    }
  }
  if (out.worst.empty()) return out;
  std::vector<std::size_t> kept;
  for (std::size_t f = 0; f < time_s.size(); ++f)
    if (std::abs(time_s[f] - out.worst_s) <= kMomentEachWay_s) kept.push_back(f);
  for (const std::size_t f : kept) {
    out.time_s.push_back(time_s[f]);
    out.truth.push_back(comparison.truth[f]);
  }
  for (const CurveScore& score : comparison.scores) {
    TrackerMoment::Line& line = out.lines.emplace_back();
    line.name = score.name;
    line.told = score.told_shapes;
    for (const std::size_t f : kept) {
      line.shown.push_back(score.shown[f]);
      line.saw.push_back(score.saw[f]);
    }
  }
  return out;
}

const TrackerMethod* TrackersRow::find(std::string_view method) const {
  const auto found = std::ranges::find(methods, method, &TrackerMethod::name);
  return found == methods.end() ? nullptr : &*found;
}

void TrackersRow::keep_worst(TrackerMoment other) {
  if (other.worst.empty() || (moment && other.above_mm <= moment->above_mm)) return;
  moment = std::move(other);
}

TrackersStudy study_of(const CurveComparison& comparison, std::string title) {
  TrackersStudy out;
  out.shared_clock = comparison.shared_clock;
  for (const CurveScore& score : comparison.scores)
    if (score.offset_unknown) out.offset_unknown.push_back(score.name);
  TrackersRow& row = out.rows.emplace_back();
  row.key = "recording";
  row.title = std::move(title);
  row.frames = comparison.time_s.size();
  row.frames_hz = frame_rate(comparison.time_s);
  row.common = comparison.common.count();
  for (const CurveScore& score : comparison.scores)
    row.methods.push_back({score.name, score.told_shapes.count(), {figures_of(score)}});
  row.keep_worst(worst_moment(comparison, {}));
  return out;
}

std::string_view tracker_condition_name(TrackerCondition condition) {
  return words_of(condition).name;
}

Result<TrackerCondition> parse_tracker_condition(std::string_view name) {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < kTrackerConditionCount; ++c) {
    names.emplace_back(kConditionWords[c].name);
    if (names.back() == name) return static_cast<TrackerCondition>(c);
  }
  return fail(ErrorCode::not_found, fmt::format("the study has no rows '{}'", excerpt(name)), {},
              fmt::format("take some of: {}{}", fmt::join(names, ", "), did_you_mean(name, names)));
}

face::Motion with_head_turned_away(face::Motion motion, Random random) {
  constexpr double kTurn_s = 0.6;
  struct Turn {
    double begin_s, end_s, yaw_rad;
  };
  std::vector<Turn> turns;
  const double from_s = motion.frames.empty() ? 0 : motion.frames.front().time_s;
  double now_s = from_s + random.uniform(1, 2);
  while (now_s < from_s + motion.duration_s()) {
    const double away_s = random.uniform(2, 4) + 2 * kTurn_s;
    const double side = random.chance(0.5) ? 1 : -1;
    turns.push_back({now_s, now_s + away_s, side * random.uniform(45, 80) * kRadPerDeg});
    now_s += away_s + random.uniform(2, 3);
  }
  motion.has_head = true;
  std::size_t t = 0;
  for (face::MotionFrame& frame : motion.frames) {
    while (t < turns.size() && frame.time_s > turns[t].end_s) ++t;
    if (t == turns.size()) break;
    const double share = minimum_jerk((frame.time_s - turns[t].begin_s) / kTurn_s) *
                         minimum_jerk((turns[t].end_s - frame.time_s) / kTurn_s);
    const Quat before = frame.head;
    frame.head = Quat(performer::head_orientation({0, share * turns[t].yaw_rad, 0}) * before).normalized();
    frame.head_position_m +=
        performer::neck_displacement_m(frame.head) - performer::neck_displacement_m(before);
  }
  return motion;
}

Result<TrackersStudy> study_trackers(const TrackersRequest& request, const sensor::Rig& rig,
                                     const model::ModelFile& model, const Progress& progress) {
  MIEN_TRY(check_trackers_request(request, rig, model));
  TrackersSetting setting{request, rig, model, {}, request.conditions};
  for (std::size_t c = 0; request.conditions.empty() && c < kTrackerConditionCount; ++c)
    setting.conditions.push_back(static_cast<TrackerCondition>(c));
  MIEN_TRY_ASSIGN(setting.faults, virt::parse_faults(rig.faults_toml, rig.name));
  const auto count = static_cast<std::size_t>(request.performers);
  std::vector<std::vector<MetCameras>> met(count, std::vector<MetCameras>(setting.conditions.size()));
  PerformanceCount performances(progress, count * setting.conditions.size());
  const Progress counted = performances.progress();
  MIEN_TRY(virt::for_each_performer(count, request.threads, counted, [&](std::size_t p) -> Result<void> {
    WatchedByCameras watched(setting, p);
    for (std::size_t c = 0; c < setting.conditions.size(); ++c) {
      if (Result<void> on = performances.go_on(); !on) return on;
      MIEN_TRY_ASSIGN(const CurveComparison comparison, watched.meet(setting.conditions[c]));
      met[p][c] = kept_of(comparison, p);
      performances.count();
    }
    return {};
  }));
  TrackersStudy study;
  study.reference = kOwnCurves;
  study.modelled = true;
  for (std::size_t c = 0; c < setting.conditions.size(); ++c)
    study.rows.push_back(condition_row(setting.conditions[c], c, met));
  return study;
}

}  // namespace mien::lab
