#include "lab/imu/loss.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "lab/imu/impair.h"
#include "lab/imu/observed_rotations.h"
#include "lab/performance_count.h"
#include "mien/core/draw_first.h"
#include "mien/core/units.h"
#include "mien/measure/evaluation.h"
#include "mien/shaping/shaper.h"
#include "mien/solve/trace_features.h"
#include "mien/tracker/causal_tracker.h"
#include "mien/virtual/imu/device_faults.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

constexpr double kBurstLength = 10;       // Packets: a sixth of a second.
constexpr double kDisorderJitterMs = 20;  // Even, up to twice it; packets are 17 ms apart.
constexpr double kClockStepUs = 500;
constexpr double kClockStepEveryS = 10;
constexpr double kForever = std::numeric_limits<double>::infinity();

/// The face sensors in a random order: those that are in trouble first, so that three silent sensors are the
/// two and one more.
std::vector<std::uint16_t> drawn_sensors(const sensor::Rig& rig, Random random) {
  std::vector<std::uint16_t> sensors = rig.face_sensors();
  draw_first(std::span(sensors), sensors.size(), random);
  return sensors;
}

/// A performance, on whose face it was.
struct Played {
  face::Face face;
  virt::Performance performance;
  Random random = Random(0);  // Of what befalls it.
};

/// How one condition went for one performance.
struct LossOutcome {
  measure::Metrics metrics;
  double mean_pose_mse = 0;  // Of the first condition alone.
  ObservedRotations rotations;
  double largest_step = 0;
  double truth_step = 0;
  std::size_t unsound = 0;
  std::size_t mistold = 0;
};

Result<Played> perform_one(const LossRequest& request, const sensor::Rig& rig,
                           const virt::DeviceFaults& faults, std::size_t index) {
  const Random root = Random(request.seed).fork("loss", index);
  Played out;
  face::Motion motion;
  if (request.motions.empty()) {
    virt::VirtualPerson person = virt::draw_person(root);
    out.face = std::move(person.face);
    motion = virt::draw_motion(request.seconds, person.style, root);
  } else {
    const virt::GivenMotion& given = request.motions[index];
    if (given.face >= request.faces.size())
      return fail(ErrorCode::bad_usage, "the motion has no face to be played on", given.motion.name);
    out.face = request.faces[given.face];
    motion = given.motion;
  }
  MIEN_TRY_ASSIGN(out.performance,
                  virt::perform_with({.faults = faults}, out.face, std::move(motion), rig, root));
  out.random = root.fork("faults");
  return out;
}

/// What the tracker answers, and what a session shows of it.
struct Answer {
  std::vector<face::BlendshapeWeights> weights;
  std::vector<face::BlendshapeWeights> shown;
};

/// Steps the tracker through the features, and looks at what every frame says of itself.
Answer answer(const std::vector<model::FeatureFrame>& features, tracker::CausalTracker& tracker,
              LossOutcome& outcome) {
  Answer out;
  out.weights.reserve(features.size());
  out.shown.reserve(features.size());
  face::OutputFrame frame;
  shaping::Shaper shaper({.blinks_per_min = 0});
  tracker.reset();
  for (const model::FeatureFrame& feature : features) {
    tracker.step(feature, frame);
    out.weights.push_back(frame.weights);
    const auto sound = [](float w) { return w >= 0 && w <= 1; };  // What is not finite is neither.
    if (!std::ranges::all_of(frame.weights.values, sound)) ++outcome.unsound;
    const auto observed = std::ranges::count_if(feature.sensors, &model::SensorFeature::has_rotation);
    const bool measured = std::ranges::count(frame.provenance, face::Provenance::measured) > 0;
    if (measured && observed == 0) ++outcome.mistold;
    shaper.apply(frame, static_cast<std::size_t>(observed));
    out.shown.push_back(frame.weights);
  }
  return out;
}

