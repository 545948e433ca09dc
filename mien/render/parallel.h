#pragma once

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace mien::render {

/// Calls work(first, last) for pieces that cover [0, count). Pieces must not depend on each other: which
/// thread does which is left to chance, the results are not.
template <class Work>
void parallel(int threads, std::size_t count, std::size_t piece, const Work& work) {
  std::atomic<std::size_t> next = 0;
  const auto run = [&] {
    for (;;) {
      const std::size_t first = next.fetch_add(piece);
      if (first >= count) return;
      work(first, first + piece < count ? first + piece : count);
    }
  };
  std::vector<std::jthread> helpers;
  for (int i = 1; i < threads; ++i) helpers.emplace_back(run);
  run();
}

}  // namespace mien::render
