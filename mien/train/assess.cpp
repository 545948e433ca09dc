#include "mien/train/assess.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "mien/face/profile.h"
#include "mien/model/causal_network.h"
#include "mien/model/denoiser.h"
#include "mien/model/sampler.h"

namespace mien::train {
namespace {

/// Frames of one sequence that the choice of a sampler looks at: enough for several joins.
constexpr std::size_t kSamplerTakeFrames = 600;
/// Validation frames by which a ridge's penalty is chosen.
constexpr std::size_t kRidgeValidationFrames = 20'000;

/// Condition and truth of some frames.
struct Frames {
  std::vector<float> condition, weights;
};

Frames frames_of(const BatchMaker& batches, std::size_t width, std::size_t sequence, std::size_t count,
                 Random& random) {
  const dataset::Sequence& s = batches.dataset().sequences[sequence];
  count = std::min(count, s.frames);
  Frames frames{.condition = std::vector<float>(count * width), .weights = {}};
  batches.encode(sequence, 0, count, random, frames.condition);
  const std::size_t outputs = s.weights.size() / std::max<std::size_t>(s.frames, 1);
  for (std::size_t i = 0; i < count * outputs; ++i)
    frames.weights.push_back(std::clamp(s.weights[i], 0.0F, 1.0F));
  return frames;
}

template <class Condition>
std::vector<std::size_t> sequences_where(const dataset::Dataset& dataset, const Condition& condition) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < dataset.sequences.size(); ++i)
    if (condition(dataset.sequences[i])) chosen.push_back(i);
  return chosen;
}

std::vector<std::size_t> of_profile(const dataset::Dataset& dataset, bool lab) {
  return sequences_where(dataset, [&](const dataset::Sequence& s) { return s.lab == lab; });
}

std::vector<std::size_t> of_takes(const dataset::Dataset& dataset) {
  return sequences_where(dataset, [](const dataset::Sequence& s) { return s.from_take; });
}

/// Of validation, so many of each sequence that the whole is enough to judge a ridge by.
Frames held_out_frames(const BatchMaker& validation, std::size_t width,
                       const std::vector<std::size_t>& sequences, Random& random) {
  Frames held_out;
  for (const std::size_t i : sequences) {
    const Frames frames =
        frames_of(validation, width, i, kRidgeValidationFrames / sequences.size() + 1, random);
    held_out.condition.insert(held_out.condition.end(), frames.condition.begin(), frames.condition.end());
    held_out.weights.insert(held_out.weights.end(), frames.weights.begin(), frames.weights.end());
  }
  return held_out;
}

double mean_pose_mse(const Frames& frames, const model::ModelFile& model) {
  double mse = 0;
  for (std::size_t i = 0; i < frames.weights.size(); ++i)
    mse += std::pow(double{frames.weights[i]} - double{model.mean_pose[i % model.architecture.outputs]}, 2) /
           static_cast<double>(frames.weights.size());
  return mse;
}

Result<Assessment::Profile> fit_profile(const BatchMaker& training, const BatchMaker& validation,
                                        std::uint64_t seed, bool lab, model::ModelFile& model) {
  const std::size_t width = model.architecture.condition, outputs = model.architecture.outputs;
  Random random = Random(seed).fork("ridge", lab ? 1 : 0);
  model::RidgeFit fit(width, outputs);
  for (const std::size_t i : of_profile(training.dataset(), lab)) {
    const Frames frames = frames_of(training, width, i, training.dataset().sequences[i].frames, random);
    fit.add(frames.condition, frames.weights);
  }
  const Frames held_out = held_out_frames(validation, width, of_profile(validation.dataset(), lab), random);
  MIEN_TRY_ASSIGN(model::RidgeBaseline ridge, model::choose_ridge(fit, held_out.condition, held_out.weights));
  ridge.profile = lab ? "lab" : "device";
  Assessment::Profile profile{.name = ridge.profile,
                              .ridge_mse = ridge.validation_mse,
                              .mean_pose_mse = mean_pose_mse(held_out, model)};
  model.ridge.push_back(std::move(ridge));
  return profile;
}

/// What the baselines make of takes alone; nothing where none are held out.
std::optional<Assessment::Profile> judge_takes(const BatchMaker& validation, std::uint64_t seed,
                                               const model::ModelFile& model) {
  const std::vector<std::size_t> takes = of_takes(validation.dataset());
  const model::RidgeBaseline* ridge = model.ridge_for("device");
  if (takes.empty() || ridge == nullptr) return std::nullopt;
  Random random = Random(seed).fork("ridge of takes");
  const Frames frames = held_out_frames(validation, model.architecture.condition, takes, random);
  return Assessment::Profile{.name = "takes",
                             .ridge_mse = model::mean_squared_error(*ridge, frames.condition, frames.weights),
                             .mean_pose_mse = mean_pose_mse(frames, model)};
}