double largest_step(const std::vector<measure::Stretch>& stretches,
                    std::span<const face::BlendshapeWeights> measure::Stretch::*track) {
  float largest = 0;
  for (const measure::Stretch& stretch : stretches) {
    const std::span<const face::BlendshapeWeights> frames = stretch.*track;
    for (std::size_t f = 1; f < frames.size(); ++f)
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        largest = std::max(largest, std::abs(std::clamp(frames[f][k], 0.0F, 1.0F) -
                                             std::clamp(frames[f - 1][k], 0.0F, 1.0F)));
  }
  return largest;
}

Result<LossOutcome> run_condition(const LossCondition& condition, const sensor::Rig& rig,
                                  const Played& played, const measure::Meter& meter,
                                  tracker::CausalTracker& tracker) {
  const virt::Performance& performance = played.performance;
  MIEN_TRY_ASSIGN(const Impairment bad,
                  impairment(condition, rig, performance.begin_s, performance.end_s, played.random));
  MIEN_TRY_ASSIGN(const virt::VirtualSession received,
                  impair(performance.session, rig, bad.network, played.random.fork("network"), bad.troubles));
  MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> features,
                  solve::trace_features(rig, received.events, received.entries, received.ticks));
  LossOutcome out{.rotations = ObservedRotations(rig)};
  const Answer answered = answer(features, tracker, out);
  std::vector<face::BlendshapeWeights> truth;
  truth.reserve(received.truth.size());
  for (const take::TruthFrame& frame : received.truth) truth.push_back(frame.weights);

  std::vector<measure::Stretch> stretches, shown;
  for (const auto& [begin, end] : measure::evaluated_runs(received.truth)) {
    const auto run = [&](const std::vector<face::BlendshapeWeights>& track) {
      return std::span(track).subspan(begin, end - begin);
    };
    stretches.push_back({run(truth), run(answered.weights)});
    shown.push_back({run(truth), run(answered.shown)});
    for (std::size_t f = begin; f < end; ++f) out.rotations.add(features[f], truth[f], performance.sites);
  }
  out.metrics = meter.measure(stretches);
  out.largest_step = largest_step(shown, &measure::Stretch::estimate);
  out.truth_step = largest_step(stretches, &measure::Stretch::truth);
  if (condition.fault == Fault::none) {
    face::BlendshapeWeights mean;
    std::ranges::copy(tracker.file().mean_pose, mean.values.begin());
    const std::vector<face::BlendshapeWeights> still(truth.size(), mean);
    for (measure::Stretch& stretch : stretches)
      stretch.estimate = std::span(still).first(stretch.truth.size());
    out.mean_pose_mse = meter.measure(stretches).mse;
  }
  return out;
}

/// One condition over all performances, each frame counting alike.
LossRow pooled(const LossCondition& condition, const sensor::Rig& rig,
               const std::vector<LossOutcome>& outcomes) {
  LossRow row{.condition = condition};
  ObservedRotations rotations(rig);
  for (const LossOutcome& one : outcomes) {
    const auto frames = static_cast<double>(one.metrics.frames);
    row.frames += one.metrics.frames;
    row.mse += frames * one.metrics.mse;
    row.mse_observed += frames * one.metrics.mse_observed;
    row.pve_mm += frames * one.metrics.pve_mm.mean;
    rotations.add(one.rotations);
    row.largest_step = std::max(row.largest_step, one.largest_step);
    row.truth_step = std::max(row.truth_step, one.truth_step);
    row.unsound += one.unsound;
    row.mistold += one.mistold;
    row.performance_mse.push_back(one.metrics.mse);
  }
  const double all = std::max(1.0, static_cast<double>(row.frames));
  for (double* mean : {&row.mse, &row.mse_observed, &row.pve_mm}) *mean /= all;
  row.observed = rotations.share();
  row.rotation_rms_deg = kDegPerRad * rotations.rms_rad();
  return row;
}

