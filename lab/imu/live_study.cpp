#include "lab/imu/live_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "lab/columns.h"
#include "lab/imu/impair.h"
#include "lab/imu/loss.h"
#include "lab/imu/observed_rotations.h"
#include "lab/imu/sensor_bound.h"
#include "lab/performance_count.h"
#include "mien/core/time.h"
#include "mien/core/units.h"
#include "mien/measure/evaluation.h"
#include "mien/performer/encore.h"
#include "mien/performer/head_motion.h"
#include "mien/performer/performer.h"
#include "mien/performer/script.h"
#include "mien/solve/solve.h"
#include "mien/solve/trace_features.h"
#include "mien/synthetic/imu/watched_person.h"
#include "mien/tracker/causal_tracker.h"
#include "mien/tracker/model_input.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

using Track = std::vector<face::BlendshapeWeights>;

// Placement that training did not have.
constexpr double kUnseenPlacementMm = 5;
constexpr double kUnseenTurnRad = 10 / kDegPerRad;
// Half as wide again as the live recipe draws it (40 %, 18 degrees).
constexpr virt::KinematicsSpread kOtherSkin = {.gain = 0.6, .direction_rad = 27 / kDegPerRad};
constexpr double kBurstPercent = 10;
/// A sensor that is there less often tells the bound nothing.
constexpr double kMostlyThere = 0.5;

/// Who performs, and what he would if nothing befell him.
struct Actor {
  face::Face face;
  std::optional<performer::Style> style;  // Of a virtual one.
  face::Motion motion;
  Random root = Random(0);
};

/// What was heard of a performance.
struct Received {
  std::vector<virt::SkinSite> sites;
  std::vector<model::FeatureFrame> features;
  std::vector<take::TruthFrame> truth;  // One a frame of the features.
};

/// Frames of a session that make a row: [begin, end).
struct Part {
  std::string title;
  std::size_t begin = 0;
  std::size_t end = 0;
};

/// One row of one performer.
struct LiveOutcome {
  std::size_t frames = 0;  // 0: it was not performed.
  ObservedRotations rotations;
  std::vector<Figures> methods;
};

std::optional<LossCondition> loss_of(LiveCondition condition) {
  switch (condition) {
    case LiveCondition::one_lost:
      return LossCondition{Fault::sensors_silent, 1, {}};
    case LiveCondition::three_lost:
      return LossCondition{Fault::sensors_silent, 3, {}};
    case LiveCondition::bursts:
      return LossCondition{Fault::bursts, kBurstPercent, {}};
    default:
      return std::nullopt;
  }
}

/// The motion's first `seconds`; all of it where it is shorter.
face::Motion beginning(face::Motion motion, double seconds) {
  const double end_s = motion.frames.front().time_s + seconds;
  std::erase_if(motion.frames, [end_s](const face::MotionFrame& frame) { return frame.time_s > end_s; });
  return motion;
}

/// The motion `rounds` times, 60 frames a second, with a second between them in which it comes back to its
/// first frame. `round_s` becomes the time from one round's beginning to the next one's.
face::Motion repeated(const face::Motion& motion, int rounds, double& round_s) {
  performer::PrologueMotion whole{.motion = motion, .times = {}};
  const performer::Encore encore = performer::add_encore(whole);
  round_s = encore.end_s - encore.begin_s;
  const face::MotionCurve curve(whole.motion);
  face::Motion out{.name = motion.name, .frames = {}, .has_head = motion.has_head};
  out.head_without_face = motion.head_without_face;
  const auto frames = static_cast<std::int64_t>(std::ceil(rounds * round_s * kFrameRateHz));
  for (std::int64_t f = 0; f < frames; ++f) {
    const double time_s = to_seconds(frame_offset(f));
    out.frames.push_back(encore.at(curve, time_s));
    out.frames.back().time_s = time_s;
  }
  return out;
}

