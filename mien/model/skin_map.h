#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace mien::model {

/// How the patches of skin under a model's n sensors turn with the weights, and what is known of the weights
/// beforehand. Slopes are rotation vectors (frame H, rad) per unit weight, 3n x shapes, row-major, row 3 s +
/// axis: what E of sensor s does with a shape alone.
struct Skin {
  std::vector<float> standard;    ///< Of the skin that the network was trained for.
  std::vector<float> covariance;  ///< Of the training set's weights, shapes x shapes.
  std::vector<float> wearer;      ///< Of the wearer whose model this is; empty: nobody's yet.
};

/// A slope in millionths of a radian, as learnt slopes are kept: a float's own digits would be twice as many
/// in text, and these bring the same float back.
[[nodiscard]] inline double in_millionths(double slope) {
  return std::round(1e6 * slope) / 1e6;
}

/// Tells what a wearer's sensors would say on the skin that a network was trained for: with the likeliest
/// weights of the frame, linear in its rotations, the wearer's slopes are taken out and the standard's put
/// in. What the slopes do not explain stays as it is, noise included.
///
/// With rotation vectors r, slopes H and H0, mean weights m and their covariance S:
///   w = m + S H' (H S H' + R)^-1 (r - H m),   r becomes r + (H0 - H) w.
/// A sensor that is missing says nothing of w. No allocation after construction.
class SkinMap {
 public:
  /// `skin.wearer` is not empty. `mean`: the training set's mean weights. Sizes agree.
  SkinMap(const Skin& skin, std::span<const float> mean);

  /// `values`: 7n numbers (acceleration xyz, rotation wxyz a sensor), of which the rotations that are there
  /// are changed; `present`: whether each is, n or more flags.
  void apply(std::span<float> values, std::span<const std::uint8_t> present);

 private:
  void listen_to(std::span<const std::uint8_t> present);

  Eigen::Index sensors_;
  Eigen::MatrixXd spread_;  ///< H S H' + R of all sensors.
  Eigen::MatrixXd moved_;   ///< (H0 - H) S H'.
  Eigen::VectorXd rest_;    ///< H m: what the sensors say of the mean pose.
  Eigen::VectorXd shift_;   ///< (H0 - H) m.
  std::vector<std::uint8_t> masked_for_;
  Eigen::MatrixXd masked_;  ///< spread_ with those that are missing as unsure as can be.
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::VectorXd turn_, innovation_;
};

}  // namespace mien::model
