#include "mien/model/sampler.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mien/core/random.h"

namespace mien::model {
namespace {

/// Brings one window from noise to a result, step by step.
class WindowSampler {
 public:
  WindowSampler(const Denoiser& denoiser, const ScheduleSettings& schedule, const SamplerSettings& settings)
      : denoiser_(denoiser),
        workspace_(denoiser),
        settings_(settings),
        signal_(cosine_signal(schedule)),
        levels_(sampler_levels(settings, schedule.levels)),
        noisy_(denoiser.architecture().window * denoiser.architecture().outputs),
        clean_(noisy_.size()) {}

  /// `noise`: [frames x outputs], unit noise times the settings' first_noise. `held`: what the first frames
  /// are held at, as many as it has. Gives the clean window, also over the held frames as the network itself
  /// sees them.
  std::span<const float> run(std::span<const float> condition, std::span<const float> noise,
                             std::span<const float> held, Random random) {
    const std::span x = std::span(noisy_).first(noise.size());
    const std::span clean = std::span(clean_).first(noise.size());
    denoiser_.set_condition(condition, workspace_);
    std::copy(noise.begin(), noise.end(), x.begin());
    for (std::size_t i = 0; i < levels_.size(); ++i) {
      hold(x, noise, held, signal_[levels_[i]]);
      denoiser_.predict(x, levels_[i], clean, workspace_);
      for (float& value : clean) value = std::clamp(value, -1.0F, 1.0F);
      if (i + 1 == levels_.size()) break;
      if (settings_.kind == SamplerKind::ddpm)
        step_ddpm(x, clean, levels_[i], random);
      else
        step_ddim(x, clean, levels_[i], levels_[i + 1]);
    }
    return clean;
  }

 private:
  void hold(std::span<float> x, std::span<const float> noise, std::span<const float> held,
            double signal) const {
    const bool noised = settings_.hold == OverlapHold::noised;
    const auto keep = static_cast<float>(noised ? std::sqrt(signal) : 1.0);
    const auto mix = static_cast<float>(noised ? std::sqrt(1 - signal) : 0.0);
    for (std::size_t i = 0; i < held.size(); ++i) x[i] = keep * held[i] + mix * noise[i];
  }

  /// Song et al. 2021, equation 12 with sigma 0, the noise taken from the predicted clean window.
  void step_ddim(std::span<float> x, std::span<const float> clean, std::size_t from, std::size_t to) const {
    const double a = signal_[from], b = signal_[to];
    const double noise_share = std::sqrt((1 - b) / (1 - a));
    const auto keep = static_cast<float>(noise_share);
    const auto pull = static_cast<float>(std::sqrt(b) - noise_share * std::sqrt(a));
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = keep * x[i] + pull * clean[i];
  }

  /// Ho et al. 2020, equation 7: the posterior's mean, and fresh noise of its variance.
  void step_ddpm(std::span<float> x, std::span<const float> clean, std::size_t level, Random& random) const {
    const double a = signal_[level], b = signal_[level - 1], alpha = a / b;
    const auto of_clean = static_cast<float>(std::sqrt(b) * (1 - alpha) / (1 - a));
    const auto of_noisy = static_cast<float>(std::sqrt(alpha) * (1 - b) / (1 - a));
    const double sigma = std::sqrt((1 - alpha) * (1 - b) / (1 - a));
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] = of_clean * clean[i] + of_noisy * x[i] + static_cast<float>(sigma * random.normal());
  }

  const Denoiser& denoiser_;
  Denoiser::Workspace workspace_;
  SamplerSettings settings_;
  std::vector<double> signal_;
  std::vector<std::size_t> levels_;
  std::vector<float> noisy_, clean_;
};

}  // namespace

std::vector<std::size_t> window_starts(std::size_t frames, std::size_t window) {
  std::vector<std::size_t> starts = {0};
  while (starts.back() + window < frames)
    starts.push_back(std::min(starts.back() + window - overlap_frames(window), frames - window));
  return starts;
}

Result<std::vector<float>> solve_windows(const Denoiser& denoiser, const ScheduleSettings& schedule,
                                         std::span<const float> condition, const SamplerSettings& settings,
                                         const Progress& progress) {
  const Architecture& a = denoiser.architecture();
  const std::size_t frames = condition.size() / a.condition, width = a.outputs;
  if (frames == 0 || condition.size() % a.condition != 0)
    return fail(ErrorCode::bad_usage,
                fmt::format("{} numbers are not frames of {} numbers each", condition.size(), a.condition));
  if (settings.steps < 1 || settings.steps > schedule.levels)
    return fail(ErrorCode::bad_usage,
                fmt::format("{} sampler steps are not between 1 and {}", settings.steps, schedule.levels));
  if (!(settings.first_noise >= 0 && settings.first_noise <= 1))
    return fail(ErrorCode::bad_usage,
                fmt::format("a first noise of {} is not within 0 to 1", settings.first_noise));
  if (!std::all_of(condition.begin(), condition.end(), [](float v) { return std::isfinite(v); }))
    return fail(ErrorCode::out_of_range, "a feature is not a finite number");

  const Random root(settings.seed);
  Random first = root.fork("first noise");
  std::vector<float> noise(frames * width), result(frames * width);
  const double size = settings.kind == SamplerKind::ddpm ? 1.0 : settings.first_noise;
  for (float& value : noise) value = static_cast<float>(size * first.normal());

  WindowSampler sampler(denoiser, schedule, settings);
  const std::vector<std::size_t> starts = window_starts(frames, a.window);
  std::size_t solved = 0;  // Frames of `result` that a window has given.
  for (std::size_t i = 0; i < starts.size(); ++i) {
    if (!progress(static_cast<double>(i) / static_cast<double>(starts.size()), "solving"))
      return fail(ErrorCode::cancelled, "stopped while solving");
    const std::size_t start = starts[i], count = std::min(a.window, frames - start), shared = solved - start;
    const std::span out = std::span(result).subspan(start * width, count * width);
    const std::span clean = sampler.run(condition.subspan(start * a.condition, count * a.condition),
                                        std::span(noise).subspan(start * width, count * width),
                                        out.first(shared * width), root.fork("step noise", i));
    for (std::size_t f = 0; f < count; ++f) {
      // A raised cosine: its slope is zero at both ends, so neither end shows as a corner.
      const double along = (static_cast<double>(f) + 1) / (static_cast<double>(shared) + 1);
      const auto share =
          f < shared ? static_cast<float>(0.5 - 0.5 * std::cos(std::numbers::pi * along)) : 1.0F;
      for (std::size_t j = 0; j < width; ++j)
        out[f * width + j] += share * (clean[f * width + j] - out[f * width + j]);
    }
    solved = start + count;
  }
  for (float& value : result) value = from_network(value);
  progress(1, "solved");
  return result;
}

}  // namespace mien::model
