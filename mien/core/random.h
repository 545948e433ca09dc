#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "mien/core/rotation.h"

namespace mien {

/// Random numbers that do not depend on the compiler or its library: xoshiro256++ seeded by splitmix64
/// (Blackman and Vigna 2021, doi:10.1145/3460772), and our own distributions, since std:: ones differ.
/// bits(), uniform(), below() and chance() are the same on every machine; the others go through the C
/// library's log, exp, sin and cos, whose last bit may differ between CPU families
/// (docs/reference/determinism.md).
class Random {
 public:
  explicit Random(std::uint64_t seed);

  /// An independent stream for one purpose: the same seed and name give the same stream, and drawing
  /// from one never moves another. `root.fork("blink")`, `root.fork("imu", 3)`.
  [[nodiscard]] Random fork(std::string_view name, std::uint64_t index = 0) const;

  std::uint64_t bits();
  /// In [0, 1).
  double uniform();
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// In 0..count-1; count > 0.
  std::uint64_t below(std::uint64_t count);
  bool chance(double probability) { return uniform() < probability; }
  /// Mean 0, standard deviation 1 (Marsaglia's polar method).
  double normal();
  double normal(double mean, double sigma) { return mean + sigma * normal(); }
  /// Three independent components of mean 0 and this standard deviation.
  Vec3 normal_vector(double sigma);
  /// exp(normal(0, sigma)): a factor around 1.
  double log_normal(double sigma);
  /// Mean `mean`.
  double exponential(double mean);
  /// Evenly spread on the unit sphere.
  Vec3 direction();
  /// Evenly spread over all orientations.
  Quat rotation();

  /// State, for resuming bit for bit.
  struct State {
    std::array<std::uint64_t, 4> words{};
    std::uint64_t seed = 0;
    double spare = 0;
    bool has_spare = false;
  };
  [[nodiscard]] const State& state() const { return state_; }
  void restore(const State& state) { state_ = state; }

 private:
  State state_;
};

}  // namespace mien
