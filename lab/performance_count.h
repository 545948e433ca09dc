#pragma once

#include <fmt/format.h>

#include <atomic>
#include <cstddef>
#include <string_view>

#include "mien/core/error.h"
#include "mien/core/progress.h"

namespace mien::lab {

/// Counts parts of the work of for_each_performer(), since a performer, under one condition after another,
/// takes long. Thread-safe.
class PerformanceCount {
 public:
  /// `whole` is how many there will be, above 0. `progress` must outlive it.
  PerformanceCount(const Progress& progress, std::size_t whole) : progress_(progress), whole_(whole) {}
  PerformanceCount(const PerformanceCount&) = delete;
  PerformanceCount& operator=(const PerformanceCount&) = delete;

  /// Tells how many are done, whatever it is told itself. This must outlive it.
  [[nodiscard]] Progress progress() {
    return [this](double, std::string_view) {
      const std::size_t done = done_;
      if (!progress_(static_cast<double>(done) / static_cast<double>(whole_),
                     fmt::format("{} of {} performances", done, whole_)))
        stopped_ = true;
      return !stopped();
    };
  }
  /// Before each of them. Errors: cancelled.
  [[nodiscard]] Result<void> go_on() const {
    if (stopped()) return fail(ErrorCode::cancelled, "stopped before all performances were done");
    return {};
  }
  [[nodiscard]] bool stopped() const { return stopped_; }
  /// So many more are done.
  void count(std::size_t more = 1) { done_ += more; }

 private:
  const Progress& progress_;
  std::size_t whole_;
  std::atomic<std::size_t> done_ = 0;
  std::atomic<bool> stopped_ = false;
};

}  // namespace mien::lab
