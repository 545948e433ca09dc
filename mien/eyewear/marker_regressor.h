#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "mien/model/confidence.h"

namespace mien::eyewear {

/// Input of a regressor at one frame; one entry a sensor, in the rig's order.
struct LightFrame {
  std::vector<float> values;  ///< Feature: (log light - neutral) / range, within kLimit; 0 where missing.
  std::vector<std::uint8_t> present;  ///< 0 where missing.
};

/// Interface of causal models from the sensors' light to markers, frame by frame. Thread: one at a time.
class MarkerRegressor {
 public:
  virtual ~MarkerRegressor() = default;
  /// The next frame of the 60 Hz grid. `displacement_m`: 3 marker_count() displacements from neutral of the
  /// marker set on the built-in face's default identity, x, y, z of marker 0, then of marker 1; metres, frame
  /// H. No allocation once it has that size.
  virtual void step(const LightFrame& light, Eigen::VectorXd& displacement_m) = 0;
  /// Resets the state.
  virtual void reset() = 0;
  [[nodiscard]] virtual std::size_t marker_count() const = 0;

  /// What weights from its markers are worth; none where nobody measured it.
  [[nodiscard]] virtual const model::ConfidenceTable* confidence() const { return nullptr; }
  /// The share of the sensors that it reads which were there in the last step, 0 to 1.
  [[nodiscard]] virtual float coverage() const = 0;
};

}  // namespace mien::eyewear
