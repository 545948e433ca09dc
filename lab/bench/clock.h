#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/core/time.h"
#include "mien/model/aligned.h"

namespace mien::lab {

/// What benchmarks measure with.
using Clock = std::chrono::steady_clock;

[[nodiscard]] inline double seconds_since(Clock::time_point from) {
  return to_seconds(Clock::now() - from);
}

/// Of how long something took each time.
struct Spread {
  double p50_s = 0, p99_s = 0, worst_s = 0;
};

/// `values` is not empty.
[[nodiscard]] inline Spread spread_of(std::vector<double> values) {
  std::ranges::sort(values);
  const auto at = [&](double share) {
    return values[std::min(values.size() - 1,
                           static_cast<std::size_t>(share * static_cast<double>(values.size())))];
  };
  return {at(0.5), at(0.99), values.back()};
}

/// The memory of another program, whose reading takes ours out of the caches, as it does in life between two
/// frames: twice the third cache of large CPUs.
class OtherProgram {
 public:
  void read() {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < memory_.size(); i += 8) sum += memory_[i];
    seen_ = sum;
  }

 private:
  static constexpr std::size_t kBytes = std::size_t{64} << 20;
  model::Aligned<std::uint64_t> memory_ = model::Aligned<std::uint64_t>(kBytes / sizeof(std::uint64_t));
  volatile std::uint64_t seen_ = 0;
};

/// Sixty calls a second, so many in all, with cold caches: of each, s. `bench` and `what` say what is done.
/// Errors: cancelled.
template <class Call>
[[nodiscard]] Result<std::vector<double>> measure_sixty_hz(std::size_t calls, const char* bench,
                                                           const std::string& what, const Progress& progress,
                                                           const Call& call) {
  OtherProgram other;
  std::vector<double> took;
  auto next = Clock::now();
  for (std::size_t f = 0; f < calls; ++f) {
    other.read();
    // A frame that the machine kept from us does not make the next one hurry.
    next = std::max(next + std::chrono::nanoseconds(16'666'667), Clock::now());
    std::this_thread::sleep_until(next);
    const auto from = Clock::now();
    call(f);
    took.push_back(seconds_since(from));
    if (!progress(static_cast<double>(f + 1) / static_cast<double>(calls),
                  what + " at 60 a second, caches cold"))
      return fail(ErrorCode::cancelled, "stopped before it was done", bench);
  }
  return took;
}

/// How long a call takes with everything where it was the last time: the smallest of rounds' medians, as
/// peers are measured. A try calls it `calls` times.
template <class Call>
[[nodiscard]] double measure_hot(std::size_t calls, std::size_t tries, const Call& call) {
  constexpr std::size_t kRounds = 9;
  double least = std::numeric_limits<double>::infinity();
  std::vector<double> took(tries);
  for (std::size_t round = 0; round < kRounds; ++round) {
    for (double& one : took) {
      const auto from = Clock::now();
      for (std::size_t j = 0; j < calls; ++j) call();
      one = seconds_since(from) / static_cast<double>(calls);
    }
    least = std::min(least, spread_of(took).p50_s);
  }
  return least;
}

}  // namespace mien::lab
