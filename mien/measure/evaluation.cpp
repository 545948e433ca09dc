#include "mien/measure/evaluation.h"

#include <fmt/format.h>

#include <algorithm>

namespace mien::measure {
namespace {

constexpr std::size_t kHoldFrames = 60;  // hold_last: the truth one second ago.

/// The errors in which `baseline` is closer to the truth than `model`, with both values.
std::vector<std::string> errors_ahead(const Metrics& baseline, const Metrics& model) {
  std::vector<std::string> errors;
  const auto compare = [&](const char* name, double theirs, double ours, int decimals, const char* unit) {
    const std::string their_text = fmt::format("{:.{}f}", theirs, decimals),
                      our_text = fmt::format("{:.{}f}", ours, decimals);
    // What is printed as the same is.
    if (theirs < ours && their_text != our_text)
      errors.push_back(fmt::format("{} {} against {}{}", name, their_text, our_text, unit));
  };
  compare("PVE", baseline.pve_mm.mean, model.pve_mm.mean, 3, " mm");
  if (baseline.lmk_mm && model.lmk_mm)
    compare("landmarks", baseline.lmk_mm->mean, model.lmk_mm->mean, 3, " mm");
  compare("MSE", baseline.mse, model.mse, 4, "");
  compare("MSE of 42", baseline.mse_observed, model.mse_observed, 4, "");
  return errors;
}

/// Over the evaluated frames of all takes; absent where a take does not say it of every tick.
std::optional<ProvenanceShares> provenance_shares(const std::vector<TakeEstimates>& takes) {
  ProvenanceShares shares{};
  double frames = 0;
  for (const TakeEstimates& take : takes) {
    if (take.provenance.size() != take.truth.size()) return std::nullopt;
    for (const auto& [begin, end] : evaluated_runs(take.truth))
      for (std::size_t i = begin; i < end; ++i, ++frames)
        for (std::size_t k = 0; k < face::kShapeCount; ++k)
          ++shares[k][static_cast<std::size_t>(take.provenance[i][k])];
  }
  for (auto& shape : shares)
    for (double& share : shape) share /= std::max(1.0, frames);
  return shares;
}

using Track = std::vector<face::BlendshapeWeights>;

Track truth_of(std::span<const take::TruthFrame> frames) {
  Track truth;
  truth.reserve(frames.size());
  for (const take::TruthFrame& frame : frames) truth.push_back(frame.weights);
  return truth;
}

}  // namespace

std::string_view provenance_name(face::Provenance provenance) {
  static constexpr std::array<std::string_view, kProvenanceCount> kNames = {
      "measured", "interpolated", "predicted", "held", "audio", "neutral"};
  return kNames[static_cast<std::size_t>(provenance)];
}

std::vector<std::string> baselines_ahead(const Evaluation& evaluation) {
  std::vector<std::string> sentences;
  const auto judge = [&](const char* name, const Metrics& baseline) {
    const std::vector<std::string> errors = errors_ahead(baseline, evaluation.model);
    if (!errors.empty())
      sentences.push_back(
          fmt::format("{} is closer than the model here: {}.", name, fmt::join(errors, ", ")));
  };
  if (evaluation.ridge) judge("Ridge", *evaluation.ridge);
  judge("The mean pose", evaluation.mean_pose);
  judge("The truth of a second ago, which no tracker has,", evaluation.hold_last);
  return sentences;
}

std::vector<std::pair<std::size_t, std::size_t>> evaluated_runs(std::span<const take::TruthFrame> truth) {
  std::vector<std::pair<std::size_t, std::size_t>> runs;
  for (std::size_t i = 0; i < truth.size();) {
    if (!truth[i].evaluated || !truth[i].has_face) {
      ++i;
      continue;
    }
    std::size_t end = i;
    while (end < truth.size() && truth[end].evaluated && truth[end].has_face) ++end;
    runs.emplace_back(i, end);
    i = end;
  }
  return runs;
}

std::vector<face::BlendshapeWeights> hold_last(std::span<const take::TruthFrame> truth) {
  std::vector<face::BlendshapeWeights> held;
  held.reserve(truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    // Before a second has passed the oldest truth there is; where the face was lost, the last one seen.
    std::size_t past = i < kHoldFrames ? 0 : i - kHoldFrames;
    while (past > 0 && !truth[past].has_face) --past;
    held.push_back(truth[past].weights);
  }
  return held;
}

Metrics measure_track(const Meter& meter, std::span<const take::TruthFrame> truth,
                      std::span<const face::BlendshapeWeights> estimate) {
  const Track weights = truth_of(truth);
  const std::span<const face::BlendshapeWeights> all(weights);
  std::vector<Stretch> stretches;
  for (const auto& [begin, end] : evaluated_runs(truth))
    stretches.push_back({all.subspan(begin, end - begin), estimate.subspan(begin, end - begin)});
  return meter.measure(stretches);
}

namespace {

enum class Gaze { as_weights_say, of_model };

/// Of all takes as one, what `track_of` gives of each, beside its truth.
template <class TrackOf>
std::vector<Stretch> stretches_of(const std::vector<TakeEstimates>& takes, const std::vector<Track>& truths,
                                  Gaze gaze, TrackOf&& track_of) {
  std::vector<Stretch> stretches;
  for (std::size_t t = 0; t < takes.size(); ++t)
    for (const auto& [begin, end] : evaluated_runs(takes[t].truth)) {
      const std::span<const face::BlendshapeWeights> truth(truths[t]);
      const std::span<const face::BlendshapeWeights> estimate(track_of(t));
      Stretch& stretch = stretches.emplace_back();
      stretch.truth = truth.subspan(begin, end - begin);
      stretch.estimate = estimate.subspan(begin, end - begin);
      if (gaze == Gaze::of_model && !takes[t].gaze_rad.empty())
        stretch.gaze_rad = std::span(takes[t].gaze_rad).subspan(begin, end - begin);
    }
  return stretches;
}

/// Of each shape the 10th percentile over the runs' frames, clipped to [0, 1].
face::BlendshapeWeights rest_of(const Track& track,
                                const std::vector<std::pair<std::size_t, std::size_t>>& runs) {
  face::BlendshapeWeights rest;
  std::vector<float> values;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    values.clear();
    for (const auto& [begin, end] : runs)
      for (std::size_t f = begin; f < end; ++f) values.push_back(std::clamp(track[f][k], 0.0F, 1.0F));
    if (values.empty()) continue;
    const auto tenth = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 10);
    std::ranges::nth_element(values, tenth);
    rest[k] = *tenth;
  }
  return rest;
}

