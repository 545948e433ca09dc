#include "mien/study/loss.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "mien/face/builtin.h"
#include "mien/shaping/shaper.h"
#include "mien/study/evaluation.h"
#include "mien/study/performers.h"
#include "mien/study/trace_features.h"
#include "mien/tracker/causal_tracker.h"
#include "mien/virtual/device_faults.h"
#include "mien/virtual/head_motion.h"
#include "mien/virtual/impair.h"
#include "mien/virtual/performer.h"
#include "mien/virtual/script.h"
#include "mien/virtual/session.h"
#include "mien/virtual/skin_site.h"
#include "mien/virtual/style.h"

namespace mien::study {
namespace {

constexpr double kBurstLength = 10;       // Packets: a sixth of a second.
constexpr double kDisorderJitterMs = 20;  // Even, up to twice it; packets are 17 ms apart.
constexpr double kClockStepUs = 500;
constexpr double kClockStepEveryS = 10;
constexpr double kDegPerRad = 180 / std::numbers::pi;
constexpr double kForever = std::numeric_limits<double>::infinity();

/// What one performer does, on whose face, and what the devices sent.
struct Performance {
  face::Face face;
  std::vector<virt::SkinSite> sites;  // Of the rig's sensors.
  virt::VirtualSession session;
  double begin_s = 0;  // Of the motion, after the prologue.
  double end_s = 0;
  Random random = Random(0);  // Of what befalls it.
};

/// How one condition went for one performance.
struct Outcome {
  Metrics metrics;
  double mean_pose_mse = 0;  // Of the first condition alone.
  double asked = 0;          // Rotations of face sensors that there could have been, and that there were.
  double felt = 0;
  double rotation_squares = 0;  // Of their errors, rad^2.
  double largest_step = 0;
  double truth_step = 0;
  std::size_t unsound = 0;
  std::size_t mistold = 0;
};

/// What a condition asks of the network and the devices.
struct Impairment {
  virt::NetworkSettings network;
  virt::DeviceTroubles troubles;
};

/// The face sensors in a random order: those that are in trouble first, so that three silent sensors are the
/// two and one more.
std::vector<std::uint16_t> drawn_sensors(const sensor::Rig& rig, Random random) {
  std::vector<std::uint16_t> sensors = rig.face_sensors();
  for (std::size_t i = 0; i + 1 < sensors.size(); ++i)
    std::swap(sensors[i], sensors[i + random.below(sensors.size() - i)]);
  return sensors;
}

Result<Impairment> impairment(const LossCondition& condition, const sensor::Rig& rig,
                              const Performance& performance) {
  const std::vector<std::uint16_t> drawn = drawn_sensors(rig, performance.random.fork("sensors"));
  const double middle_s = 0.5 * (performance.begin_s + performance.end_s);
  const std::size_t needed = condition.fault == Fault::restart          ? 1
                             : condition.fault == Fault::shared_id      ? 2
                             : condition.fault == Fault::sensors_silent ? std::max(0.0, condition.amount)
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
        Random random = performance.random.fork("clock", s);
        const double fast = random.chance(0.5) ? 1 : -1;
        const double ahead = random.chance(0.5) ? 1 : -1;
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
  }
  return out;
}

Result<Performance> perform_one(const LossRequest& request, const sensor::Rig& rig,
                                const virt::DeviceFaults& faults, std::size_t index) {
  const Random root = Random(request.seed).fork("loss", index);
  Performance out;
  face::Motion motion;
  if (request.motions.empty()) {
    Random identity = root.fork("identity"), style_random = root.fork("style"),
           script_random = root.fork("script");
    out.face = face::make_builtin(face::random_identity(identity));
    const virt::Style style = virt::draw_style(style_random);
    motion = virt::perform(virt::random_script(request.seconds, script_random), style, root.fork("motion"));
  } else {
    const GivenMotion& given = request.motions[index];
    if (given.face >= request.faces.size())
      return fail(ErrorCode::bad_usage, "the motion has no face to be played on", given.motion.name);
    out.face = request.faces[given.face];
    motion = given.motion;
    if (!motion.has_head) motion = virt::with_head_motion(motion, root.fork("head"));
  }
  const std::vector<Vec3> placement_m =
      virt::draw_placement(rig, 1e-3 * faults.mount_position_mm, root.fork("placement"));
  MIEN_TRY_ASSIGN(out.sites, virt::skin_sites(out.face, rig, placement_m));
  const virt::PrologueMotion begun =
      virt::with_prologue(motion, virt::PrologueKind::brief, root.fork("prologue"));
  MIEN_TRY_ASSIGN(out.session, virt::play_devices(begun, out.sites, rig, faults, root.fork("devices")));
  out.begin_s = begun.times.motion_start_s;
  out.end_s = begun.motion.duration_s();
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
              Outcome& outcome) {
  Answer out;
  out.weights.reserve(features.size());
  out.shown.reserve(features.size());
  face::OutputFrame frame;
  shaping::Shaper shaper;
  tracker.reset();
  for (const model::FeatureFrame& feature : features) {
    tracker.step(feature, frame);
    out.weights.push_back(frame.weights);
    const auto sound = [](float w) { return w >= 0 && w <= 1; };  // What is not finite is neither.
    if (!std::ranges::all_of(frame.weights.values, sound)) ++outcome.unsound;
    const auto felt = std::ranges::count_if(feature.sensors, &model::SensorFeature::has_rotation);
    const bool measured = frame.provenance.front() == face::Provenance::measured;
    if (measured ? felt == 0 : felt == std::ssize(feature.sensors)) ++outcome.mistold;
    shaper.apply(frame, static_cast<std::size_t>(felt));
    out.shown.push_back(frame.weights);
  }
  return out;
}

/// How many rotations there are in a frame, and how right they are.
void look_at_rotations(const model::FeatureFrame& features, const face::BlendshapeWeights& truth,
                       const sensor::Rig& rig, const Performance& performance, Outcome& outcome) {
  const std::vector<std::uint16_t> face_sensors = rig.face_sensors();
  outcome.asked += static_cast<double>(face_sensors.size());
  for (std::size_t i = 0; i < face_sensors.size(); ++i) {
    const model::SensorFeature& sensor = features.sensors[i];
    if (!sensor.has_rotation) continue;
    const auto& [w, x, y, z] = sensor.rotation;
    const Quat skin = performance.sites[face_sensors[i]].rotation(truth);
    outcome.rotation_squares += log_rotation(Quat(w, x, y, z) * skin.conjugate()).squaredNorm();
    ++outcome.felt;
  }
}

double largest_step(const std::vector<Stretch>& stretches,
                    std::span<const face::BlendshapeWeights> Stretch::*track) {
  float largest = 0;
  for (const Stretch& stretch : stretches) {
    const std::span<const face::BlendshapeWeights> frames = stretch.*track;
    for (std::size_t f = 1; f < frames.size(); ++f)
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        largest = std::max(largest, std::abs(std::clamp(frames[f][k], 0.0F, 1.0F) -
                                             std::clamp(frames[f - 1][k], 0.0F, 1.0F)));
  }
  return largest;
}

Result<Outcome> hear_one(const LossCondition& condition, const sensor::Rig& rig,
                         const Performance& performance, const Meter& meter,
                         tracker::CausalTracker& tracker) {
  MIEN_TRY_ASSIGN(const Impairment bad, impairment(condition, rig, performance));
  MIEN_TRY_ASSIGN(
      const virt::VirtualSession heard,
      virt::impair(performance.session, rig, bad.network, performance.random.fork("network"), bad.troubles));
  const std::vector<model::FeatureFrame> features =
      trace_features(rig, heard.events, heard.samples, heard.ticks);
  Outcome out;
  const Answer answered = answer(features, tracker, out);
  std::vector<face::BlendshapeWeights> truth;
  truth.reserve(heard.truth.size());
  for (const take::TruthFrame& frame : heard.truth) truth.push_back(frame.weights);

  std::vector<Stretch> stretches, shown;
  for (const auto& [begin, end] : evaluated_runs(heard.truth)) {
    const auto run = [&](const std::vector<face::BlendshapeWeights>& track) {
      return std::span(track).subspan(begin, end - begin);
    };
    stretches.push_back({run(truth), run(answered.weights)});
    shown.push_back({run(truth), run(answered.shown)});
    for (std::size_t f = begin; f < end; ++f) look_at_rotations(features[f], truth[f], rig, performance, out);
  }
  out.metrics = meter.measure(stretches);
  out.largest_step = largest_step(shown, &Stretch::estimate);
  out.truth_step = largest_step(stretches, &Stretch::truth);
  if (condition.fault == Fault::none) {
    face::BlendshapeWeights mean;
    std::ranges::copy(tracker.file().mean_pose, mean.values.begin());
    const std::vector<face::BlendshapeWeights> still(truth.size(), mean);
    for (Stretch& stretch : stretches) stretch.estimate = std::span(still).first(stretch.truth.size());
    out.mean_pose_mse = meter.measure(stretches).mse;
  }
  return out;
}

/// One condition over all performances, each frame counting alike.
LossRow pooled(const LossCondition& condition, const std::vector<Outcome>& outcomes) {
  LossRow row{.condition = condition};
  double asked = 0, felt = 0, rotation_squares = 0;
  for (const Outcome& one : outcomes) {
    const auto frames = static_cast<double>(one.metrics.frames);
    row.frames += one.metrics.frames;
    row.mse += frames * one.metrics.mse;
    row.mse_felt += frames * one.metrics.mse_felt;
    row.pve_mm += frames * one.metrics.pve_mm.mean;
    asked += one.asked;
    felt += one.felt;
    rotation_squares += one.rotation_squares;
    row.largest_step = std::max(row.largest_step, one.largest_step);
    row.truth_step = std::max(row.truth_step, one.truth_step);
    row.unsound += one.unsound;
    row.mistold += one.mistold;
    row.performance_mse.push_back(one.metrics.mse);
  }
  const double all = std::max(1.0, static_cast<double>(row.frames));
  for (double* mean : {&row.mse, &row.mse_felt, &row.pve_mm}) *mean /= all;
  row.felt = felt / std::max(1.0, asked);
  row.rotation_rms_deg = kDegPerRad * std::sqrt(rotation_squares / std::max(1.0, felt));
  return row;
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
    case Fault::lag:
      return fmt::format("lag {:g} ms", amount);
    case Fault::disorder:
      return fmt::format("{:g} % twice, out of order", amount);
    case Fault::clock_drift:
      return fmt::format("clocks {:g} ppm off, stepped", amount);
    case Fault::restart:
      return "one restarts half-way";
    case Fault::shared_id:
      return "two with one id, both heard";
    case Fault::sensor_silent:
      return "without " + sensor;
    case Fault::sensors_silent:
      return fmt::format("without {:g} at once", amount);
    case Fault::head_silent:
      return fmt::format("head's silent for {:g} s", amount);
  }
  return {};
}

