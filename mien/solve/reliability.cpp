#include "mien/solve/reliability.h"

#include <algorithm>
#include <cmath>

namespace mien::solve {

void Reliability::add(float confidence, bool within, double times) {
  const auto bin = static_cast<std::size_t>(confidence * kBins);
  Bin& into = bins_[std::min(bin, kBins - 1)];
  into.frames += times;
  into.confidence += times * double{confidence};
  into.within += within ? times : 0;
}

void Reliability::add(const Reliability& other) {
  for (std::size_t b = 0; b < kBins; ++b) {
    bins_[b].frames += other.bins_[b].frames;
    bins_[b].confidence += other.bins_[b].confidence;
    bins_[b].within += other.bins_[b].within;
  }
}

double Reliability::expected_error() const {
  double frames = 0, error = 0;
  for (const Bin& bin : bins_) {
    frames += bin.frames;
    error += std::abs(bin.confidence - bin.within);
  }
  return frames > 0 ? error / frames : 0;
}

void RocArea::add(float confidence, bool within) {
  const auto place = static_cast<std::size_t>(confidence * static_cast<float>(kBins));
  Bin& bin = bins_[std::min(place, kBins - 1)];
  (within ? bin.within : bin.beyond) += 1;
}

void RocArea::add(const RocArea& other) {
  for (std::size_t b = 0; b < kBins; ++b) {
    bins_[b].within += other.bins_[b].within;
    bins_[b].beyond += other.bins_[b].beyond;
  }
}

double RocArea::area() const {
  double within = 0, beyond = 0, won = 0;
  for (const Bin& bin : bins_) {
    won += bin.within * (beyond + 0.5 * bin.beyond);
    within += bin.within;
    beyond += bin.beyond;
  }
  return within > 0 && beyond > 0 ? won / (within * beyond) : 0.5;
}

}  // namespace mien::solve
