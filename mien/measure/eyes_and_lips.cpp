#include "mien/measure/eyes_and_lips.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "mien/core/quantile.h"
#include "mien/core/units.h"

namespace mien::measure {
namespace {

// Multi-PIE's landmarks, of 68: pairs of an upper and a lower one.
constexpr std::pair<std::size_t, std::size_t> kLeftLids[] = {{43, 47}, {44, 46}};
constexpr std::pair<std::size_t, std::size_t> kRightLids[] = {{37, 41}, {38, 40}};
constexpr std::pair<std::size_t, std::size_t> kLips[] = {{62, 66}};

/// A truth whose eyes never turn further than this share of their range was recorded without them.
constexpr float kStillEyes = 0.01F;

Vec3f direction(const Eigen::Vector2f& angles_rad) {
  const float yaw = angles_rad.x(), pitch = angles_rad.y();
  return {std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch)};
}

double angle_deg(const Eigen::Vector2f& a_rad, const Eigen::Vector2f& b_rad) {
  const Vec3f a = direction(a_rad), b = direction(b_rad);
  return kDegPerRad * std::atan2(a.cross(b).norm(), a.dot(b));
}

bool looks_aside(const face::BlendshapeWeights& weights) {
  return std::ranges::any_of(face::eyes_rad(weights), [](const Eigen::Vector2f& eye) {
    return eye.cwiseAbs().maxCoeff() > kStillEyes * static_cast<float>(face::kEyeTurnRadPerUnit);
  });
}

face::BlendshapeWeights clipped_weights(face::BlendshapeWeights weights) {
  for (std::size_t k = 0; k < face::kShapeCount; ++k) weights[k] = std::clamp(weights[k], 0.0F, 1.0F);
  return weights;
}

/// Pearson's correlation of pairs; absent where either side stands still.
class Correlation {
 public:
  void add(double x, double y) { pairs_.emplace_back(x, y); }
  [[nodiscard]] std::optional<double> value() const {
    const auto count = static_cast<double>(pairs_.size());
    double mean_x = 0, mean_y = 0, xx = 0, yy = 0, xy = 0;
    for (const auto& [x, y] : pairs_) {
      mean_x += x / count;
      mean_y += y / count;
    }
    for (const auto& [x, y] : pairs_) {
      xx += (x - mean_x) * (x - mean_x);
      yy += (y - mean_y) * (y - mean_y);
      xy += (x - mean_x) * (y - mean_y);
    }
    constexpr double kStill = 1e-12;  // Of the variance.
    if (!(xx > kStill * count && yy > kStill * count)) return std::nullopt;
    return xy / std::sqrt(xx * yy);
  }

 private:
  std::vector<std::pair<double, double>> pairs_;
};

}  // namespace

float EyesAndLipsMeter::Gap::at(const face::BlendshapeWeights& weights) const {
  float gap = neutral;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    gap += std::clamp(weights[k], 0.0F, 1.0F) * per_weight[k];
  return gap;
}

EyesAndLipsMeter::EyesAndLipsMeter(const face::Face& face) : has_landmarks_(face.has_landmarks) {
  if (!has_landmarks_) return;
  constexpr float kMmPerM = 1000;
  const auto gap_of = [&](std::span<const std::pair<std::size_t, std::size_t>> pairs) {
    Gap gap;
    const auto add = [&](std::size_t landmark, float share) {
      const std::uint32_t vertex = face.landmarks[landmark];
      gap.neutral += share * face.neutral_m[vertex].y();
      for (std::size_t k = 0; k < std::min(face.shapes.size(), face::kShapeCount); ++k) {
        const face::Shape& shape = face.shapes[k];
        const auto found = std::ranges::lower_bound(shape.vertex, vertex);
        if (found != shape.vertex.end() && *found == vertex)
          gap.per_weight[k] +=
              share * shape.delta_m[static_cast<std::size_t>(found - shape.vertex.begin())].y();
      }
    };
    for (const auto& [upper, lower] : pairs) {
      add(upper, kMmPerM / static_cast<float>(pairs.size()));
      add(lower, -kMmPerM / static_cast<float>(pairs.size()));
    }
    return gap;
  };
  lids_ = {gap_of(kLeftLids), gap_of(kRightLids)};
  lips_ = gap_of(kLips);
}

std::array<float, 2> EyesAndLipsMeter::openness(const face::BlendshapeWeights& weights) const {
  std::array<float, 2> open{1, 1};
  for (std::size_t e = 0; e < open.size(); ++e)
    if (lids_[e].neutral > 0) open[e] = std::max(0.0F, lids_[e].at(weights) / lids_[e].neutral);
  return open;
}

float EyesAndLipsMeter::lip_gap_mm(const face::BlendshapeWeights& weights) const {
  return lips_.at(weights);
}

EyesAndLips EyesAndLipsMeter::measure(std::span<const Stretch> stretches) const {
  EyesAndLips out;
  if (!has_landmarks_) return out;
  std::vector<double> angles_deg;
  Correlation open;
  bool eyes_move = false;
  std::size_t both_closed = 0, truth_closed = 0, estimate_closed = 0;
  for (const Stretch& stretch : stretches)
    for (std::size_t f = 0; f < stretch.truth.size(); ++f) {
      const face::BlendshapeWeights truth = clipped_weights(stretch.truth[f]),
                                    estimate = clipped_weights(stretch.estimate[f]);
      const auto true_eyes = face::eyes_rad(truth);
      const auto eyes = stretch.gaze_rad.empty() ? face::eyes_rad(estimate) : stretch.gaze_rad[f];
      const auto true_open = openness(truth), solved_open = openness(estimate);
      eyes_move = eyes_move || looks_aside(truth);
      for (std::size_t e = 0; e < 2; ++e) {
        open.add(true_open[e], solved_open[e]);
        if (true_open[e] >= kOpenEye) angles_deg.push_back(angle_deg(true_eyes[e], eyes[e]));
      }
      const bool true_lips = lip_gap_mm(truth) < kClosedLips_mm;
      const bool solved_lips = lip_gap_mm(estimate) < kClosedLips_mm;
      truth_closed += true_lips ? 1 : 0;
      estimate_closed += solved_lips ? 1 : 0;
      both_closed += true_lips && solved_lips ? 1 : 0;
    }
  if (eyes_move && !angles_deg.empty()) {
    std::ranges::sort(angles_deg);
    out.gaze_deg =
        EyesAndLips::Angle{quantile_of_sorted(angles_deg, 0.5), quantile_of_sorted(angles_deg, 0.9)};
  }
  out.openness_pearson = open.value();
  if (truth_closed + estimate_closed > 0)
    out.lip_gap_f1 =
        2.0 * static_cast<double>(both_closed) / static_cast<double>(truth_closed + estimate_closed);
  return out;
}

}  // namespace mien::measure
