#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "mien/core/random.h"
#include "mien/core/rotation.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"
#include "mien/tracker/prompted_expression.h"

namespace mien::tracker::test {

inline constexpr std::size_t kSensors = 4;
inline constexpr auto kShapes = static_cast<Eigen::Index>(face::kShapeCount);
inline const std::vector<std::string> kNames = {"a", "b", "c", "d"};
inline constexpr double kPrompt_s = 2;
inline constexpr std::size_t kAsked = 15;  // Shapes, each of them twice.

/// Slopes of which each shape turns two sensors.
inline Eigen::MatrixXd draw_slopes(Random& random) {
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(3 * kSensors, kShapes);
  for (Eigen::Index k = 0; k < kShapes; ++k)
    for (int i = 0; i < 2; ++i) {
      const auto s = static_cast<Eigen::Index>(random.below(kSensors));
      for (Eigen::Index axis = 0; axis < 3; ++axis) slopes(3 * s + axis, k) = 0.25 * random.normal();
    }
  return slopes;
}

inline std::vector<float> row_major(const Eigen::MatrixXd& m) {
  std::vector<float> out;
  for (Eigen::Index row = 0; row < m.rows(); ++row)
    for (Eigen::Index k = 0; k < m.cols(); ++k) out.push_back(static_cast<float>(m(row, k)));
  return out;
}

/// A wearer whose skin differs from the standard, asked for fifteen shapes, one after the other, and again.
struct Minute {
  Eigen::MatrixXd standard, wearer;
  std::vector<PromptedExpression> prompts;
  std::vector<model::FeatureFrame> features;

  explicit Minute(std::uint64_t seed, double spread = 0.35) {
    Random random(seed);
    standard = draw_slopes(random);
    wearer = standard;
    for (double& slope : wearer.reshaped()) slope *= 1 + spread * random.normal();
    for (std::size_t p = 0; p < 30; ++p) {
      PromptedExpression& prompt = prompts.emplace_back();
      prompt.begin = DeviceTime(from_seconds(1 + kPrompt_s * static_cast<double>(p)));
      prompt.end = prompt.begin + from_seconds(kPrompt_s);
      prompt.target[p % kAsked] = 1;
      const double gain = random.uniform(0.7, 1.1), late_s = random.uniform(0.2, 0.5);
      for (int f = 0; f < 120; ++f) {
        const double t = f / 60.0 - late_s;
        const double reached = std::clamp(std::min(t, 1.3 - t) / 0.4, 0.0, 1.0);
        model::FeatureFrame& frame = features.emplace_back();
        frame.time = prompt.begin + from_seconds(f / 60.0);
        frame.sensors.resize(kSensors);
        for (std::size_t s = 0; s < kSensors; ++s) {
          Vec3 turn =
              gain * reached *
              wearer.block<3, 1>(3 * static_cast<Eigen::Index>(s), static_cast<Eigen::Index>(p % kAsked));
          for (double& axis : turn) axis += random.normal(0, 0.01);
          const Quat q = canonical(exp_rotation(turn));
          frame.sensors[s].rotation = {static_cast<float>(q.w()), static_cast<float>(q.x()),
                                       static_cast<float>(q.y()), static_cast<float>(q.z())};
          frame.sensors[s].has_rotation = true;
        }
      }
    }
  }

  [[nodiscard]] model::ModelFile model() const {
    model::ModelFile file;
    file.features.sensors = kNames;
    file.shapes.assign(face::kShapeNames.begin(), face::kShapeNames.end());
    file.skin = model::Skin{.standard = row_major(standard),
                            .covariance = row_major(0.02 * Eigen::MatrixXd::Identity(kShapes, kShapes)),
                            .wearer = {}};
    return file;
  }
  /// How far slopes of the prompted shapes are from the wearer's, over how far the standard's are.
  [[nodiscard]] double left(const std::vector<float>& slopes) const {
    double is = 0, was = 0;
    for (Eigen::Index row = 0; row < wearer.rows(); ++row)
      for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(kAsked); ++k) {
        is += std::pow(slopes[static_cast<std::size_t>(row * kShapes + k)] - wearer(row, k), 2);
        was += std::pow(standard(row, k) - wearer(row, k), 2);
      }
    return std::sqrt(is / was);
  }
};

}  // namespace mien::tracker::test