/// What an actor does under a condition; nothing where he cannot. `round_s` is set for a long session.
std::optional<face::Motion> motion_for(LiveCondition condition, const LiveRequest& request,
                                       const Actor& actor, double& round_s) {
  const auto with_head = [&](performer::HeadActivity activity) {
    const std::array episodes = {performer::HeadEpisode{0, activity}};
    return performer::with_head_motion(actor.motion, episodes, actor.root.fork("head activity"));
  };
  const auto played = [&](performer::Block block) {
    return performer::perform(performer::default_script(block, request.seconds), *actor.style,
                              actor.root.fork(performer::block_name(block)));
  };
  switch (condition) {
    case LiveCondition::walking:
      return with_head(performer::HeadActivity::walking);
    case LiveCondition::running:
      return with_head(performer::HeadActivity::running);
    case LiveCondition::eating:
      if (!actor.style) return std::nullopt;
      return played(performer::Block::eating);
    case LiveCondition::rapid:
      return actor.style ? played(performer::Block::rapid) : with_head(performer::HeadActivity::darting);
    case LiveCondition::long_session: {
      const face::Motion round =
          actor.style ? virt::draw_motion(request.round_s, *actor.style, actor.root.fork("long"))
                      : beginning(actor.motion, request.round_s);
      return repeated(round, request.rounds, round_s);
    }
    default:
      return actor.motion;
  }
}

virt::Wearing wearing_of(LiveCondition condition, const LiveRequest& request,
                         const virt::DeviceFaults& faults) {
  virt::Wearing out{.faults = faults};
  if (condition == LiveCondition::lab) out.lab = true;
  if (condition == LiveCondition::unseen) {
    out.faults.mount_position_mm = kUnseenPlacementMm;
    out.turn_rad = kUnseenTurnRad;
  }
  if (condition == LiveCondition::other_simulator) {
    out.faults = request.other_faults;
    out.kinematics = kOtherSkin;
  }
  return out;
}

/// The rows of a condition: all of the session, or the first and the last round of a long one.
std::vector<Part> parts_of(LiveCondition condition, const LiveRequest& request, const Received& received,
                           double round_s) {
  if (condition != LiveCondition::long_session)
    return {{std::string(names_of(condition).title), 0, received.truth.size()}};
  const auto runs = measure::evaluated_runs(received.truth);
  const auto first = runs.empty() ? received.truth.size() : runs.front().first;
  const auto frames = [](double seconds) {
    return static_cast<std::size_t>(std::llround(seconds * kFrameRateHz));
  };
  const auto part = [&](std::string name, std::size_t begin) {
    begin = std::min(begin, received.truth.size());
    return Part{std::string(names_of(condition).title) + name, begin,
                std::min(begin + frames(round_s - 1), received.truth.size())};
  };
  return {part(fmt::format(", first {:g} s", request.round_s), first),
          part(fmt::format(", after {:.0f} s", (request.rounds - 1) * round_s),
               first + frames((request.rounds - 1) * round_s))};
}

Figures figures_of(const measure::Metrics& metrics) {
  return {metrics.pve_mm.mean,
          optional_mean(metrics.pve_face_mm),
          optional_mean(metrics.lmk_mm),
          metrics.mse,
          metrics.mse_observed,
          metrics.jitter_ratio,
          metrics.blink_f1};
}

Figures figures_of(const SensorBound& bound, double prior) {
  double observed_variance = 0;
  double observed = 0;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    if (!measure::counts_in_mse_observed(k)) continue;
    observed_variance += std::pow(prior * bound.left[k], 2);
    ++observed;
  }
  return {bound.pve_mm.mean, optional_mean(bound.pve_face_mm), optional_mean(bound.lmk_mm),
          bound.mse,         observed_variance / observed,     std::nullopt,
          std::nullopt};
}

/// All that is the same for everyone.
struct Setting {
  const LiveRequest& request;
  const sensor::Rig& rig;
  const LiveModels& models;
  virt::DeviceFaults faults;
  std::vector<LiveCondition> conditions;
  std::vector<std::string> methods;  // By name, in the order of LiveOutcome::methods.
};

/// One performer, from the first condition to the last.
class Performing {
 public:
  Performing(const Setting& setting, Actor actor, const PerformanceCount& performances)
      : setting_(setting), actor_(std::move(actor)), meter_(actor_.face), performances_(performances) {}

