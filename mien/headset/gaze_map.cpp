#include "mien/headset/gaze_map.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace mien::headset {
namespace {

/// Ridge, rad^2: against targets 15 degrees off, whose squares sum to 0.14 an axis, it takes a fifteenth of a
/// gain's distance from 1. Raising trusts the network more, and the wearer less.
constexpr double kRidge = 0.01;
constexpr float kAside_rad = 0.2618F, kUp_rad = 0.1745F;  // 15 and 10 degrees.
constexpr float kMostOffset_rad = 1.1F;

constexpr std::size_t kNumbers = 6;

/// Fitted to all samples but one.
GazeMap::Affine fit_eye(std::span<const GazeSample> samples, std::size_t eye, std::size_t left_out) {
  // Towards the identity: what is fitted is the rest.
  Eigen::Vector2d mean_found = Eigen::Vector2d::Zero(), mean_rest = Eigen::Vector2d::Zero();
  double count = 0;
  const auto each = [&](auto&& add) {
    for (std::size_t s = 0; s < samples.size(); ++s)
      if (s != left_out)
        add(samples[s].found_rad[eye].cast<double>().eval(),
            (samples[s].known_rad - samples[s].found_rad[eye]).cast<double>().eval());
  };
  each([&](const Eigen::Vector2d& found, const Eigen::Vector2d& rest) {
    mean_found += found;
    mean_rest += rest;
    count += 1;
  });
  mean_found /= count;
  mean_rest /= count;
  Eigen::Matrix2d squares = kRidge * Eigen::Matrix2d::Identity(), products = Eigen::Matrix2d::Zero();
  each([&](const Eigen::Vector2d& found, const Eigen::Vector2d& rest) {
    squares += (found - mean_found) * (found - mean_found).transpose();
    products += (rest - mean_rest) * (found - mean_found).transpose();
  });
  const Eigen::Matrix2d slope = products * squares.inverse();
  GazeMap::Affine map;
  map.leftCols<2>() = (Eigen::Matrix2d::Identity() + slope).cast<float>();
  map.col(2) = (mean_rest - slope * mean_found).cast<float>();
  return map;
}

double square_error(const GazeMap::Affine& map, const GazeSample& sample, std::size_t eye) {
  const Eigen::Vector2f shown = map * sample.found_rad[eye].homogeneous();
  return (shown - sample.known_rad).cast<double>().squaredNorm();
}

/// Neither turns round nor blows up what it is given.
bool is_sane(const GazeMap::Affine& map) {
  const Eigen::Matrix2d gains = map.leftCols<2>().cast<double>();
  const Eigen::Vector2d singular = Eigen::JacobiSVD<Eigen::Matrix2d>(gains).singularValues();
  return gains.determinant() > 0 && singular.minCoeff() >= kLeastGain && singular.maxCoeff() <= kMostGain &&
         map.col(2).cwiseAbs().maxCoeff() <= kMostOffset_rad;
}

}  // namespace

std::span<const GazeTarget> gaze_targets() {
  static const std::array<GazeTarget, 5> kTargets = {{{"look ahead", Eigen::Vector2f(0, 0)},
                                                      {"look left", Eigen::Vector2f(kAside_rad, 0)},
                                                      {"look right", Eigen::Vector2f(-kAside_rad, 0)},
                                                      {"look up", Eigen::Vector2f(0, kUp_rad)},
                                                      {"look down", Eigen::Vector2f(0, -kUp_rad)}}};
  return kTargets;
}

Result<GazeFit> fit_gaze_map(std::span<const GazeSample> samples) {
  if (samples.size() < kLeastTargets)
    return fail(ErrorCode::out_of_range, fmt::format("{} targets were looked at", samples.size()),
                "gaze calibration", fmt::format("look at {} of them at least", kLeastTargets));
  for (const GazeSample& sample : samples)
    if (!sample.known_rad.allFinite() || !sample.found_rad[0].allFinite() || !sample.found_rad[1].allFinite())
      return fail(ErrorCode::out_of_range, "a direction that is no number", "gaze calibration");
  GazeFit fit;
  const auto count = static_cast<double>(samples.size());
  for (std::size_t eye = 0; eye < 2; ++eye) {
    double before = 0, held_out = 0;
    for (std::size_t s = 0; s < samples.size(); ++s) {
      before += square_error(GazeMap::Affine::Identity(), samples[s], eye);
      held_out += square_error(fit_eye(samples, eye, s), samples[s], eye);
    }
    fit.before[eye] = std::sqrt(before / count);
    fit.held_out[eye] = std::sqrt(held_out / count);
    const GazeMap::Affine whole = fit_eye(samples, eye, samples.size());
    fit.kept[eye] = held_out < before && is_sane(whole);
    if (fit.kept[eye]) fit.map.eyes[eye] = whole;
  }
  return fit;
}

std::string write_gaze_map(const GazeMap& map) {
  nlohmann::json eyes = nlohmann::json::array();
  for (const GazeMap::Affine& eye : map.eyes) {
    nlohmann::json& numbers = eyes.emplace_back(nlohmann::json::array());
    for (Eigen::Index row = 0; row < 2; ++row)
      for (Eigen::Index column = 0; column < 3; ++column) numbers.push_back(eye(row, column));
  }
  return nlohmann::json({{"eyes", std::move(eyes)}}).dump();
}

Result<GazeMap> parse_gaze_map(std::string_view text, const std::string& where) {
  const nlohmann::json root = nlohmann::json::parse(text, nullptr, false);
  const auto refused = [&] {
    return fail(ErrorCode::malformed, fmt::format("'eyes' is no list of two with {} numbers each", kNumbers),
                where);
  };
  if (!root.is_object()) return fail(ErrorCode::malformed, "not a JSON object", where);
  const auto eyes = root.find("eyes");
  if (eyes == root.end() || !eyes->is_array() || eyes->size() != 2) return refused();
  GazeMap map;
  for (std::size_t e = 0; e < 2; ++e) {
    const nlohmann::json& numbers = (*eyes)[e];
    if (!numbers.is_array() || numbers.size() != kNumbers) return refused();
    for (std::size_t i = 0; i < kNumbers; ++i) {
      if (!numbers[i].is_number()) return refused();
      // Held first: what no float holds is none.
      const double value = numbers[i].get<double>();
      map.eyes[e](static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3)) =
          static_cast<float>(std::clamp(value, -2 * kMostGain, 2 * kMostGain));
    }
    if (!map.eyes[e].allFinite() || !is_sane(map.eyes[e]))
      return fail(ErrorCode::out_of_range, "a map that no calibration makes", where, "calibrate anew");
  }
  return map;
}

}  // namespace mien::headset