std::string percent(double share) {
  return fmt::format("{:+.1f} %", 100 * share);
}

std::string allowed(double rise) {
  return fmt::format("at most {} is promised", percent(rise));
}

/// Error against the share that was lost, beginning with the clean condition.
measure::Line curve(const LossStudy& study, Fault fault, const std::string& name) {
  measure::Line line{name, {0}, {study.rows.front().mse}};
  for (const LossRow& row : study.rows)
    if (row.condition.fault == fault) {
      line.x.push_back(row.condition.amount);
      line.y.push_back(row.mse);
    }
  return line;
}

measure::LinePlot curves(const LossStudy& study) {
  measure::LinePlot plot;
  plot.title = "Weight error against lost packets";
  plot.x_label = "packets lost beyond the rig's own (%)";
  plot.y_label = "MSE";
  plot.lines = {curve(study, Fault::loss, "each by itself"),
                curve(study, Fault::bursts, "in bursts of ten packets")};
  double most = 0;
  for (const measure::Line& line : plot.lines) most = std::max(most, line.x.back());
  const double promised = (1 + kRiseAllowedAt10Percent) * study.rows.front().mse;
  plot.lines.push_back({"promised at 10 %", {0, most}, {promised, promised}});
  plot.lines.push_back({"mean pose", {0, most}, {study.mean_pose_mse, study.mean_pose_mse}});
  return plot;
}

measure::BarPlot sensors(const LossStudy& study) {
  measure::BarPlot plot;
  plot.title = "Weight error without one sensor";
  plot.value_label = "MSE";
  plot.series = {"MSE"};
  plot.groups.push_back({"all there", {study.rows.front().mse}, {}});
  for (const LossRow& row : study.rows)
    if (row.condition.fault == Fault::sensor_silent)
      plot.groups.push_back({row.condition.sensor, {row.mse}, {}});
  return plot;
}

}  // namespace

std::string LossCondition::name() const {
  switch (fault) {
    case Fault::none:
      return "clean";
    case Fault::loss:
      return fmt::format("{:g} % lost", amount);
    case Fault::bursts:
      return fmt::format("{:g} % lost in bursts", amount);
    case Fault::jitter:
      return fmt::format("jitter {:g} ms", amount);
    case Fault::even_jitter:
      return fmt::format("jitter 0 to {:g} ms", amount);
    case Fault::lag:
      return fmt::format("lag {:g} ms", amount);
    case Fault::disorder:
      return fmt::format("{:g} % twice, out of order", amount);
    case Fault::clock_drift:
      return fmt::format("clocks {:g} ppm off, stepped", amount);
    case Fault::restart:
      return "one restarts half-way";
    case Fault::shared_id:
      return "two with one id, nobody chooses";
    case Fault::sensor_silent:
      return "without " + sensor;
    case Fault::sensors_silent:
      return fmt::format("without {:g} at once", amount);
    case Fault::head_silent:
      return fmt::format("head's silent for {:g} s", amount);
    case Fault::corrupted:
      return fmt::format("{:g} % corrupted", amount);
    case Fault::truncated:
      return fmt::format("{:g} % cut short", amount);
    case Fault::frozen:
      return fmt::format("{:g} frozen", amount);
    case Fault::all_silent:
      return fmt::format("all silent for {:g} s", amount);
  }
  return {};
}