/// Runs one setting over takes and sums up how it did.
Result<Assessment::Candidate> run_sampler(const model::Denoiser& denoiser,
                                          const model::ScheduleSettings& schedule,
                                          const std::vector<Frames>& takes,
                                          const model::SamplerSettings& settings) {
  const std::size_t outputs = denoiser.architecture().outputs, window = denoiser.architecture().window;
  double error = 0, count = 0, joins = 0, inside = 0, truth = 0;
  for (const Frames& take : takes) {
    MIEN_TRY_ASSIGN(const std::vector<float> solved,
                    model::solve_windows(denoiser, schedule, take.condition, settings, no_progress));
    for (std::size_t i = 0; i < solved.size(); ++i)
      error += std::pow(double{solved[i]} - double{take.weights[i]}, 2);
    count += static_cast<double>(solved.size());
    joins += third_difference(solved, outputs, window, true);
    inside += third_difference(solved, outputs, window, false);
    truth += third_difference(take.weights, outputs, window, false);
  }
  return Assessment::Candidate{.settings = settings,
                               .mse = count > 0 ? error / count : 0,
                               .jitter_ratio = truth > 0 ? inside / truth : 0,
                               .seam_ratio = inside > 0 ? joins / inside : 0};
}

/// Runs a causal network over takes, each from a fresh state on.
Result<Assessment::Causal> run_causal(const model::ModelFile& model, const std::vector<Frames>& takes) {
  MIEN_TRY_ASSIGN(const model::CausalNetwork network,
                  model::CausalNetwork::create(model.architecture, model.network));
  const std::size_t width = model.architecture.condition, outputs = model.architecture.outputs;
  model::CausalNetwork::State state(network);
  double error = 0, count = 0, moved = 0, truth = 0;
  for (const Frames& take : takes) {
    std::vector<float> solved(take.weights.size());
    state.reset();
    for (std::size_t f = 0; f < solved.size() / outputs; ++f)
      network.step(std::span(take.condition).subspan(f * width, width), state,
                   std::span(solved).subspan(f * outputs, outputs));
    for (std::size_t i = 0; i < solved.size(); ++i) {
      solved[i] = model::from_network(solved[i]);
      error += std::pow(double{solved[i]} - double{take.weights[i]}, 2);
    }
    count += static_cast<double>(solved.size());
    const std::size_t frames = std::max<std::size_t>(solved.size() / outputs, 2);  // One window: no joins.
    moved += third_difference(solved, outputs, frames, false);
    truth += third_difference(take.weights, outputs, frames, false);
  }
  return Assessment::Causal{.mse = count > 0 ? error / count : 0,
                            .jitter_ratio = truth > 0 ? moved / truth : 0};
}

/// Performances of validation, of lab, device and people's takes in turn and spread over the people, until
/// there are frames enough.
std::vector<Frames> sampler_takes(const Recipe& recipe, const BatchMaker& validation, std::size_t width) {
  Random random = Random(recipe.seed).fork("sampler");
  std::vector<std::vector<std::size_t>> profiles = {
      of_profile(validation.dataset(), true),
      sequences_where(validation.dataset(),
                      [](const dataset::Sequence& s) { return !s.lab && !s.from_take; })};
  if (auto recorded = of_takes(validation.dataset()); !recorded.empty())
    profiles.push_back(std::move(recorded));
  const std::size_t wanted = std::max<std::size_t>(1, recipe.sampler_frames / kSamplerTakeFrames / 2);
  std::vector<Frames> takes;
  for (const auto& profile : profiles) {
    const std::size_t count = std::min(wanted, profile.size());
    for (std::size_t i = 0; i < count; ++i)
      takes.push_back(frames_of(validation, width, profile[i * profile.size() / count],
                                std::min(kSamplerTakeFrames, recipe.sampler_frames), random));
  }
  return takes;
}

}  // namespace

std::vector<float> mean_pose_of(const dataset::Dataset& dataset, const FrameWeights& weights) {
  std::vector<double> sum;
  double frames = 0;
  for (const dataset::Sequence& s : dataset.sequences) {
    if (s.frames == 0) continue;
    sum.resize(s.weights.size() / s.frames);
    const double weight = weights.of(s);
    frames += weight * static_cast<double>(s.frames);
    for (std::size_t j = 0; j < s.weights.size(); ++j)
      sum[j % sum.size()] += weight * std::clamp(double{s.weights[j]}, 0.0, 1.0);
  }
  std::vector<float> mean;
  for (const double v : sum) mean.push_back(static_cast<float>(v / frames));
  return mean;
}

