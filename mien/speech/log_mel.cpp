#include "mien/speech/log_mel.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace mien::speech {
namespace {

constexpr std::size_t kHop = kBlockSamples / kFramesPerBlock;
constexpr std::size_t kWindow = 400;
constexpr std::size_t kPoints = 512;
constexpr std::size_t kBins = kPoints / 2 + 1;

double mel_of(double hz) {
  return 2595 * std::log10(1 + hz / 700);
}

double hz_of(double mel) {
  return 700 * (std::pow(10, mel / 2595) - 1);
}

/// A band's weights of the bins that it has a share of.
struct Band {
  std::size_t first = 0;
  std::vector<float> weights;
};

std::array<Band, kMelBands> make_bands() {
  std::array<Band, kMelBands> bands;
  const double low = mel_of(LogMel::kLowest_hz), high = mel_of(LogMel::kHighest_hz);
  const auto edge_hz = [&](std::size_t i) {
    return hz_of(low + (high - low) * static_cast<double>(i) / (kMelBands + 1));
  };
  for (std::size_t b = 0; b < kMelBands; ++b) {
    const double left = edge_hz(b), middle = edge_hz(b + 1), right = edge_hz(b + 2);
    Band& band = bands[b];
    for (std::size_t k = 0; k < kBins; ++k) {
      const double hz = static_cast<double>(k) * kRateHz / kPoints;
      const double weight = std::min((hz - left) / (middle - left), (right - hz) / (right - middle));
      if (weight <= 0) continue;
      if (band.weights.empty()) band.first = k;
      band.weights.push_back(static_cast<float>(weight));
    }
    // Low bands are narrower than a bin: these take the nearest one whole.
    if (band.weights.empty()) {
      band.first = static_cast<std::size_t>(std::lround(middle * kPoints / kRateHz));
      band.weights.push_back(1);
    }
  }
  return bands;
}

std::array<float, kWindow> make_window() {
  std::array<float, kWindow> window{};
  for (std::size_t i = 0; i < kWindow; ++i)
    window[i] = static_cast<float>(
        0.5 - 0.5 * std::cos(2 * std::numbers::pi * (static_cast<double>(i) + 0.5) / kWindow));
  return window;
}

}  // namespace

struct LogMel::Transform {
  const std::array<Band, kMelBands> bands = make_bands();
  const std::array<float, kWindow> window = make_window();
  std::array<float, kWindow> past{};  // The newest samples, oldest first.
  std::vector<float> in = std::vector<float>(kPoints);
  std::vector<std::complex<float>> out = std::vector<std::complex<float>>(kPoints);
  Eigen::FFT<float> fft;

  MelFrame frame() {
    for (std::size_t i = 0; i < kWindow; ++i) in[i] = window[i] * past[i];
    fft.fwd(out.data(), in.data(), static_cast<Eigen::Index>(kPoints));
    // A sine of full scale gives (sum of the window / 2)^2 = (kWindow / 4)^2 in its bin.
    constexpr float kScale = 16.0F / (kWindow * kWindow);
    MelFrame mel;
    for (std::size_t b = 0; b < kMelBands; ++b) {
      float power = 0;
      for (std::size_t i = 0; i < bands[b].weights.size(); ++i)
        power += bands[b].weights[i] * std::norm(out[bands[b].first + i]);
      mel[b] = std::max(kLogFloor, std::log(std::max(power * kScale, 1e-12F)));
    }
    return mel;
  }
};

LogMel::LogMel() : transform_(std::make_unique<Transform>()) {}
LogMel::~LogMel() = default;
LogMel::LogMel(LogMel&&) noexcept = default;
LogMel& LogMel::operator=(LogMel&&) noexcept = default;

std::array<MelFrame, kFramesPerBlock> LogMel::push(const Block& block) {
  std::array<MelFrame, kFramesPerBlock> frames;
  auto& past = transform_->past;
  for (std::size_t f = 0; f < kFramesPerBlock; ++f) {
    std::copy(past.begin() + kHop, past.end(), past.begin());
    for (std::size_t i = 0; i < kHop; ++i)
      past[kWindow - kHop + i] = static_cast<float>(block[f * kHop + i]) / kFullScale;
    frames[f] = transform_->frame();
  }
  return frames;
}

void LogMel::reset() {
  transform_->past.fill(0);
}

}  // namespace mien::speech
