#include "mien/virtual/performers.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace mien::virt {

Result<void> for_each_performer(std::size_t count, unsigned threads, const Progress& progress,
                                const std::function<Result<void>(std::size_t)>& perform) {
  std::atomic<std::size_t> next = 0;
  std::atomic<std::size_t> done = 0;
  std::atomic<bool> stop = false;
  std::optional<Error> error;
  std::mutex error_mutex;
  const auto work = [&] {
    for (std::size_t p = next++; p < count && !stop; p = next++) {
      const Result<void> performed = perform(p);
      if (performed) {
        ++done;
        continue;
      }
      const std::scoped_lock lock(error_mutex);
      if (!error) error = performed.error();
      stop = true;
    }
  };
  {
    std::vector<std::jthread> workers;
    if (threads == 0) threads = std::max(1U, std::thread::hardware_concurrency());
    for (unsigned i = 0; i < threads; ++i) workers.emplace_back(work);
    std::size_t finished = 0;
    while (finished < count && !stop) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      finished = done;
      if (!progress(static_cast<double>(finished) / static_cast<double>(count),
                    fmt::format("{} of {} performers", finished, count)) &&
          finished < count)
        stop = true;
    }
  }
  if (error) return std::unexpected(*error);
  if (done < count) return fail(ErrorCode::cancelled, "stopped before all performers had performed");
  return {};
}

}  // namespace mien::virt
