#include "mien/live/video_writer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <new>
#include <system_error>
#include <utility>

namespace mien::live {
namespace {

/// What of a video a machine that loses its power may lose.
constexpr auto kToDisk = std::chrono::seconds(5);

std::string system_words(int code) {
  return std::generic_category().message(code);
}

/// The n-th video's path beside a take.
std::filesystem::path video_path(const std::filesystem::path& take, int n, VideoContainer container) {
  std::string name = take.stem().string();
  if (n > 1) name += fmt::format("_{}", n);
  return take.parent_path() / fmt::format("{}.{}", name, container_name(container));
}

}  // namespace

/// The video that is written.
struct VideoWriter::File {
  std::uint64_t video = 0;
  std::filesystem::path path;
  int descriptor = -1;
  std::uint64_t bytes = 0;
  std::chrono::steady_clock::time_point on_disk;
  bool failed = false;

  ~File() {
    if (descriptor < 0) return;
    ::close(descriptor);
    std::error_code ignored;
    if (bytes == 0) std::filesystem::remove(path, ignored);
  }
};

VideoWriter::VideoWriter(std::uint64_t reserve_bytes)
    : reserve_bytes_(reserve_bytes), thread_([this](const std::stop_token& stop) { run(stop); }) {}

VideoWriter::~VideoWriter() = default;

void VideoWriter::open(std::uint64_t video, const std::filesystem::path& take, VideoContainer container) {
  post({.what = Job::Do::open, .video = video, .take = take, .container = container});
}

bool VideoWriter::append(std::uint64_t video, std::span<const std::byte> data) {
  {
    const std::scoped_lock lock(mutex_);
    if (waiting_bytes_ + data.size() > kQueueBytes) return false;
  }
  try {
    post({.what = Job::Do::append, .video = video, .data = std::vector(data.begin(), data.end())});
  } catch (const std::bad_alloc&) {
    return false;  // Memory is short: as if the disk were.
  }
  return true;
}

void VideoWriter::close(std::uint64_t video) {
  post({.what = Job::Do::close, .video = video});
}

void VideoWriter::post(Job job) {
  {
    const std::scoped_lock lock(mutex_);
    waiting_bytes_ += job.data.size();
    jobs_.push_back(std::move(job));
  }
  wake_.notify_one();
}

std::vector<VideoWriter::Report> VideoWriter::take_reports() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(reports_, {});
}

void VideoWriter::wait() {
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return jobs_.empty() && !busy_; });
}

void VideoWriter::run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, stop, [this] { return !jobs_.empty(); });
    if (jobs_.empty()) break;  // It is over, and all is written.
    const Job job = std::move(jobs_.front());
    jobs_.pop_front();
    busy_ = true;
    lock.unlock();
    try {
      perform(job);
    } catch (const std::bad_alloc&) {
      give_up(job.what == Job::Do::close);
    }
    lock.lock();
    busy_ = false;
    waiting_bytes_ -= job.data.size();
    if (jobs_.empty()) idle_.notify_all();
  }
  lock.unlock();
  file_.reset();
}

/// Memory is short: what is in the file stays.
void VideoWriter::give_up(bool closed) {
  if (!file_) return;
  file_->failed = true;
  try {
    report(closed, "memory is short");
  } catch (const std::bad_alloc&) {
    // Whoever waits for the end of it waits so long and no longer.
  }
  if (closed) file_.reset();
}

void VideoWriter::perform(const Job& job) {
  if (job.what == Job::Do::open) {
    file_ = std::make_unique<File>();
    file_->video = job.video;
    const Result<void> made = make(job);
    file_->failed = !made;
    report(false, made ? std::string() : made.error().what);
    return;
  }
  if (!file_ || file_->video != job.video) return;
  if (job.what == Job::Do::close) {
    if (file_->descriptor >= 0) ::fdatasync(file_->descriptor);
    report(true, {});
    file_.reset();
    return;
  }
  if (file_->failed) return;
  if (const Result<void> written = write(job.data); !written) {
    file_->failed = true;
    report(false, written.error().what);
  }
}

Result<void> VideoWriter::make(const Job& job) {
  for (int n = 1; n <= kMostFiles; ++n) {
    const std::filesystem::path path = video_path(job.take, n, job.container);
    // The number is the video's, whatever its container.
    std::error_code ignored;
    const VideoContainer other =
        job.container == VideoContainer::webm ? VideoContainer::mp4 : VideoContainer::webm;
    if (std::filesystem::exists(video_path(job.take, n, other), ignored)) continue;
    // Another take's first.
    const std::filesystem::path named = video_path(job.take, n, job.container).replace_extension(".mien");
    if (n > 1 && std::filesystem::exists(named, ignored)) continue;
    // For its owner alone, as takes are.
    file_->descriptor = ::open(path.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0600);
    if (file_->descriptor >= 0) {
      file_->path = path;
      file_->on_disk = std::chrono::steady_clock::now();
      return {};
    }
    if (errno != EEXIST)
      return fail(ErrorCode::io, fmt::format("its file cannot be made ({})", system_words(errno)),
                  path.string());
  }
  return fail(ErrorCode::out_of_range, fmt::format("{} videos of one take are enough", kMostFiles),
              job.take.string());
}

Result<void> VideoWriter::write(std::span<const std::byte> data) {
  File& file = *file_;
  struct statvfs disk {};
  const bool known = ::fstatvfs(file.descriptor, &disk) == 0;
  if (known && std::uint64_t{disk.f_bavail} * disk.f_frsize < reserve_bytes_ + data.size())
    return fail(ErrorCode::io,
                fmt::format("less than {:g} GB is left on the disk, which the take needs",
                            1e-9 * static_cast<double>(reserve_bytes_)),
                file.path.string());
  while (!data.empty()) {
    const ssize_t count = ::write(file.descriptor, data.data(), data.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0)
      return fail(ErrorCode::io,
                  fmt::format("it cannot be written any further ({})", system_words(count < 0 ? errno : EIO)),
                  file.path.string());
    const auto written = static_cast<std::size_t>(count);
    file.bytes += written;
    bytes_ += written;
    data = data.subspan(written);
  }
  if (const auto now = std::chrono::steady_clock::now(); now - file.on_disk >= kToDisk) {
    ::fdatasync(file.descriptor);
    file.on_disk = now;
  }
  return {};
}

void VideoWriter::report(bool closed, std::string error) {
  Report made{.video = file_->video,
              .file = file_->path,
              .bytes = file_->bytes,
              .closed = closed,
              .error = std::move(error)};
  const std::scoped_lock lock(mutex_);
  reports_.push_back(std::move(made));
}

}  // namespace mien::live
