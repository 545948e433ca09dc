#pragma once

#include <cmath>

namespace mien::study {

/// Pearson's correlation of the pairs that are added.
class Correlation {
 public:
  void add(double a, double b) {
    ++n_;
    a_ += a;
    b_ += b;
    aa_ += a * a;
    bb_ += b * b;
    ab_ += a * b;
  }
  /// 0 where one of the two never changes.
  [[nodiscard]] double value() const {
    const double below = (n_ * aa_ - a_ * a_) * (n_ * bb_ - b_ * b_);
    return below <= 0 ? 0 : (n_ * ab_ - a_ * b_) / std::sqrt(below);
  }

 private:
  double n_ = 0, a_ = 0, b_ = 0, aa_ = 0, bb_ = 0, ab_ = 0;
};

}  // namespace mien::study