std::vector<LossCondition> loss_conditions(const sensor::Rig& rig) {
  std::vector<LossCondition> out;
  for (const double percent : {2.0, 5.0, 10.0, 20.0}) out.push_back({Fault::loss, percent, {}});
  for (const double percent : {2.0, 5.0, 10.0, 20.0}) out.push_back({Fault::bursts, percent, {}});
  for (const double ms : {20.0, 50.0, 100.0}) out.push_back({Fault::jitter, ms, {}});
  out.push_back({Fault::even_jitter, 100, {}});
  out.push_back({Fault::lag, 100, {}});
  out.push_back({Fault::disorder, 20, {}});
  out.push_back({Fault::clock_drift, 50, {}});
  const std::vector<std::string> sensors = rig.face_sensor_names();
  if (!sensors.empty()) out.push_back({Fault::restart, 0, {}});
  if (sensors.size() > 1) out.push_back({Fault::shared_id, 0, {}});
  if (rig.head_sensor()) out.push_back({Fault::head_silent, 2, {}});
  for (const std::string& sensor : sensors) out.push_back({Fault::sensor_silent, 0, sensor});
  for (const double count : {2.0, 3.0})
    if (static_cast<double>(sensors.size()) > count) out.push_back({Fault::sensors_silent, count, {}});
  return out;
}

Result<Impairment> impairment(const LossCondition& condition, const sensor::Rig& rig, double begin_s,
                              double end_s, const Random& random) {
  const std::vector<std::uint16_t> drawn = drawn_sensors(rig, random.fork("sensors"));
  const double middle_s = 0.5 * (begin_s + end_s);
  const std::size_t needed = condition.fault == Fault::restart     ? 1
                             : condition.fault == Fault::shared_id ? 2
                             : condition.fault == Fault::sensors_silent || condition.fault == Fault::frozen
                                 ? std::max(0.0, condition.amount)
                                 : 0;
  if (needed > drawn.size())
    return fail(ErrorCode::not_found, "the rig has too few face sensors for: " + condition.name(), rig.name);
  Impairment out;
  switch (condition.fault) {
    case Fault::none:
      break;
    case Fault::loss:
      out.network.loss = 0.01 * condition.amount;
      break;
    case Fault::bursts:
      out.network.burst_share = 0.01 * condition.amount;
      out.network.burst_length = kBurstLength;
      break;
    case Fault::jitter:
      out.network.jitter_ms = condition.amount;
      break;
    case Fault::even_jitter:
      out.network.jitter_ms = 0.5 * condition.amount;
      out.network.jitter = virt::NetworkSettings::Jitter::uniform;
      break;
    case Fault::lag:
      out.network.lag_ms = condition.amount;
      break;
    case Fault::disorder:
      out.network.duplicated = 0.01 * condition.amount;
      out.network.jitter_ms = kDisorderJitterMs;
      out.network.jitter = virt::NetworkSettings::Jitter::uniform;
      break;
    case Fault::clock_drift:
      for (std::size_t s = 0; s < rig.sensors.size(); ++s) {
        Random clock = random.fork("clock", s);
        const double fast = clock.chance(0.5) ? 1 : -1;
        const double ahead = clock.chance(0.5) ? 1 : -1;
        out.troubles.clocks.push_back(
            {static_cast<std::uint16_t>(s), fast * condition.amount, ahead * kClockStepUs, kClockStepEveryS});
      }
      break;
    case Fault::restart:
      out.troubles.restarts.push_back({.sensor = drawn[0], .at_s = middle_s});
      break;
    case Fault::shared_id:
      out.troubles.shared_ids.push_back({.sensor = drawn[0], .as = drawn[1]});
      break;
    case Fault::sensor_silent: {
      const auto sensor = rig.find(condition.sensor);
      if (!sensor) return fail(ErrorCode::not_found, "the rig has no sensor " + condition.sensor, rig.name);
      out.troubles.silences.push_back({*sensor, 0, kForever});
      break;
    }
    case Fault::sensors_silent:
      for (std::size_t i = 0; i < needed; ++i) out.troubles.silences.push_back({drawn[i], 0, kForever});
      break;
    case Fault::head_silent: {
      const auto sensor = rig.head_sensor();
      if (!sensor) return fail(ErrorCode::not_found, "the rig has no sensor for the head", rig.name);
      out.troubles.silences.push_back({*sensor, middle_s, middle_s + condition.amount});
      break;
    }
    case Fault::corrupted:
      out.network.corrupted = 0.01 * condition.amount;
      break;
    case Fault::truncated:
      out.network.truncated = 0.01 * condition.amount;
      break;
    case Fault::frozen:
      for (std::size_t i = 0; i < needed; ++i) out.troubles.frozen.push_back({drawn[i], begin_s, end_s});
      break;
    case Fault::all_silent:
      out.troubles.silences.push_back({std::nullopt, middle_s, middle_s + condition.amount});
      break;
  }
  return out;
}