  /// The condition's rows, and their titles.
  Result<std::vector<std::pair<std::string, LiveOutcome>>> meet(LiveCondition condition) {
    double round_s = 0;
    std::vector<std::pair<std::string, LiveOutcome>> rows;
    MIEN_TRY_ASSIGN(const std::optional<Received> received, receive(condition, round_s));
    if (!received) return rows;
    std::vector<Track> answers;
    for (const LiveModels::Causal& model : setting_.models.causal) {
      MIEN_TRY_ASSIGN(
          answers.emplace_back(),
          synthetic::answers_of(model.file, setting_.rig.face_sensor_names(), received->features));
    }
    for (const Part& part : parts_of(condition, setting_.request, *received, round_s)) {
      MIEN_TRY_ASSIGN(LiveOutcome outcome, measure(condition, *received, part, answers));
      rows.emplace_back(part.title, std::move(outcome));
    }
    return rows;
  }

 private:
  Result<virt::Performance> perform(LiveCondition condition, face::Motion motion) const {
    const Random random = actor_.root.fork(condition == LiveCondition::remount ? "worn anew" : "worn");
    return virt::perform_with(wearing_of(condition, setting_.request, setting_.faults), actor_.face,
                              std::move(motion), setting_.rig, random);
  }

  Result<std::optional<Received>> receive(LiveCondition condition, double& round_s) {
    const std::optional<LossCondition> loss = loss_of(condition);
    std::optional<face::Motion> motion = motion_for(condition, setting_.request, actor_, round_s);
    if (!motion) return std::optional<Received>();
    const bool as_seen = loss || condition == LiveCondition::seen;
    if (as_seen && !seen_) {
      MIEN_TRY_ASSIGN(seen_, perform(LiveCondition::seen, *motion));
    }
    virt::Performance performance;
    if (as_seen) {
      performance = *seen_;
    } else {
      MIEN_TRY_ASSIGN(performance, perform(condition, std::move(*motion)));
    }
    if (loss) {
      const Random random = actor_.root.fork("loss");
      MIEN_TRY_ASSIGN(const Impairment bad,
                      impairment(*loss, setting_.rig, performance.begin_s, performance.end_s, random));
      MIEN_TRY_ASSIGN(performance.session, impair(performance.session, setting_.rig, bad.network,
                                                  random.fork("network"), bad.troubles));
    }
    virt::VirtualSession& session = performance.session;
    MIEN_TRY_ASSIGN(std::vector<model::FeatureFrame> features,
                    solve::trace_features(setting_.rig, session.events, session.entries, session.ticks));
    return Received{std::move(performance.sites), std::move(features), std::move(session.truth)};
  }

  /// The window network on a stretch of features alone: nothing before it matters to it.
  Result<Track> answer(std::span<const model::FeatureFrame> features, std::size_t steps) const {
    const tracker::WindowSolver& window = *setting_.models.window;
    MIEN_TRY_ASSIGN(
        const std::vector<face::OutputFrame> frames,
        window.solve(features, setting_.rig.face_sensor_names(), solve::sampler_of(window.file(), steps),
                     [this](double, std::string_view) { return !performances_.stopped(); }));
    Track out;
    out.reserve(frames.size());
    for (const face::OutputFrame& frame : frames) out.push_back(frame.weights);
    return out;
  }

  Result<LiveOutcome> measure(LiveCondition condition, const Received& received, const Part& part,
                              const std::vector<Track>& answers) const {
    const std::size_t count = part.end - part.begin;
    const auto features = std::span(received.features).subspan(part.begin, count);
    const auto truth = std::span(received.truth).subspan(part.begin, count);
    LiveOutcome out{.rotations = ObservedRotations(setting_.rig)};
    for (const auto& [begin, end] : measure::evaluated_runs(truth))
      for (std::size_t f = begin; f < end; ++f, ++out.frames)
        out.rotations.add(features[f], truth[f].weights, received.sites);
    if (out.frames == 0)
      return fail(ErrorCode::not_found, "no frame of this performance can be evaluated", actor_.motion.name,
                  "give a longer one");
    const auto add = [&](std::span<const face::BlendshapeWeights> track) {
      // A file without a ridge has none to give.
      out.methods.push_back(track.empty() ? Figures{}
                                          : figures_of(measure::measure_track(meter_, truth, track)));
    };
    for (const Track& track : answers) add(std::span(track).subspan(part.begin, count));
    if (setting_.models.window != nullptr)
      for (const std::size_t steps : setting_.models.window_steps) {
        MIEN_TRY_ASSIGN(const Track track, answer(features, steps));
        add(track);
      }
    const model::ModelFile& file = setting_.models.causal.front().file;
    add(tracker::solve_ridge(file, features, setting_.rig.face_sensor_names(),
                             condition == LiveCondition::lab ? "lab" : "device"));
    add(std::span<const face::BlendshapeWeights>(measure::hold_last(received.truth))
            .subspan(part.begin, count));
    face::BlendshapeWeights mean;
    std::ranges::copy(file.mean_pose, mean.values.begin());
    add(Track(count, mean));
    const double variance = *out.methods.back()[static_cast<std::size_t>(Measure::mse)];
    out.methods.push_back(bound(received, out.rotations, variance));
    return out;
  }

