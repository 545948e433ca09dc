#pragma once

#include <atomic>
#include <cstddef>

#include "mien/core/error.h"
#include "mien/core/progress.h"

namespace mien::lab {

/// Counts the performances of for_each_performer(), since a performer, under one condition after another,
/// takes long. Thread-safe.
class PerformanceCount {
 public:
  /// `whole` is how many there will be, above 0. `progress` must outlive it.
  PerformanceCount(const Progress& progress, std::size_t whole) : progress_(progress), whole_(whole) {}
  PerformanceCount(const PerformanceCount&) = delete;
  PerformanceCount& operator=(const PerformanceCount&) = delete;

  /// Tells how many are done, whatever it is told itself. This must outlive it.
  [[nodiscard]] Progress progress();
  /// Before each of them. Errors: cancelled.
  [[nodiscard]] Result<void> go_on() const;
  [[nodiscard]] bool stopped() const { return stopped_; }
  /// One more is done.
  void count() { ++done_; }

 private:
  const Progress& progress_;
  std::size_t whole_;
  std::atomic<std::size_t> done_ = 0;
  std::atomic<bool> stopped_ = false;
};

}  // namespace mien::lab
