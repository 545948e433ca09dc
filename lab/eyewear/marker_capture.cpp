#include "lab/eyewear/marker_capture.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace mien::lab {
namespace {

double until_next_s(Random& random, double per_min) {
  return per_min > 0 ? random.exponential(60 / per_min) : std::numeric_limits<double>::infinity();
}

}  // namespace

MarkerCapture::MarkerCapture(const virt::EyewearFaults& faults, std::vector<Vec3> neutral_m,
                             const Random& random)
    : faults_(faults),
      neutral_m_(std::move(neutral_m)),
      jitter_(random.fork("jitter")),
      mislabels_(random.fork("mislabel")),
      losses_(random.fork("lost")) {
  next_mislabel(0);
  next_loss(0);
}

void MarkerCapture::next_mislabel(double after_s) {
  mislabel_.begin_s = after_s + until_next_s(mislabels_, faults_.mislabel_per_min);
  mislabel_.end_s = mislabel_.begin_s + mislabels_.exponential(faults_.mislabel_s);
  mislabel_.marker = mislabel_.other = mislabels_.below(neutral_m_.size());
  // The nearest other one.
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < neutral_m_.size(); ++i) {
    const double square = (neutral_m_[i] - neutral_m_[mislabel_.marker]).squaredNorm();
    if (i != mislabel_.marker && square < best) {
      best = square;
      mislabel_.other = i;
    }
  }
}

void MarkerCapture::next_loss(double after_s) {
  loss_.begin_s = after_s + until_next_s(losses_, faults_.lost_per_min);
  loss_.end_s = loss_.begin_s + losses_.exponential(faults_.lost_s);
  loss_.marker = losses_.below(neutral_m_.size());
  for (Eigen::Index i = 0; i < 3; ++i) loss_.off_m[i] = losses_.normal(0, 1e-3 * faults_.lost_mm);
}

Eigen::VectorXd MarkerCapture::capture(double time_s, const Eigen::VectorXd& markers_m) {
  while (mislabel_.end_s <= time_s) next_mislabel(mislabel_.end_s);
  while (loss_.end_s <= time_s) next_loss(loss_.end_s);
  Eigen::VectorXd seen = markers_m;
  const auto of = [&](std::size_t marker) { return seen.segment<3>(3 * static_cast<Eigen::Index>(marker)); };
  if (loss_.begin_s <= time_s) of(loss_.marker) += loss_.off_m;
  if (mislabel_.begin_s <= time_s) {
    const Vec3 first = of(mislabel_.marker);
    of(mislabel_.marker) = of(mislabel_.other);
    of(mislabel_.other) = first;
  }
  for (Eigen::Index i = 0; i < seen.size(); ++i)
    seen[i] += jitter_.normal(0, 1e-3 * faults_.marker_jitter_mm);
  return seen;
}

}  // namespace mien::lab
