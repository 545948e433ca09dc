#include "mien/sink/sink_kinds.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "mien/face/livelink_csv.h"
#include "mien/sink/frame_pace.h"
#include "mien/sink/live_link.h"

namespace mien::sink {
namespace {

/// Frames of the grid between two writes: half a second.
constexpr std::int64_t kFlushEvery = 30;
/// What waits for a disk that has stopped taking; some minutes. Beyond it rows are dropped.
constexpr std::size_t kMaxWaiting = std::size_t{8} << 20U;

/// A file that is appended to in whole pieces. What was there before goes with the first of them; a file that
/// got none, and was not there before, goes with this.
class AppendedFile {
 public:
  AppendedFile(std::string path, int descriptor, bool was_there)
      : path_(std::move(path)), descriptor_(descriptor), was_there_(was_there) {}
  AppendedFile(const AppendedFile&) = delete;
  AppendedFile& operator=(const AppendedFile&) = delete;
  ~AppendedFile() {
    if (!begun_ && !was_there_) ::unlink(path_.c_str());
    ::close(descriptor_);
  }

  /// All of it, or none: a piece that did not fit is taken back. Returns 0 or errno.
  int append(std::string_view text) {
    // (A device cannot be cut; there is nothing before us.)
    if (!begun_ && was_there_ && ::ftruncate(descriptor_, 0) != 0 && errno != EINVAL) return errno;
    std::size_t done = 0;
    while (done < text.size()) {
      const ssize_t wrote = ::write(descriptor_, text.data() + done, text.size() - done);
      if (wrote < 0 && errno == EINTR) continue;
      if (wrote <= 0) {
        const int code = wrote < 0 ? errno : ENOSPC;
        // Nor is there anything to take back there.
        if (done > 0 && ::ftruncate(descriptor_, size_) != 0) size_ += static_cast<off_t>(done);
        return code;
      }
      done += static_cast<std::size_t>(wrote);
    }
    size_ += static_cast<off_t>(done);
    begun_ = true;
    return 0;
  }
  [[nodiscard]] bool begun() const { return begun_; }

 private:
  std::string path_;
  int descriptor_;
  bool was_there_;
  bool begun_ = false;
  off_t size_ = 0;
};

class CsvSink final : public Sink {
 public:
  CsvSink(std::string address, std::string path, int descriptor, bool was_there, int rate_hz)
      : address_(std::move(address)),
        file_(std::move(path), descriptor, was_there),
        pace_(rate_hz),
        writer_([this] { write_rows(); }) {}
  ~CsvSink() override {
    {
      const std::scoped_lock lock(mutex_);
      ended_ = true;
    }
    wake_.notify_one();
    if (writer_.joinable()) writer_.join();
  }

  void send(const face::OutputFrame& frame, std::int64_t frame_index) noexcept override {
    try {
      if (!pace_.due(frame_index)) return;
      std::array<double, face::kLiveLinkValueCount> values{};
      std::ranges::copy(live_link_values(arkit_frame(frame)), values.begin());
      row_.clear();
      face::append_livelink_row(
          face::format_timecode(face::timecode_at(to_seconds(frame.time.time_since_epoch()))), values, row_);
      // A step backwards is a jump in a replay.
      const bool flush = frame_index - flushed_at_ >= kFlushEvery || frame_index < flushed_at_;
      if (flush) flushed_at_ = frame_index;
      if (queue_row(flush))
        pace_.sent();
      else
        pace_.failed();
      if (flush) wake_.notify_one();
    } catch (...) {  // Out of memory: the row is lost.
      pace_.failed();
    }
  }

  Status status() const override {
    // In this order: the writer counts the rows before it tells why.
    const int code = error_.load();
    const std::uint64_t lost = lost_.load();
    return {address_,
            pace_.sent_count() - std::min(lost, pace_.sent_count()),
            pace_.failed_count() + lost,
            pace_.measured_hz(),
            code == 0 ? std::size_t{1} : std::size_t{0},
            code == 0 ? std::string() : "rows are lost: " + std::system_category().message(code)};
  }

 private:
  bool queue_row(bool flush) {
    const std::scoped_lock lock(mutex_);
    flush_ = flush_ || flush;
    if (waiting_.size() + row_.size() > kMaxWaiting) return false;
    waiting_ += row_;
    ++waiting_rows_;
    return true;
  }

  void write_rows() {
    std::string rows;
    for (bool ended = false; !ended;) {
      std::uint64_t count = 0;
      {
        std::unique_lock lock(mutex_);
        wake_.wait(lock, [this] { return flush_ || ended_; });
        ended = ended_;
        flush_ = false;
        rows.clear();
        if (!file_.begun() && !waiting_.empty()) face::append_livelink_header(rows);
        rows += waiting_;
        waiting_.clear();
        count = std::exchange(waiting_rows_, 0);
      }
      const int code = rows.empty() ? 0 : file_.append(rows);
      if (code != 0) lost_ += count;
      if (!rows.empty()) error_ = code;
    }
  }

  std::string address_;
  AppendedFile file_;
  FramePace pace_;
  std::string row_;
  std::int64_t flushed_at_ = 0;

  std::mutex mutex_;
  std::condition_variable wake_;
  std::string waiting_;  ///< Whole rows; the lock's, as the next three.
  std::uint64_t waiting_rows_ = 0;
  bool flush_ = false;
  bool ended_ = false;
  std::atomic<std::uint64_t> lost_ = 0;  ///< Rows that the disk did not take.
  std::atomic<int> error_ = 0;           ///< errno of the last write; 0 when it went well.
  std::thread writer_;                   ///< Last: it uses all of these.
};

}  // namespace

Result<std::unique_ptr<Sink>> open_csv_sink(const Address& address, std::string_view text) {
  MIEN_TRY(address.expect_options({"rate", "force"}));
  MIEN_TRY_ASSIGN(const int rate_hz, address.whole_option("rate", 60, 1, 60));
  MIEN_TRY_ASSIGN(const int force, address.whole_option("force", 0, 0, 1));
  constexpr int kFlags = O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NONBLOCK;
  int descriptor = ::open(address.path.c_str(), kFlags | O_EXCL, 0666);
  const bool was_there = descriptor < 0 && errno == EEXIST;
  if (was_there && force == 1) descriptor = ::open(address.path.c_str(), kFlags, 0666);
  if (descriptor < 0) {
    const int code = errno;
    if (code == EEXIST)
      return fail(ErrorCode::bad_usage, "the file exists", address.path,
                  "take another name, or add ?force=1 to replace it");
    if (code == ENOENT) return fail(ErrorCode::not_found, "its folder is not there", address.path);
    return fail(ErrorCode::io, std::system_category().message(code), address.path);
  }
  auto sink = std::make_unique<CsvSink>(std::string(text), address.path, descriptor, was_there, rate_hz);
  struct stat kind {};
  if (::fstat(descriptor, &kind) != 0 || !(S_ISREG(kind.st_mode) || S_ISCHR(kind.st_mode)))
    return fail(ErrorCode::unsupported, "is neither a file nor a device", address.path);
  return sink;
}

}  // namespace mien::sink
