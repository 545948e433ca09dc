#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

namespace mien::render {

/// Threads that wait for work: a film asks for some twenty pieces of it a frame. One caller at a time.
class Workers {
 public:
  /// `threads`: the caller's included, 1 at least.
  explicit Workers(int threads) {
    for (int i = 1; i < threads; ++i)
      helpers_.emplace_back([this](const std::stop_token& stop) { wait(stop); });
  }
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  /// Calls job() once in each thread, this one included; back when all are.
  void run(const std::function<void()>& job) {
    {
      const std::scoped_lock lock(mutex_);
      job_ = &job;
      ++round_;
      busy_ = helpers_.size();
    }
    begun_.notify_all();
    job();
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [&] { return busy_ == 0; });
  }

 private:
  void wait(const std::stop_token& stop) {
    std::uint64_t done = 0;
    std::unique_lock lock(mutex_);
    while (begun_.wait(lock, stop, [&] { return round_ != done; })) {
      done = round_;
      const std::function<void()>& job = *job_;
      lock.unlock();
      job();
      lock.lock();
      if (--busy_ == 0) ended_.notify_one();
    }
  }

  std::mutex mutex_;
  std::condition_variable_any begun_;
  std::condition_variable ended_;
  const std::function<void()>* job_ = nullptr;
  std::uint64_t round_ = 0;
  std::size_t busy_ = 0;
  std::vector<std::jthread> helpers_;  // Last: they end before the rest does.
};

/// Calls work(first, last) for pieces that cover [0, count). Pieces must not depend on each other: which
/// thread does which is left to chance, the results are not.
template <class Work>
void parallel(Workers& workers, std::size_t count, std::size_t piece, const Work& work) {
  std::atomic<std::size_t> next = 0;
  workers.run([&] {
    for (;;) {
      const std::size_t first = next.fetch_add(piece);
      if (first >= count) return;
      work(first, first + piece < count ? first + piece : count);
    }
  });
}

}  // namespace mien::render
