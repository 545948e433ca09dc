#include "mien/eyewear/linearise.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace mien::eyewear {
namespace {

constexpr int kMostDegree = 8;

}  // namespace

Result<Linearisation> Linearisation::fit(std::span<const BenchReading> readings, int degree) {
  if (degree < 1 || degree > kMostDegree)
    return fail(ErrorCode::bad_usage, "the polynomial's degree is not between 1 and 8", "linearisation");
  const auto sound = [](const BenchReading& r) {
    return std::isfinite(r.distance_m) && std::isfinite(r.light) && r.distance_m > 0 && r.light > 0;
  };
  if (!std::ranges::all_of(readings, sound))
    return fail(ErrorCode::out_of_range, "a bench reading is not above zero", "linearisation",
                "leave out distances at which the sensor sees nothing");
  const auto peak = std::ranges::max_element(readings, {}, &BenchReading::light);
  std::vector<BenchReading> beyond;
  for (const BenchReading& reading : readings)
    if (reading.distance_m >= peak->distance_m) beyond.push_back(reading);
  if (beyond.size() < static_cast<std::size_t>(degree) + 2)
    return fail(ErrorCode::bad_usage, "too few bench readings beyond the peak", "linearisation",
                "measure more distances, or lower the degree");

  Linearisation out;
  const auto [dimmest, brightest] = std::ranges::minmax_element(beyond, {}, &BenchReading::light);
  out.dimmest_ = dimmest->light;
  out.brightest_ = brightest->light;
  const double low = std::log(out.dimmest_);
  const double high = std::log(out.brightest_);
  out.centre_ = 0.5 * (low + high);
  out.scale_ = std::max(0.5 * (high - low), 1e-9);
  Eigen::MatrixXd powers(static_cast<Eigen::Index>(beyond.size()), degree + 1);
  Eigen::VectorXd distances(powers.rows());
  for (Eigen::Index i = 0; i < powers.rows(); ++i) {
    const BenchReading& reading = beyond[static_cast<std::size_t>(i)];
    const double x = (std::log(reading.light) - out.centre_) / out.scale_;
    powers(i, 0) = 1;
    for (int p = 1; p <= degree; ++p) powers(i, p) = powers(i, p - 1) * x;
    distances[i] = reading.distance_m;
  }
  const Eigen::VectorXd solved = powers.colPivHouseholderQr().solve(distances);
  out.coefficients_.assign(solved.data(), solved.data() + solved.size());
  return out;
}

double Linearisation::distance_m(double light) const {
  const double x = (std::log(std::clamp(light, dimmest_, brightest_)) - centre_) / scale_;
  double sum = 0;
  for (std::size_t p = coefficients_.size(); p-- > 0;) sum = sum * x + coefficients_[p];
  return sum;
}

}  // namespace mien::eyewear