std::vector<LossCondition> loss_conditions(const sensor::Rig& rig) {
  std::vector<LossCondition> out;
  for (const double percent : {2.0, 5.0, 10.0, 20.0}) out.push_back({Fault::loss, percent, {}});
  for (const double percent : {2.0, 5.0, 10.0}) out.push_back({Fault::bursts, percent, {}});
  for (const double ms : {20.0, 50.0, 100.0}) out.push_back({Fault::jitter, ms, {}});
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

  std::vector<std::vector<Outcome>> outcomes(all.size(), std::vector<Outcome>(count));
  std::atomic<std::size_t> done = 0;
  std::atomic<bool> stop = false;
  // A performance takes long, so its conditions are what is counted.
  const Progress by_condition = [&](double, std::string_view) {
    const std::size_t whole = count * all.size();
    if (!progress(static_cast<double>(done) / static_cast<double>(whole),
                  fmt::format("{} of {} performances heard", done.load(), whole)))
      stop = true;
    return !stop;
  };
  MIEN_TRY(for_each_performer(count, request.threads, by_condition, [&](std::size_t p) -> Result<void> {
    MIEN_TRY_ASSIGN(const Performance performance, perform_one(request, rig, faults, p));
    MIEN_TRY_ASSIGN(tracker::CausalTracker tracker,
                    tracker::CausalTracker::create(model, rig.face_sensor_names()));
    const Meter meter(performance.face);
    for (std::size_t c = 0; c < all.size(); ++c) {
      if (stop) return fail(ErrorCode::cancelled, "stopped before all performances were heard");
      MIEN_TRY_ASSIGN(outcomes[c][p], hear_one(all[c], rig, performance, meter, tracker));
      ++done;
    }
    return {};
  }));

  LossStudy study;
  for (std::size_t c = 0; c < all.size(); ++c) study.rows.push_back(pooled(all[c], outcomes[c]));
  const LossRow& clean = study.rows.front();
  if (clean.frames == 0)
    return fail(ErrorCode::not_found, "no frame of these performances can be evaluated", rig.name);
  for (const Outcome& one : outcomes.front())
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

}  // namespace mien::study
