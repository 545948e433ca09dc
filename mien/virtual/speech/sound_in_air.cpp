#include "mien/virtual/speech/sound_in_air.h"

#include <cmath>
#include <cstddef>

#include "mien/speech/block_maker.h"

namespace mien::virt {

Result<SoundInAir> SoundInAir::of(const Sound& sound) {
  MIEN_TRY_ASSIGN(speech::BlockMaker maker, speech::BlockMaker::create(static_cast<int>(sound.rate_hz)));
  SoundInAir heard;
  heard.samples_.reserve(static_cast<std::size_t>(sound.duration_s() * speech::kRateHz) +
                         speech::kBlockSamples);
  const auto take = [&](const speech::Block& block) {
    for (const std::int16_t sample : block)
      heard.samples_.push_back(static_cast<float>(sample) / speech::kFullScale);
  };
  maker.push(sound.samples, take);
  maker.finish(take);
  return heard;
}

double SoundInAir::at(double motion_s) const {
  const double place = motion_s * speech::kRateHz;
  if (!(place > -1) || place >= static_cast<double>(samples_.size())) return 0;
  const auto before = static_cast<std::ptrdiff_t>(std::floor(place));
  const double t = place - static_cast<double>(before);
  const auto sample = [&](std::ptrdiff_t i) {
    return i < 0 || i >= static_cast<std::ptrdiff_t>(samples_.size())
               ? 0.0
               : double{samples_[static_cast<std::size_t>(i)]};
  };
  // Catmull and Rom's cubic: a drifting clock's samples fall between those that are there.
  const double a = sample(before - 1), b = sample(before), c = sample(before + 1), d = sample(before + 2);
  return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

}  // namespace mien::virt
