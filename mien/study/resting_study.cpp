#include "mien/study/resting_study.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "mien/core/random.h"
#include "mien/measure/metrics.h"
#include "mien/performer/performer.h"
#include "mien/performer/script.h"
#include "mien/performer/style.h"
#include "mien/shaping/shaper.h"
#include "mien/study/performers.h"

namespace mien::study {
namespace {

using face::BlendshapeWeights;
using face::shape;
using performer::Block;
using shaping::RestingFace;
using shaping::RestingRule;

constexpr std::array kScripts = {Block::expressions, Block::reading, Block::acted};
constexpr std::size_t kRestingKinds = kRestingKindNames.size();
constexpr double kLearnt_s = 30;
constexpr float kAtRest = 0.02F;
constexpr float kActive = 0.3F;

/// How a tracker reads one wearer.
struct Reading {
  RestingFace rest;  // Read of the face at rest, and of lids that are closed.
  std::array<float, face::kShapeCount> gain{};
};

void rest_both(RestingFace& face, std::size_t left, double rest) {
  face.rest.at(left) = face.rest.at(left + 1) = static_cast<float>(std::clamp(rest, 0.0, 0.5));
}

Reading draw_reading(RestingKind kind, Random random) {
  Reading out;
  for (float& gain : out.gain) gain = static_cast<float>(random.normal(1, 0.1));
  const std::array raisers = {shape("browInnerUp_L"), shape("browOuterUp_L")};
  const auto closed = static_cast<float>(random.uniform(0.8, 1));
  if (kind == RestingKind::narrow) rest_both(out.rest, shape("eyeBlink_L"), random.normal(0.3, 0.03));
  if (kind == RestingKind::raised)
    for (const std::size_t brow : raisers) rest_both(out.rest, brow, random.normal(0.25, 0.03));
  if (kind == RestingKind::of_several) {
    rest_both(out.rest, shape("eyeBlink_L"), random.uniform(0.1, 0.4));
    if (random.chance(0.5))
      for (const std::size_t brow : raisers) rest_both(out.rest, brow, random.uniform(0.1, 0.3));
    else
      rest_both(out.rest, shape("browDown_L"), random.uniform(0.1, 0.3));
    rest_both(out.rest, random.chance(0.5) ? shape("mouthSmile_L") : shape("mouthFrown_L"),
              random.uniform(0.05, 0.25));
  }
  if (kind != RestingKind::usual)
    out.rest.full[shape("eyeBlink_L")] = out.rest.full[shape("eyeBlink_R")] = closed;
  return out;
}

BlendshapeWeights read(const BlendshapeWeights& truth, const Reading& reading, Random& noise) {
  BlendshapeWeights out;
  for (std::size_t i = 0; i < face::kShapeCount; ++i) {
    const float rest = reading.rest.rest[i];
    const float w = rest + (reading.rest.full[i] - rest) * reading.gain[i] * truth[i];
    out[i] = std::clamp(w + static_cast<float>(noise.normal(0, 0.01)), 0.0F, 1.0F);
  }
  return out;
}

/// The streaming calibration alone: what else a shaper does is the same with it and without.
class Step {
 public:
  Step() { resting_.set(true); }
  BlendshapeWeights apply(const BlendshapeWeights& weights) {
    face::OutputFrame frame;
    frame.time = DeviceTime(frame_offset(index_++));
    frame.weights = weights;
    frame.confidence.fill(0.9F);
    frame.provenance.fill(face::Provenance::measured);
    resting_.apply(frame);
    return frame.weights;
  }

