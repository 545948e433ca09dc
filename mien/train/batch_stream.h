#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <future>

#include "mien/train/task.h"

namespace mien::train {

/// Batches of the steps to come, made while the device computes. Each is a function of the recipe's seed and
/// of its step's number alone.
class BatchStream {
 public:
  /// Keeps the task: it must stay. `ahead`: batches that are made before they are asked for.
  BatchStream(const Task& task, std::int64_t first_step, std::size_t ahead);

  /// That of the next step. Waits for it.
  [[nodiscard]] Batch next();

 private:
  const Task& task_;
  std::int64_t next_step_;
  std::size_t ahead_;
  std::deque<std::future<Batch>> coming_;
};

}  // namespace mien::train
