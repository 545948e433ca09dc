#include "mien/model/schedule.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace mien::model {

std::vector<double> cosine_signal(const ScheduleSettings& settings) {
  const auto levels = static_cast<double>(settings.levels);
  const auto curve = [&](double level) {
    const double angle = (level / levels + settings.offset) / (1 + settings.offset) * std::numbers::pi / 2;
    return std::cos(angle) * std::cos(angle);
  };
  std::vector<double> signal(settings.levels);
  double product = 1;
  for (std::size_t t = 0; t < settings.levels; ++t) {
    const double beta =
        std::clamp(1 - curve(static_cast<double>(t + 1)) / curve(static_cast<double>(t)), 0.0, 0.999);
    product *= 1 - beta;
    signal[t] = product;
  }
  return signal;
}

std::vector<std::size_t> sampler_levels(const SamplerSettings& settings, std::size_t levels) {
  const std::size_t steps =
      settings.kind == SamplerKind::ddpm ? levels : std::clamp<std::size_t>(settings.steps, 1, levels);
  std::vector<std::size_t> visited(steps);
  // Always from the last level, where the network has seen nothing but noise.
  for (std::size_t i = 0; i < steps; ++i) visited[i] = (steps - i) * levels / steps - 1;
  return visited;
}

}  // namespace mien::model