  /// What one frame could tell at best by a linear map.
  Figures bound(const Received& received, const ObservedRotations& rotations, double variance) const {
    const std::vector<std::uint16_t> face_sensors = setting_.rig.face_sensors();
    std::vector<virt::SkinSite> sites;
    for (std::size_t i = 0; i < face_sensors.size(); ++i)
      if (rotations.share(i) > kMostlyThere) sites.push_back(received.sites[face_sensors[i]]);
    const double noise_rad = rotations.rms_rad() / std::sqrt(3.0);  // An axis.
    const double prior = std::sqrt(variance);
    if (sites.empty() || !(noise_rad > 0) || !(prior > 0)) return {};
    return figures_of(sensor_bound(meter_, sites, prior, noise_rad, actor_.root.fork("bound")), prior);
  }

  const Setting& setting_;
  Actor actor_;
  measure::Meter meter_;
  const PerformanceCount& performances_;
  std::optional<virt::Performance> seen_;
};

std::vector<std::string> method_names(const LiveModels& models) {
  std::vector<std::string> names;
  for (const LiveModels::Causal& model : models.causal) names.push_back(model.name);
  if (models.window != nullptr)
    for (const std::size_t steps : models.window_steps)
      names.push_back(fmt::format("window, {} step{}", steps, steps == 1 ? "" : "s"));
  for (const std::string_view name : {kRidge, kHoldLast, kMeanPose, kSensorBound}) names.emplace_back(name);
  return names;
}

Actor actor_of(const LiveRequest& request, std::size_t index) {
  const auto performers = static_cast<std::size_t>(std::max(0, request.performers));
  Actor out;
  if (index < performers) {
    out.root = Random(request.seed).fork("live study", index);
    virt::VirtualPerson person = virt::draw_person(out.root);
    out.motion = virt::draw_motion(request.seconds, person.style, out.root);
    out.face = std::move(person.face);
    out.style = std::move(person.style);
    return out;
  }
  const virt::GivenMotion& given = request.motions[index - performers];
  out.root = Random(request.seed).fork("live study, given", index - performers);
  out.face = request.faces[given.face];
  out.motion = given.motion;
  if (request.given_seconds > 0) out.motion = beginning(std::move(out.motion), request.given_seconds);
  if (!out.motion.has_head) out.motion = performer::with_head_motion(out.motion, out.root.fork("head"));
  return out;
}

/// Nobody to perform, or with what?
Result<void> check(const LiveRequest& request, const sensor::Rig& rig, const LiveModels& models) {
  if (models.causal.empty())
    return fail(ErrorCode::bad_usage, "there is no causal model to study", "live study");
  for (const LiveModels::Causal& model : models.causal) {
    const auto made = tracker::CausalTracker::create(model.file, rig.face_sensor_names());
    if (!made) return std::unexpected(made.error());
  }
  if (request.performers < 1 && request.motions.empty())
    return fail(ErrorCode::bad_usage, "nobody performs", "live study");
  for (const virt::GivenMotion& given : request.motions)
    if (given.face >= request.faces.size() || given.motion.frames.empty())
      return fail(ErrorCode::bad_usage, "the motion has no frames, or no face to be played on",
                  given.motion.name);
  return {};
}

/// Of one person and one condition: rows by title.
using Met = std::vector<std::pair<std::string, LiveOutcome>>;

