#pragma once

#include <condition_variable>
#include <ctime>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "mien/core/error.h"

namespace mien::live {

/// What tells a file that was written to from the one that was read.
struct FileVersion {
  std::uintmax_t bytes = 0;
  std::filesystem::file_time_type written;
  bool operator==(const FileVersion&) const = default;

  /// None where it is gone.
  [[nodiscard]] static std::optional<FileVersion> of(const std::filesystem::path& file);
};

/// The takes of a folder, for a page's list. Names, sizes and times are read at once; how long a take is
/// stands in the file, which may take a second to open, so a thread of its own reads that and keeps it for as
/// long as the file's size and time stay the same. list() from one thread, always the same.
class TakeListing {
 public:
  /// More are not listed: the newest are.
  static constexpr std::size_t kMaxTakes = 200;

  struct Entry {
    std::string name;               ///< With its ending.
    std::optional<double> seconds;  ///< First to last frame. None: not read yet, or it cannot be.
    std::string error;              ///< Why it cannot; else empty.
    double megabytes = 0;
    std::time_t written = 0;  ///< Unix time, s.
  };

  /// `lengths_read` is called on the listing's thread when all lengths that list() wanted have been read, and
  /// some are new: ask again, for no more to be read.
  TakeListing(std::filesystem::path folder, std::function<void()> lengths_read);
  ~TakeListing();  ///< Waits for the take that is being read.
  TakeListing(const TakeListing&) = delete;
  TakeListing& operator=(const TakeListing&) = delete;

  /// The take that this session records: it is not opened while it grows.
  struct Growing {
    std::filesystem::path path;
    double seconds = 0;  ///< How long it is.
  };
  /// Newest first. `read_lengths`: those that are not known are read, and told of by lengths_read; else they
  /// stay unknown, so that a file which somebody else writes is not read again and again. Errors leave a
  /// take, or all, out: a list is for people to pick from.
  [[nodiscard]] std::vector<Entry> list(const std::optional<Growing>& growing, bool read_lengths);

 private:
  struct Length {
    FileVersion of;
    Result<double> seconds;
  };
  struct Wanted {
    std::string name;
    FileVersion version;
  };
  void read_lengths(const std::stop_token& stop);

  std::filesystem::path folder_;
  std::function<void()> lengths_read_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::map<std::string, Length> lengths_;
  std::deque<Wanted> wanted_;  // The newest first.
  std::jthread thread_;        // Last: it uses what stands above.
};

}  // namespace mien::live
