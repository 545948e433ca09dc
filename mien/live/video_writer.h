#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/video_message.h"

namespace mien::live {

/// Writes videos beside takes, on a thread of its own: whoever hands over goes on, and waits for no disk.
/// Each chunk goes to the system as it comes, so that what was written outlives the program, and to the disk
/// every few seconds. What cannot be written ends its video and nothing else.
class VideoWriter {
 public:
  /// What may wait for the disk, bytes: twelve seconds of the fastest video that is taken.
  static constexpr std::size_t kQueueBytes = std::size_t{48} << 20U;
  /// A video gives up where less would be left on its disk: the take needs it, twenty minutes of twelve
  /// sensors at 240 Hz. Bytes.
  static constexpr std::uint64_t kReserveBytes = 500'000'000;
  /// A take has at most so many videos.
  static constexpr int kMostFiles = 100;

  explicit VideoWriter(std::uint64_t reserve_bytes = kReserveBytes);
  ~VideoWriter();  ///< Writes what was handed over, and ends the thread.
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  // One thread, always the same. `video`: a number that the caller gives it, never twice.
  /// Makes its file beside the take: NAME.webm beside NAME.mien, then NAME_2.webm and so on; what is there
  /// already stays.
  void open(std::uint64_t video, const std::filesystem::path& take, VideoContainer container);
  /// False: too much waits for the disk already.
  [[nodiscard]] bool append(std::uint64_t video, std::span<const std::byte> data);
  /// A file without a byte goes.
  void close(std::uint64_t video);

  // Any thread.
  /// What became of a video.
  struct Report {
    std::uint64_t video = 0;
    std::filesystem::path file;  ///< Empty: none could be made.
    std::uint64_t bytes = 0;     ///< In it so far.
    bool closed = false;
    std::string error;  ///< Why it cannot be written any further; empty when it can.
  };
  /// What is new since the last call, in order: a file was made, one cannot be written any more, one is
  /// closed.
  [[nodiscard]] std::vector<Report> take_reports();
  /// In the videos of this writer together.
  [[nodiscard]] std::uint64_t bytes() const { return bytes_.load(std::memory_order_relaxed); }
  /// Returns when all that was handed over is written.
  void wait();

 private:
  struct Job {
    enum class Do : std::uint8_t { open, append, close };
    Do what = Do::close;
    std::uint64_t video = 0;
    std::filesystem::path take;
    VideoContainer container = VideoContainer::webm;
    std::vector<std::byte> data;
  };
  struct File;
  void post(Job job);
  void run(const std::stop_token& stop);
  void give_up(bool closed);
  void perform(const Job& job);
  [[nodiscard]] Result<void> make(const Job& job);
  [[nodiscard]] Result<void> write(std::span<const std::byte> data);
  void report(bool closed, std::string error);

  std::uint64_t reserve_bytes_;
  std::unique_ptr<File> file_;  // The thread's alone.
  std::atomic<std::uint64_t> bytes_ = 0;
  std::mutex mutex_;  // Held for moments only.
  std::condition_variable_any wake_;
  std::condition_variable_any idle_;
  std::deque<Job> jobs_;
  std::size_t waiting_bytes_ = 0;
  bool busy_ = false;
  std::vector<Report> reports_;
  std::jthread thread_;  // Last: it ends before what it uses.
};

}  // namespace mien::live