const LossRow* LossStudy::find(Fault fault, double amount) const {
  for (const LossRow& row : rows)
    if (row.condition.fault == fault && row.condition.amount == amount) return &row;
  return nullptr;
}

const LossRow* LossStudy::worst_sensor() const {
  // An error that is no number is worse than any.
  const auto worse = [](const LossRow& one, const LossRow& other) {
    return !std::isnan(other.rise) && !(one.rise <= other.rise);
  };
  const LossRow* worst = nullptr;
  for (const LossRow& row : rows)
    if (row.condition.fault == Fault::sensor_silent && (worst == nullptr || worse(row, *worst))) worst = &row;
  return worst;
}

std::size_t LossStudy::unsound() const {
  std::size_t sum = 0;
  for (const LossRow& row : rows) sum += row.unsound;
  return sum;
}

std::size_t LossStudy::mistold() const {
  std::size_t sum = 0;
  for (const LossRow& row : rows) sum += row.mistold;
  return sum;
}

bool LossStudy::kept() const {
  const LossRow* tenth = find(Fault::loss, 10);
  const LossRow* worst = worst_sensor();
  // Written so that an error that is no number keeps nothing.
  return unsound() == 0 && mistold() == 0 && (tenth == nullptr || tenth->rise <= kRiseAllowedAt10Percent) &&
         (worst == nullptr || worst->rise <= kRiseAllowedWithoutASensor);
}

Result<LossStudy> study_loss(const LossRequest& request, const sensor::Rig& rig,
                             const model::ModelFile& model, const std::vector<LossCondition>& conditions,
                             const Progress& progress) {
  MIEN_TRY_ASSIGN(const virt::DeviceFaults faults, virt::parse_faults(rig.faults_toml, rig.name));
  // Before long work: whether the model is one for this.
  MIEN_TRY(tracker::CausalTracker::create(model, rig.face_sensor_names()));
  std::vector<LossCondition> all = {{}};
  all.insert(all.end(), conditions.begin(), conditions.end());
  const std::size_t count = request.motions.empty()
                                ? static_cast<std::size_t>(std::max(request.performers, 1))
                                : request.motions.size();

  std::vector<std::vector<LossOutcome>> outcomes(
      all.size(), std::vector<LossOutcome>(count, LossOutcome{.rotations = ObservedRotations(rig)}));
  PerformanceCount performances(progress, count * all.size());
  const Progress counted = performances.progress();
  MIEN_TRY(virt::for_each_performer(count, request.threads, counted, [&](std::size_t p) -> Result<void> {
    MIEN_TRY_ASSIGN(const Played played, perform_one(request, rig, faults, p));
    MIEN_TRY_ASSIGN(tracker::CausalTracker tracker,
                    tracker::CausalTracker::create(model, rig.face_sensor_names()));
    const measure::Meter meter(played.face);
    for (std::size_t c = 0; c < all.size(); ++c) {
      if (Result<void> on = performances.go_on(); !on) return on;
      MIEN_TRY_ASSIGN(outcomes[c][p], run_condition(all[c], rig, played, meter, tracker));
      performances.count();
    }
    return {};
  }));

  LossStudy study;
  for (std::size_t c = 0; c < all.size(); ++c) study.rows.push_back(pooled(all[c], rig, outcomes[c]));
  const LossRow& clean = study.rows.front();
  if (clean.frames == 0)
    return fail(ErrorCode::not_found, "no frame of these performances can be evaluated", rig.name);
  for (const LossOutcome& one : outcomes.front())
    study.mean_pose_mse += one.mean_pose_mse * static_cast<double>(one.metrics.frames);
  study.mean_pose_mse /= static_cast<double>(clean.frames);
  const double clean_mse = clean.mse;
  const double known = study.mean_pose_mse - clean_mse;
  for (LossRow& row : study.rows) {
    row.rise = row.mse / clean_mse - 1;
    row.given_up = known > 0 ? (row.mse - clean_mse) / known : 0;
  }
  return study;
}