std::vector<float> weight_covariance_of(const dataset::Dataset& dataset, const FrameWeights& weights) {
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  constexpr auto kShapes = static_cast<Eigen::Index>(face::kShapeCount);
  const std::vector<float> mean = mean_pose_of(dataset, weights);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(kShapes, kShapes);
  double frames = 0;
  for (const dataset::Sequence& s : dataset.sequences) {
    RowMajor centred =
        Eigen::Map<const RowMajor>(s.weights.data(), static_cast<Eigen::Index>(s.frames), kShapes)
            .cwiseMax(0.0F)
            .cwiseMin(1.0F);
    centred.rowwise() -= Eigen::Map<const Eigen::RowVectorXf>(mean.data(), kShapes);
    sum += weights.of(s) * (centred.transpose() * centred).cast<double>();
    frames += weights.of(s) * static_cast<double>(s.frames);
  }
  std::vector<float> covariance;
  for (Eigen::Index i = 0; i < kShapes; ++i)
    for (Eigen::Index j = 0; j < kShapes; ++j) covariance.push_back(static_cast<float>(sum(i, j) / frames));
  return covariance;
}

double third_difference(std::span<const float> weights, std::size_t width, std::size_t window,
                        bool at_joins) {
  const std::size_t frames = weights.size() / width;
  // A join lies where a window's new frames begin; four frames make a third difference, so it touches three
  // of them.
  std::vector<std::uint8_t> joined(frames, 0);
  for (const std::size_t start : model::window_starts(frames, window)) {
    if (start == 0) continue;
    for (const std::size_t join : {start, start + model::overlap_frames(window)})
      for (std::size_t f = join; f < std::min(join + 3, frames); ++f) joined[f] = 1;
  }
  double sum = 0, count = 0;
  for (std::size_t f = 3; f < frames; ++f) {
    if ((joined[f] != 0) != at_joins) continue;
    for (std::size_t j = 0; j < width; ++j) {
      const auto at = [&](std::size_t back) { return double{weights[(f - back) * width + j]}; };
      sum += std::abs(at(0) - 3 * at(1) + 3 * at(2) - at(3));
    }
    count += static_cast<double>(width);
  }
  return count > 0 ? sum / count : 0;
}

Result<Assessment> assess(const Recipe& recipe, const BatchMaker& training, const BatchMaker& validation,
                          model::ModelFile& model, const Progress& progress) {
  Assessment assessment;
  model.ridge.clear();
  for (const bool lab : {true, false}) {
    if (of_profile(training.dataset(), lab).empty() || of_profile(validation.dataset(), lab).empty())
      continue;
    MIEN_TRY_ASSIGN(auto profile, fit_profile(training, validation, recipe.seed, lab, model));
    assessment.profiles.push_back(std::move(profile));
  }
  if (auto takes = judge_takes(validation, recipe.seed, model))
    assessment.profiles.push_back(std::move(*takes));

  const std::vector<Frames> takes = sampler_takes(recipe, validation, model.architecture.condition);
  if (model.architecture.kind == model::NetworkKind::causal) {
    MIEN_TRY_ASSIGN(assessment.causal, run_causal(model, takes));
    return assessment;
  }
  MIEN_TRY_ASSIGN(const model::Denoiser denoiser, model::Denoiser::create(model.architecture, model.network));
  std::vector<model::SamplerSettings> candidates;
  for (const std::size_t steps : recipe.sampler_steps)
    for (const double first_noise : {1.0, 0.0})
      for (const model::OverlapHold hold : {model::OverlapHold::noised, model::OverlapHold::clean})
        candidates.push_back({.kind = model::SamplerKind::ddim,
                              .steps = steps,
                              .seed = 1,
                              .hold = hold,
                              .first_noise = first_noise});
  for (const model::SamplerSettings& settings : candidates) {
    if (!progress(static_cast<double>(assessment.samplers.size()) / static_cast<double>(candidates.size()),
                  "choosing the sampler"))
      return fail(ErrorCode::cancelled, "stopped while choosing the sampler");
    MIEN_TRY_ASSIGN(assessment.samplers.emplace_back(),
                    run_sampler(denoiser, model.schedule, takes, settings));
  }
  const auto better = [](const Assessment::Candidate& a, const Assessment::Candidate& b) {
    const bool a_smooth = a.seam_ratio <= kSeamLimit, b_smooth = b.seam_ratio <= kSeamLimit;
    return a_smooth != b_smooth ? a_smooth : a.mse < b.mse;
  };
  model.sampler = std::min_element(assessment.samplers.begin(), assessment.samplers.end(), better)->settings;
  return assessment;
}

}  // namespace mien::train