/// The estimate of a take as it is with the truth's rest.
Track resting_as(const face::BlendshapeWeights& truths_rest, const Track& estimate,
                 std::span<const take::TruthFrame> frames) {
  const face::BlendshapeWeights own = rest_of(estimate, evaluated_runs(frames));
  Track out = estimate;
  for (face::BlendshapeWeights& weights : out)
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      weights[k] = std::clamp(weights[k], 0.0F, 1.0F) - own[k] + truths_rest[k];
  return out;
}

}  // namespace

Metrics measure_shaped(const Meter& meter, const std::vector<TakeEstimates>& takes,
                       std::span<const std::vector<face::BlendshapeWeights>> weights) {
  std::vector<Track> truths;
  for (const TakeEstimates& t : takes) truths.push_back(truth_of(t.truth));
  return meter.measure(stretches_of(takes, truths, Gaze::as_weights_say,
                                    [&](std::size_t t) -> const Track& { return weights[t]; }));
}

Ablation measure_ablation(const Meter& meter, const std::vector<TakeEstimates>& takes, std::string without,
                          std::span<const std::vector<face::BlendshapeWeights>> weights) {
  Ablation out{.without = std::move(without), .changed = false, .metrics = {}};
  for (std::size_t t = 0; t < takes.size(); ++t)
    out.changed =
        out.changed || !std::ranges::equal(weights[t], takes[t].model, {}, &face::BlendshapeWeights::values,
                                           &face::BlendshapeWeights::values);
  out.metrics = measure_shaped(meter, takes, weights);
  return out;
}

Wears over_wears(std::span<const Evaluation> evaluations) {
  const auto interval = [&](auto&& figure) {
    SeedFigures figures(1);
    for (const Evaluation& one : evaluations) figures.front().push_back(figure(one.model));
    return mean_interval(figures);
  };
  const auto rest = [](const Metrics& of) { return of.about_rest.value_or(MotionErrors{}); };
  return {.count = evaluations.size(),
          .pve_mm = interval([](const Metrics& of) { return of.pve_mm.mean; }),
          .mse = interval([](const Metrics& of) { return of.mse; }),
          .pve_about_rest_mm = interval([&](const Metrics& of) { return rest(of).pve_mm; }),
          .mse_about_rest = interval([&](const Metrics& of) { return rest(of).mse; })};
}

Result<Evaluation> evaluate(const Meter& meter, const std::vector<TakeEstimates>& takes,
                            const face::BlendshapeWeights& mean_pose) {
  std::vector<Track> truths;
  std::vector<Track> held;
  std::vector<Track> means;
  std::vector<face::BlendshapeWeights> rests;  // Of the truths.
  for (const TakeEstimates& t : takes) {
    truths.push_back(truth_of(t.truth));
    rests.push_back(rest_of(truths.back(), evaluated_runs(t.truth)));
    held.push_back(hold_last(t.truth));
    means.emplace_back(t.truth.size(), mean_pose);
  }

  Evaluation out;
  out.takes = takes.size();
  bool has_ridge = !takes.empty();
  for (const TakeEstimates& t : takes) has_ridge = has_ridge && t.ridge.size() == t.truth.size();
  const auto measure = [&](auto&& track_of, Gaze gaze = Gaze::as_weights_say) {
    const std::vector<Stretch> stretches = stretches_of(takes, truths, gaze, track_of);
    Metrics metrics = meter.measure(stretches);
    metrics.eyes_and_lips = meter.eyes_and_lips().measure(stretches);
    std::vector<Track> moved;
    for (std::size_t t = 0; t < takes.size(); ++t)
      moved.push_back(resting_as(rests[t], track_of(t), takes[t].truth));
    const Metrics motion = meter.measure(stretches_of(
        takes, truths, Gaze::as_weights_say, [&](std::size_t t) -> const Track& { return moved[t]; }));
    metrics.about_rest = MotionErrors{.mse = motion.mse, .pve_mm = motion.pve_mm.mean};
    return metrics;
  };
  out.model = measure([&](std::size_t t) -> const Track& { return takes[t].model; }, Gaze::of_model);
  if (out.model.frames == 0)
    return fail(ErrorCode::not_found, "no frame of these takes can be evaluated",
                takes.empty() ? "" : takes.front().take,
                "a take needs a truth track with frames outside its prologue");
  out.mean_pose = measure([&](std::size_t t) -> const Track& { return means[t]; });
  out.hold_last = measure([&](std::size_t t) -> const Track& { return held[t]; });
  if (has_ridge) out.ridge = measure([&](std::size_t t) -> const Track& { return takes[t].ridge; });
  out.provenance = provenance_shares(takes);
  out.frames = out.model.frames;
  return out;
}

}  // namespace mien::measure