const Columns<LossRow>& loss_columns() {
  static const Columns<LossRow> columns = {
      {"condition", "", "{}", [](const LossRow& row) { return row.condition.name(); }},
      {"frames", "", "", &LossRow::frames},
      {"mse", "MSE", "{:.5f}", &LossRow::mse},
      {"rise", "rise, %", "{:+.1f}", &LossRow::rise, 100},
      {"given_up", "given up, %", "{:+.1f}", &LossRow::given_up, 100},
      {"mse_observed", "MSE of 42", "{:.5f}", &LossRow::mse_observed},
      {"pve_mm", "PVE, mm", "{:.3f}", &LossRow::pve_mm},
      {"observed", "observed, %", "{:.1f}", &LossRow::observed, 100},
      {"rotation_rms_deg", "rotation, °", "{:.1f}", &LossRow::rotation_rms_deg},
      {"largest_step", "largest step", "{:.3f}", &LossRow::largest_step},
      {"truth_step", "truth's", "{:.3f}", &LossRow::truth_step},
      {"unsound_frames", "unsound", "{}", &LossRow::unsound},
      {"mistold_frames", "mistold", "{}", &LossRow::mistold},
      {"performance_mse", "", "", &LossRow::performance_mse}};
  return columns;
}

measure::Report loss_report(const LossStudy& study, const std::string& subtitle) {
  measure::Report report("Accuracy against loss", subtitle);
  const LossRow& clean = study.rows.front();
  std::vector<measure::KeyFigure> figures = {{"Weight MSE, clean", fmt::format("{:.5f}", clean.mse),
                                              fmt::format("mean pose {:.5f}", study.mean_pose_mse)}};
  if (const LossRow* tenth = study.find(Fault::loss, 10))
    figures.push_back({"With 10 % lost", percent(tenth->rise), allowed(kRiseAllowedAt10Percent)});
  if (const LossRow* worst = study.worst_sensor())
    figures.push_back({"Without " + worst->condition.sensor + ", the worst to lose", percent(worst->rise),
                       allowed(kRiseAllowedWithoutASensor)});
  figures.push_back({"Promises", study.kept() ? "kept" : "not kept", ""});
  figures.push_back({"Frames not sound", fmt::format("{}", study.unsound() + study.mistold()), "of all"});
  report.key_figures(figures);
  report.plot(curves(study));
  if (study.worst_sensor() != nullptr) report.bars(sensors(study));
  measure::Table table = table_of("Every condition, on the same performances", study.rows, loss_columns());
  table.strong_rows = {0};
  report.table(table);
  report.text(
      "Each condition is the same performances heard through a worse network or from devices in trouble, the "
      "prologue too. The rig's own faults, lost packets among them, are there in every one, also in the "
      "clean. Rise is of the MSE, against clean. Given up is the share gone of what the model knows, by "
      "which "
      "it beats the mean pose when all is well: 100 is as good as knowing nothing. Felt is the share of the "
      "face sensors' rotations that the model was given; rotation is how far these are off, RMS. Largest "
      "step is "
      "the largest change of any weight from one frame to the next, beside the truth's own. Unsound are "
      "frames with a weight that is no number or outside 0 to 1; mistold are frames that say measured where "
      "no sensor was there, or do not where all were. MSE and PVE: docs/reference/metrics.md.");
  return report;
}

}  // namespace mien::lab
