#include "mien/shaping/smoothing.h"

#include <algorithm>
#include <cmath>

namespace mien::shaping {
namespace {

constexpr double kWeakest_hz = 15;
constexpr double kStrongest_hz = 1;
/// Hz per weight a second: within the 1 to 5 that the filter's rule of tuning gives for weights at 60 Hz.
constexpr double kBetaWeights = 3;
/// Hz per rad/s: a quick turn of the head is 3 rad/s.
constexpr double kBetaHead = 1;
/// Hz per m/s: a quick lean is 0.6 m/s, and opens the filter as far as a quick turn does.
constexpr double kBetaPosition = 5;

}  // namespace

SmoothingSettings smoothing_for(double amount, bool head) {
  SmoothingSettings settings;
  if (!(amount > 0)) return settings;
  const double cutoff_hz = kWeakest_hz * std::pow(kStrongest_hz / kWeakest_hz, std::min(amount, 1.0));
  settings.weights = OneEuroSettings{.min_cutoff_hz = cutoff_hz, .beta = kBetaWeights};
  if (head) settings.head = OneEuroSettings{.min_cutoff_hz = cutoff_hz, .beta = kBetaHead};
  if (head) settings.position = OneEuroSettings{.min_cutoff_hz = cutoff_hz, .beta = kBetaPosition};
  return settings;
}

void Smoothing::set(const SmoothingSettings& settings) {
  if (settings.weights)
    for (OneEuro& filter : weights_) {
      if (!settings_.weights) filter.reset();
      filter.set(*settings.weights);
    }
  if (settings.head) {
    if (!settings_.head) head_.reset();
    head_.set(*settings.head);
  }
  if (settings.position)
    for (OneEuro& filter : position_) {
      if (!settings_.position) filter.reset();
      filter.set(*settings.position);
    }
  settings_ = settings;
}

void Smoothing::reset() {
  for (OneEuro& filter : weights_) filter.reset();
  head_.reset();
  for (OneEuro& filter : position_) filter.reset();
}

void Smoothing::smooth_position(face::OutputFrame& frame) {
  for (std::size_t a = 0; a < position_.size(); ++a) {
    if (!frame.head_position_known) {
      position_[a].reset();
      continue;
    }
    float& x = frame.head_position_m[static_cast<Eigen::Index>(a)];
    x = static_cast<float>(position_[a].filter(frame.time, static_cast<double>(x)));
  }
}

void Smoothing::apply(face::OutputFrame& frame) {
  if (settings_.weights) {
    for (std::size_t i = 0; i < face::kShapeCount; ++i)
      frame.weights[i] = static_cast<float>(weights_[i].filter(frame.time, frame.weights[i]));
    frame.tongue_out = static_cast<float>(weights_.back().filter(frame.time, frame.tongue_out));
  }
  if (settings_.head) frame.head = head_.filter(frame.time, frame.head);
  if (settings_.position) smooth_position(frame);
}

}  // namespace mien::shaping