/// Rows of the people from `begin` to `end`.
LiveSet pooled_methods(const Setting& setting, std::string who, const std::vector<std::vector<Met>>& met,
                       std::size_t begin, std::size_t end) {
  LiveSet set{std::move(who), {}};
  for (std::size_t c = 0; c < setting.conditions.size(); ++c) {
    std::size_t rows = 0;
    for (std::size_t p = begin; p < end; ++p) rows = std::max(rows, met[p][c].size());
    for (std::size_t r = 0; r < rows; ++r) {
      LiveRow row{.condition = setting.conditions[c]};
      for (const std::string& name : setting.methods) row.methods.push_back({name, {}});
      ObservedRotations rotations(setting.rig);
      for (std::size_t p = begin; p < end; ++p) {
        if (met[p][c].size() <= r) continue;
        const auto& [title, outcome] = met[p][c][r];
        row.title = title;
        row.frames += outcome.frames;
        rotations.add(outcome.rotations);
        for (std::size_t m = 0; m < row.methods.size(); ++m)
          row.methods[m].performers.push_back(outcome.methods[m]);
      }
      row.observed = rotations.share();
      row.rotation_rms_deg = kDegPerRad * rotations.rms_rad();
      set.rows.push_back(std::move(row));
    }
  }
  return set;
}

}  // namespace

Result<LiveCondition> parse_live_condition(std::string_view name) {
  std::vector<std::string_view> known;
  for (std::size_t c = 0; c < kLiveConditionCount; ++c) {
    if (kLiveConditions[c].name == name) return static_cast<LiveCondition>(c);
    known.push_back(kLiveConditions[c].name);
  }
  return fail(ErrorCode::not_found, fmt::format("the study has no rows '{}'", name), {},
              fmt::format("take some of: {}", fmt::join(known, ", ")));
}

std::vector<LiveCondition> live_conditions(const sensor::Rig& rig) {
  std::vector<LiveCondition> out;
  for (std::size_t c = 0; c < kLiveConditionCount; ++c) {
    const auto condition = static_cast<LiveCondition>(c);
    const std::optional<LossCondition> loss = loss_of(condition);
    const bool silent = loss && loss->fault == Fault::sensors_silent;
    if (!silent || static_cast<double>(rig.face_sensors().size()) > loss->amount) out.push_back(condition);
  }
  return out;
}

std::optional<measure::MeanStd> LiveMethod::over(Measure measure) const {
  std::vector<double> values;
  for (const Figures& figures : performers)
    if (const auto& value = figures[static_cast<std::size_t>(measure)]) values.push_back(*value);
  if (values.empty()) return std::nullopt;
  measure::MeanStd out;
  for (const double value : values) out.mean += value / static_cast<double>(values.size());
  if (values.size() < 2) return out;
  double squares = 0;
  for (const double value : values) squares += std::pow(value - out.mean, 2);
  out.std = std::sqrt(squares / static_cast<double>(values.size() - 1));
  return out;
}

const LiveMethod* LiveRow::find(std::string_view method) const {
  const auto found = std::ranges::find(methods, method, &LiveMethod::name);
  return found == methods.end() ? nullptr : &*found;
}

Result<LiveStudy> study_live(const LiveRequest& request, const sensor::Rig& rig, const LiveModels& models,
                             const Progress& progress) {
  MIEN_TRY(check(request, rig, models));
  Setting setting{request, rig, models, {}, request.conditions, method_names(models)};
  if (setting.conditions.empty()) setting.conditions = live_conditions(rig);
  MIEN_TRY_ASSIGN(setting.faults, virt::parse_faults(rig.faults_toml, rig.name));
  const auto performers = static_cast<std::size_t>(std::max(0, request.performers));
  const std::size_t count = performers + request.motions.size();

  std::vector<std::vector<Met>> met(count, std::vector<Met>(setting.conditions.size()));
  PerformanceCount performances(progress, count * setting.conditions.size());
  const Progress counted = performances.progress();
  MIEN_TRY(virt::for_each_performer(count, request.threads, counted, [&](std::size_t p) -> Result<void> {
    Performing performing(setting, actor_of(request, p), performances);
    for (std::size_t c = 0; c < setting.conditions.size(); ++c) {
      if (Result<void> on = performances.go_on(); !on) return on;
      MIEN_TRY_ASSIGN(met[p][c], performing.meet(setting.conditions[c]));
      performances.count();
    }
    return {};
  }));

  LiveStudy study;
  if (performers > 0)
    study.sets.push_back(pooled_methods(
        setting,
        fmt::format("{} virtual performer{} of the built-in family", performers, performers == 1 ? "" : "s"),
        met, 0, performers));
  if (!request.motions.empty())
    study.sets.push_back(pooled_methods(setting, request.motions_are, met, performers, count));
  return study;
}

}  // namespace mien::lab
