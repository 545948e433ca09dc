#include "mien/train/mel_augmentation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace mien::train {
namespace {

using speech::kMelBands;
using speech::LogMel;

constexpr double kFrame_s = 0.01;
const double kNepersPerDb = std::numbers::ln10 / 10;  // Of powers.

double mel_of(double hz) {
  return 2595 * std::log10(1 + hz / 700);
}
double hz_of(double mel) {
  return 700 * (std::pow(10, mel / 2595) - 1);
}
/// Middle of a band, which need not be whole.
double band_hz(double band) {
  const double low = mel_of(LogMel::kLowest_hz), high = mel_of(LogMel::kHighest_hz);
  return hz_of(low + (high - low) * (band + 1) / (kMelBands + 1));
}
double band_at(double hz) {
  const double low = mel_of(LogMel::kLowest_hz), high = mel_of(LogMel::kHighest_hz);
  return (mel_of(hz) - low) / (high - low) * (kMelBands + 1) - 1;
}

void stretch_bands(std::span<float> frames, double factor) {
  std::array<std::size_t, kMelBands> from{};
  std::array<float, kMelBands> share{};
  for (std::size_t b = 0; b < kMelBands; ++b) {
    const double at = std::clamp(band_at(factor * band_hz(static_cast<double>(b))), 0.0, kMelBands - 1.001);
    from[b] = static_cast<std::size_t>(at);
    share[b] = static_cast<float>(at - std::floor(at));
  }
  std::array<float, kMelBands> out{};
  for (std::size_t at = 0; at < frames.size(); at += kMelBands) {
    const auto frame = frames.subspan(at, kMelBands);
    for (std::size_t b = 0; b < kMelBands; ++b)
      out[b] = frame[from[b]] + share[b] * (frame[from[b] + 1] - frame[from[b]]);
    std::ranges::copy(out, frame.begin());
  }
}

/// What the microphone and the voice add to each band, nepers of power.
std::array<float, kMelBands> draw_equaliser(Random& random) {
  std::array<double, 4> waves{};
  for (double& wave : waves) wave = 0.7 * random.normal();
  const double tilt = random.normal();
  std::array<float, kMelBands> gain{};
  for (std::size_t b = 0; b < kMelBands; ++b) {
    const double x = static_cast<double>(b) / (kMelBands - 1);
    double sum = tilt * (2 * x - 1);
    for (std::size_t w = 0; w < waves.size(); ++w)
      sum += waves[w] * std::cos(std::numbers::pi * static_cast<double>(w + 1) * x);
    gain[b] = static_cast<float>(sum);
  }
  return gain;
}

/// Mean power of the louder half of the frames.
double loudness_of(std::span<const float> frame_powers) {
  std::vector<double> powers;
  for (std::size_t at = 0; at < frame_powers.size(); at += kMelBands) {
    double sum = 0;
    for (const float band : frame_powers.subspan(at, kMelBands)) sum += double{band};
    powers.push_back(sum);
  }
  std::ranges::sort(powers, std::greater());
  powers.resize(std::max<std::size_t>(1, powers.size() / 2));
  double mean = 0;
  for (const double power : powers) mean += power / static_cast<double>(powers.size());
  return std::max(mean, 1e-12);
}

void reverberate(std::span<float> powers, double decay_s, double direct_db) {
  const double keep = std::pow(10, -6 * kFrame_s / decay_s);
  // The tail's whole power lies so far below what comes directly.
  const double share = std::pow(10, -direct_db / 10) * (1 - keep);
  std::array<double, kMelBands> tail{};
  for (std::size_t at = 0; at < powers.size(); at += kMelBands)
    for (std::size_t b = 0; b < kMelBands; ++b) {
      float& power = powers[at + b];
      const double direct = power;
      power += static_cast<float>(share * tail[b]);
      tail[b] = keep * (tail[b] + direct);
    }
}

}  // namespace

void augment_mel(std::span<float> frames, std::span<const float> other, Random& random) {
  if (random.chance(0.7)) stretch_bands(frames, random.uniform(0.86, 1.14));
  const auto equaliser = draw_equaliser(random);
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i] = std::exp(frames[i] + equaliser[i % kMelBands]);
  if (random.chance(0.5)) {
    const double direct_db = random.uniform(0, 15), decay_s = random.uniform(0.15, 0.8);
    reverberate(frames, decay_s, direct_db);
  }
  if (!other.empty() && random.chance(0.75)) {
    std::vector<float> about(frames.size());
    for (std::size_t i = 0; i < about.size(); ++i) about[i] = std::exp(other[i]);
    const auto gain = static_cast<float>(loudness_of(frames) / loudness_of(about) *
                                         std::pow(10, -random.uniform(3, 40) / 10));
    for (std::size_t i = 0; i < frames.size(); ++i) frames[i] += gain * about[i];
  }
  std::array<float, kMelBands> last{};
  last.fill(static_cast<float>(kNepersPerDb * random.uniform(-30, 20)));
  if (random.chance(0.2)) {
    const double low_hz = random.uniform(100, 350), high_hz = random.uniform(3000, 7000);
    for (std::size_t b = 0; b < kMelBands; ++b) {
      const double hz = band_hz(static_cast<double>(b));
      const double octaves = std::max(std::log2(low_hz / hz), std::log2(hz / high_hz));
      last[b] -= static_cast<float>(kNepersPerDb * 24 * std::max(0.0, octaves));
    }
  }
  for (std::size_t i = 0; i < frames.size(); ++i)
    frames[i] = std::max(LogMel::kLogFloor, std::log(std::max(frames[i], 1e-12F)) + last[i % kMelBands]);
}

}  // namespace mien::train
