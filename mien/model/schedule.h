#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mien::model {

/// How noise is mixed in: x_t = sqrt(a_t) x_0 + sqrt(1 - a_t) noise, with a_t falling from 1 to 0 over the
/// levels.
struct ScheduleSettings {
  std::size_t levels = 1000;  ///< Number of noise levels; level 0 is almost clean.
  /// 0 to 1, a share of all levels: where on the cosine level 0 lies. Raising puts more noise into the first
  /// levels, lowering less (at 0 hardly any, which teaches nothing). The source's value; a network keeps the
  /// one that it was trained with.
  double offset = 0.008;
  bool operator==(const ScheduleSettings&) const = default;
};

/// The cosine schedule's a_t for t = 0 to levels - 1, betas clipped at 0.999 as EgoEgo has them.
/// Source: Nichol and Dhariwal 2021, "Improved denoising diffusion probabilistic models", equation 17.
[[nodiscard]] std::vector<double> cosine_signal(const ScheduleSettings& settings);

/// How noise is taken out again.
enum class SamplerKind {
  ddpm,  ///< Every level, with fresh noise at each (Ho et al. 2020): as published.
  ddim,  ///< `steps` levels evenly spread, without fresh noise (Song et al. 2021, eta = 0).
};

/// What the frames that a window shares with the one before it are held at while it is denoised.
enum class OverlapHold {
  clean,   ///< The previous window's result itself.
  noised,  ///< The same, mixed to the step's level with the first noise.
};

/// How weights are drawn from the network.
struct SamplerSettings {
  SamplerKind kind = SamplerKind::ddim;
  /// Network calls a window, 1 to levels; ddpm ignores it. More is slower and livelier, fewer is nearer to
  /// the mean; 1 asks the network once and takes its answer.
  std::size_t steps = 4;
  std::uint64_t seed = 1;  ///< The same seed gives the same weights.
  OverlapHold hold = OverlapHold::noised;
  /// Standard deviation of the first noise, 0 to 1: 1 as trained. Lowering takes out the jitter that the
  /// noise brings into ddim's answers of few steps; 0 begins at the middle of all beginnings. Raising brings
  /// their jitter back, and their spread. Training tries 1 and 0 on validation. ddpm takes 1 whatever this
  /// is.
  double first_noise = 1;
  bool operator==(const SamplerSettings&) const = default;
};

/// The levels that a sampler visits, from the noisiest down to 0 or (with few steps) near it.
[[nodiscard]] std::vector<std::size_t> sampler_levels(const SamplerSettings& settings, std::size_t levels);

/// The network works on x = 2 w - 1 for a weight w in [0, 1].
[[nodiscard]] constexpr float to_network(float weight) {
  return 2 * (weight < 0 ? 0 : weight > 1 ? 1 : weight) - 1;
}
[[nodiscard]] constexpr float from_network(float x) {
  return 0.5F * ((x < -1 ? -1 : x > 1 ? 1 : x) + 1);
}

}  // namespace mien::model
