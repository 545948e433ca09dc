#pragma once

#include <cstddef>
#include <vector>

#include "mien/model/confidence.h"

namespace mien::synthetic {

/// Logistic regression of one score by maximum likelihood. Scores are summed up in bins a two-hundredth wide,
/// each of which stands at its mean, so memory does not grow and sums of parts are exact.
class LogisticFit {
 public:
  LogisticFit() : bins_(kBins) {}

  /// `hit`: whether it came true; counted so many times. A score beyond kLimit counts as kLimit.
  void add(float score, bool hit, double times = 1);
  void add(const LogisticFit& other);
  [[nodiscard]] double frames() const;

  /// Newton's method, each step halved until the likelihood does not fall. A normal prior of kPriorSigma
  /// about 0 keeps both parameters finite where every frame, or none, came true; without frames they are 0.
  [[nodiscard]] model::LogisticMap solve() const;

  static constexpr float kLimit = 8;
  static constexpr double kPriorSigma = 10;

 private:
  struct Bin {
    double frames = 0, hits = 0, score = 0;  // Sums.
  };
  static constexpr std::size_t kBins = 3200;
  [[nodiscard]] double log_likelihood(double offset, double slope) const;

  std::vector<Bin> bins_;
};

}  // namespace mien::synthetic
