#include "lab/eyewear/marker_errors.h"

#include <cmath>
#include <utility>

#include "mien/core/units.h"

namespace mien::lab {
namespace {}  // namespace

void MarkerSums::add(const Eigen::VectorXd& estimate_m, const Eigen::VectorXd& truth_m) {
  const Eigen::Index markers = truth_m.size() / 3;
  if (samples_ == 0) {
    distance_mm_ = Eigen::ArrayXd::Zero(markers);
    square_mm2_ = Eigen::ArrayXd::Zero(markers);
  }
  ++samples_;
  for (Eigen::Index m = 0; m < markers; ++m) {
    const double mm = kMmPerM * (estimate_m - truth_m).segment<3>(3 * m).norm();
    distance_mm_[m] += mm;
    square_mm2_[m] += mm * mm;
  }
}

void MarkerSums::add(const Eigen::MatrixXd& estimate_m, const Eigen::MatrixXd& truth_m) {
  for (Eigen::Index i = 0; i < truth_m.rows(); ++i)
    add(Eigen::VectorXd(estimate_m.row(i)), Eigen::VectorXd(truth_m.row(i)));
}

MarkerSums& MarkerSums::operator+=(const MarkerSums& more) {
  if (samples_ == 0) return *this = more;
  if (more.samples_ == 0) return *this;
  samples_ += more.samples_;
  distance_mm_ += more.distance_mm_;
  square_mm2_ += more.square_mm2_;
  return *this;
}

MarkerError MarkerSums::over(const std::vector<std::size_t>& markers) const {
  MarkerError error;
  if (samples_ == 0 || markers.empty()) return error;
  const auto samples = static_cast<double>(samples_);
  for (const std::size_t m : markers) {
    error.mean_mm += distance_mm_[static_cast<Eigen::Index>(m)] / samples;
    error.rmse_mm += std::sqrt(square_mm2_[static_cast<Eigen::Index>(m)] / samples);
  }
  error.mean_mm /= static_cast<double>(markers.size());
  error.rmse_mm /= static_cast<double>(markers.size());
  return error;
}

SensorsMethod sum_up(std::string name, std::size_t sensors,
                     const std::vector<std::vector<MarkerSums>>& wearers,
                     const std::vector<SensorsTest>& tests, const builtin_face::MarkerSet& markers) {
  std::vector<std::size_t> every(markers.markers.size());
  for (std::size_t m = 0; m < every.size(); ++m) every[m] = m;
  const std::vector<std::size_t> eyes = markers.of(builtin_face::MarkerRegion::eyes_nose);
  const std::vector<std::size_t> mouth = markers.of(builtin_face::MarkerRegion::mouth);
  const auto row = [&](const MarkerSums& sums) {
    return SensorsRow{sums.over(every), sums.over(eyes), sums.over(mouth)};
  };
  SensorsMethod out;
  out.name = std::move(name);
  out.sensors = sensors;
  MarkerSums all;
  std::array<MarkerSums, kTestSets> sets;
  std::vector<MarkerSums> each(tests.size());
  for (const std::vector<MarkerSums>& of_tests : wearers) {
    MarkerSums wearer;
    for (std::size_t t = 0; t < tests.size(); ++t) {
      wearer += of_tests[t];
      each[t] += of_tests[t];
      sets[static_cast<std::size_t>(tests[t].set)] += of_tests[t];
    }
    out.wearers.push_back(row(wearer));
    all += wearer;
  }
  out.overall = row(all);
  for (std::size_t s = 0; s < kTestSets; ++s) out.sets[s] = row(sets[s]);
  for (const MarkerSums& sums : each) out.tests.push_back(row(sums));
  for (const std::size_t m : every) out.markers.push_back(all.over({m}));
  return out;
}

}  // namespace mien::lab