 private:
  shaping::Resting resting_;
  std::int64_t index_ = 0;
};

struct Mean {
  double sum = 0;
  double count = 0;
  void add(double value) {
    sum += value;
    ++count;
  }
  void add(const Mean& other) {
    sum += other.sum;
    count += other.count;
  }
  [[nodiscard]] double value() const { return count > 0 ? sum / count : 0; }
};

/// One side of every figure.
struct Side {
  Mean resting, active, all, wide;
  void add(const Side& other) {
    resting.add(other.resting);
    active.add(other.active);
    all.add(other.all);
    wide.add(other.wide);
  }
};

struct Worn {
  Side before, after;
  Mean wide_truth;
  std::array<Mean, 12> curve;
  std::vector<BlendshapeWeights> truth, plain, stepped;  // From 30 s on.
};

void count(Side& side, float truth, float weight, bool is_wide) {
  if (truth <= kAtRest) side.resting.add(weight);
  if (truth >= kActive) side.active.add(std::abs(weight - truth));
  if (truth >= kActive && is_wide) side.wide.add(weight);
  side.all.add(std::abs(weight - truth));
}

Worn watch(RestingKind kind, Block script, double seconds, const Random& person) {
  Random drawn = person.fork("style");
  performer::Style style = performer::draw_style(drawn);
  style.rest = {};  // What rests otherwise is the tracker's reading.
  const face::Motion motion =
      performer::perform(performer::default_script(script, seconds), style, person.fork("motion"));
  const Reading reading = draw_reading(kind, person.fork("reading"));
  Random noise = person.fork("noise");
  Step step;
  Worn out;
  for (std::size_t n = 0; n < motion.frames.size(); ++n) {
    BlendshapeWeights truth = motion.frames[n].weights;
    for (float& w : truth.values) w = std::clamp(w, 0.0F, 1.0F);
    const BlendshapeWeights plain = read(truth, reading, noise);
    const BlendshapeWeights stepped = step.apply(plain);
    const double time_s = static_cast<double>(n) / kFrameRateHz;
    for (std::size_t i = 0; i < face::kShapeCount; ++i) {
      if (shaping::kRestingRules[i] == RestingRule::none) continue;
      const bool is_wide = i == shape("eyeWide_L") || i == shape("eyeWide_R");
      const bool counts = kind == RestingKind::usual || reading.rest.rest[i] > 0;
      if (counts && time_s < 60 && truth[i] <= kAtRest)
        out.curve.at(static_cast<std::size_t>(time_s / 5)).add(stepped[i]);
      if (time_s < kLearnt_s) continue;
      if (is_wide && truth[i] >= kActive) {
        out.wide_truth.add(truth[i]);
        out.before.wide.add(plain[i]);
        out.after.wide.add(stepped[i]);
      }
      if (!counts) continue;
      count(out.before, truth[i], plain[i], false);
      count(out.after, truth[i], stepped[i], false);
    }
    if (time_s < kLearnt_s) continue;
    out.truth.push_back(truth);
    out.plain.push_back(plain);
    out.stepped.push_back(stepped);
  }
  return out;
}

RestingResult summary(RestingKind kind, Block script, std::span<const Worn> wearers) {
  RestingResult out{.kind = kind, .script = performer::block_name(script)};
  Side before, after;
  Mean wide_truth;
  std::array<Mean, 12> curve;
  std::vector<measure::Stretch> plain, stepped;
  for (const Worn& wearer : wearers) {
    before.add(wearer.before);
    after.add(wearer.after);
    wide_truth.add(wearer.wide_truth);
    for (std::size_t k = 0; k < curve.size(); ++k) curve[k].add(wearer.curve[k]);
    plain.push_back({.truth = wearer.truth, .estimate = wearer.plain});
    stepped.push_back({.truth = wearer.truth, .estimate = wearer.stepped});
  }
  out.resting = {before.resting.value(), after.resting.value()};
  out.active = {before.active.value(), after.active.value()};
  out.all = {before.all.value(), after.all.value()};
  if (wide_truth.sum > 0) out.wide = {before.wide.sum / wide_truth.sum, after.wide.sum / wide_truth.sum};
  for (std::size_t k = 0; k < curve.size(); ++k) out.curve[k] = curve[k].value();
  const auto f1_plain = measure::blink_f1(plain);
  const auto f1_stepped = measure::blink_f1(stepped);
  if (f1_plain && f1_stepped) out.blink_f1 = {*f1_plain, *f1_stepped};
  return out;
}

LongSmile smile_for_40_s(float smile) {
  LongSmile out{.smile = smile, .shown = {}};
  Step step;
  for (int n = 0; n < 120 * 60; ++n) {
    BlendshapeWeights weights;
    if (n >= 20 * 60 && n < 60 * 60) weights[shape("mouthSmile_L")] = smile;
    const BlendshapeWeights shown = step.apply(weights);
    if ((n + 1) % 300 == 0) out.shown.push_back(shown[shape("mouthSmile_L")]);
  }
  return out;
}

}  // namespace

Result<RestingStudy> study_resting(const RestingRequest& request, const Progress& progress) {
  if (request.wearers < 3 || !(request.seconds > 60))
    return fail(ErrorCode::bad_usage, "too few wearers or too short a performance", "study resting",
                "ask for 3 wearers and more than 60 seconds");
  const auto people = static_cast<std::size_t>(request.wearers) / 3;
  std::vector<Worn> watched(kScripts.size() * kRestingKinds * people);
  MIEN_TRY(for_each_performer(watched.size(), request.threads, progress, [&](std::size_t n) -> Result<void> {
    const std::size_t kind = n / people % kRestingKinds;
    const Random person = Random(request.seed).fork("wearer", kind * people + n % people);
    watched[n] =
        watch(static_cast<RestingKind>(kind), kScripts[n / people / kRestingKinds], request.seconds, person);
    return {};
  }));
  RestingStudy out;
  for (std::size_t n = 0; n < watched.size(); n += people)
    out.results.push_back(summary(static_cast<RestingKind>(n / people % kRestingKinds),
                                  kScripts[n / people / kRestingKinds],
                                  std::span(watched).subspan(n, people)));
  for (const float smile : {0.25F, 0.4F, 0.8F}) out.smiles.push_back(smile_for_40_s(smile));
  return out;
}

std::vector<BeforeAfter> rests_of(const face::Motion& motion) {
  const face::MotionCurve curve(motion);
  Step step;
  std::array<std::vector<float>, face::kShapeCount> before, after;
  const auto frames = static_cast<std::size_t>(curve.duration_s() * kFrameRateHz);
  for (std::size_t n = 0; n < frames; ++n) {
    const double time_s = static_cast<double>(n) / kFrameRateHz;
    const face::MotionFrame frame = curve.at(time_s);
    if (!frame.has_face) continue;
    const BlendshapeWeights stepped = step.apply(frame.weights);
    if (time_s < kLearnt_s) continue;
    for (std::size_t i = 0; i < face::kShapeCount; ++i) {
      before[i].push_back(frame.weights[i]);
      after[i].push_back(stepped[i]);
    }
  }
  const auto third = [](std::vector<float>& values) -> double {
    if (values.empty()) return 0;
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 3);
    std::nth_element(values.begin(), at, values.end());
    return *at;
  };
  std::vector<BeforeAfter> out(face::kShapeCount);
  for (std::size_t i = 0; i < face::kShapeCount; ++i) out[i] = {third(before[i]), third(after[i])};
  return out;
}

}  // namespace mien::study
