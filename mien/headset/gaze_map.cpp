#include "mien/headset/gaze_map.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

namespace mien::headset {
namespace {

/// Ridge, rad^2: against targets 15 degrees off, whose squares sum to 0.14 an axis, it takes a fifteenth of a
/// gain's distance from 1. Raising trusts the network more, and the wearer less.
constexpr double kRidge = 0.01;
constexpr float kMostOffset_rad = 1.1F;

constexpr std::size_t kNumbers = 6;

/// One eye at one target.
struct Looked {
  Eigen::Vector2f known_rad, found_rad;
};

/// Fitted to all but one.
GazeMap::Affine fit_eye(std::span<const Looked> looked, std::size_t left_out) {
  // Towards the identity: what is fitted is the rest.
  Eigen::Vector2d mean_found = Eigen::Vector2d::Zero(), mean_rest = Eigen::Vector2d::Zero();
  double count = 0;
  const auto each = [&](auto&& add) {
    for (std::size_t s = 0; s < looked.size(); ++s)
      if (s != left_out)
        add(looked[s].found_rad.cast<double>().eval(),
            (looked[s].known_rad - looked[s].found_rad).cast<double>().eval());
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

double square_error(const GazeMap::Affine& map, const Looked& at) {
  const Eigen::Vector2f shown = map * at.found_rad.homogeneous();
  return (shown - at.known_rad).cast<double>().squaredNorm();
}

/// Neither turns round nor blows up what it is given.
bool is_sane(const GazeMap::Affine& map) {
  const Eigen::Matrix2d gains = map.leftCols<2>().cast<double>();
  const Eigen::Vector2d singular = Eigen::JacobiSVD<Eigen::Matrix2d>(gains).singularValues();
  return gains.determinant() > 0 && singular.minCoeff() >= kLeastGain && singular.maxCoeff() <= kMostGain &&
         map.col(2).cwiseAbs().maxCoeff() <= kMostOffset_rad;
}

}  // namespace

void GazeMap::correct(Answer& answer) const {
  for (std::size_t eye = 0; eye < 2; ++eye) {
    const Eigen::Vector2f shown = apply(eye, {answer.gaze_rad[2 * eye], answer.gaze_rad[2 * eye + 1]});
    for (std::size_t axis = 0; axis < 2; ++axis)
      answer.gaze_rad[2 * eye + axis] =
          std::clamp(shown[static_cast<Eigen::Index>(axis)], -kMostGaze_rad, kMostGaze_rad);
  }
}

GazeMap GazeMap::gains() const {
  GazeMap map = *this;
  for (Affine& eye : map.eyes) eye.col(2).setZero();
  return map;
}

Result<GazeFit> fit_gaze_map(std::span<const GazeSample> samples) {
  GazeFit fit;
  std::size_t most = 0;
  for (std::size_t eye = 0; eye < 2; ++eye) {
    std::vector<Looked> looked;
    for (const GazeSample& sample : samples) {
      if (!sample.found_rad[eye]) continue;
      if (!sample.known_rad.allFinite() || !sample.found_rad[eye]->allFinite())
        return fail(ErrorCode::out_of_range, "a direction that is no number", "gaze calibration");
      looked.push_back({sample.known_rad, *sample.found_rad[eye]});
    }
    most = std::max(most, looked.size());
    if (looked.size() < kLeastTargets) continue;
    fit.fitted[eye] = true;
    const auto count = static_cast<double>(looked.size());
    double before = 0, held_out = 0;
    for (std::size_t s = 0; s < looked.size(); ++s) {
      before += square_error(GazeMap::Affine::Identity(), looked[s]);
      held_out += square_error(fit_eye(looked, s), looked[s]);
    }
    fit.before[eye] = std::sqrt(before / count);
    fit.held_out[eye] = std::sqrt(held_out / count);
    const GazeMap::Affine whole = fit_eye(looked, looked.size());
    fit.kept[eye] = held_out < before && is_sane(whole);
    if (fit.kept[eye]) fit.map.eyes[eye] = whole;
  }
  if (most < kLeastTargets)
    return fail(ErrorCode::out_of_range, fmt::format("the eyes were seen at {} targets", most),
                "gaze calibration", fmt::format("look at {} of them at least", kLeastTargets));
  return fit;
}

std::string write_gaze_map(const GazeMap& map) {
  nlohmann::json eyes = nlohmann::json::array();
  for (const GazeMap::Affine& eye : map.eyes) {
    nlohmann::json& numbers = eyes.emplace_back(nlohmann::json::array());
    for (Eigen::Index row = 0; row < 2; ++row)
      for (Eigen::Index column = 0; column < 3; ++column) numbers.push_back(eye(row, column));
  }
  return nlohmann::json({{"gaze", std::move(eyes)}}).dump();
}

Result<GazeMap> parse_gaze_map(std::string_view text, const std::string& where) {
  const nlohmann::json root = nlohmann::json::parse(text, nullptr, false);
  const auto refused = [&] {
    return fail(ErrorCode::malformed, fmt::format("'gaze' is no list of two with {} numbers each", kNumbers),
                where);
  };
  if (!root.is_object()) return fail(ErrorCode::malformed, "not a JSON object", where);
  const auto eyes = root.find("gaze");
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
