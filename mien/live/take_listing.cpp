#include "mien/live/take_listing.h"

#include <algorithm>
#include <chrono>
#include <system_error>
#include <utility>

#include "mien/core/time.h"
#include "mien/take/take.h"

namespace mien::live {
namespace {

Result<double> length_s(const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(path));
  MIEN_TRY_ASSIGN(const std::vector<take::Tick> ticks, take.ticks());
  return ticks.empty() ? 0 : to_seconds(ticks.back().frame - ticks.front().frame);
}

}  // namespace

std::optional<FileVersion> FileVersion::of(const std::filesystem::path& file) {
  std::error_code gone;
  FileVersion version;
  version.written = std::filesystem::last_write_time(file, gone);
  if (!gone) version.bytes = std::filesystem::file_size(file, gone);
  return gone ? std::nullopt : std::optional(version);
}

TakeListing::TakeListing(std::filesystem::path folder, std::function<void()> lengths_read)
    : folder_(std::move(folder)),
      lengths_read_(std::move(lengths_read)),
      thread_([this](const std::stop_token& stop) { read_lengths(stop); }) {}

TakeListing::~TakeListing() = default;

std::vector<TakeListing::Entry> TakeListing::list(const std::optional<Growing>& growing, bool read_lengths) {
  struct Found {
    Entry entry;
    FileVersion version;
  };
  std::vector<Found> found;
  std::error_code code;
  using Folder = std::filesystem::directory_iterator;
  for (Folder file(folder_, code); !code && file != Folder(); file.increment(code)) {
    if (file->path().extension() != ".mien") continue;
    const auto version = FileVersion::of(file->path());
    if (!version) continue;
    const auto written = std::chrono::time_point_cast<std::chrono::system_clock::duration>(
        std::chrono::file_clock::to_sys(version->written));
    found.push_back({{.name = file->path().filename().string(),
                      .megabytes = static_cast<double>(version->bytes) / 1e6,
                      .written = std::chrono::system_clock::to_time_t(written)},
                     *version});
  }
  std::ranges::sort(found, std::ranges::greater(), [](const Found& one) { return one.version.written; });
  found.resize(std::min(found.size(), kMaxTakes));

  std::vector<Entry> out;
  const std::scoped_lock lock(mutex_);
  if (read_lengths) wanted_.clear();
  for (Found& one : found) {
    const auto known = lengths_.find(one.entry.name);
    const bool is_known = known != lengths_.end() && known->second.of == one.version;
    if (growing && growing->path == folder_ / one.entry.name)
      one.entry.seconds = growing->seconds;
    else if (is_known && known->second.seconds)
      one.entry.seconds = *known->second.seconds;
    else if (is_known)
      one.entry.error = known->second.seconds.error().message();
    else if (read_lengths)
      wanted_.push_back({one.entry.name, one.version});
    out.push_back(std::move(one.entry));
  }
  std::erase_if(lengths_, [&](const auto& known) {
    return std::ranges::none_of(out, [&](const Entry& entry) { return entry.name == known.first; });
  });
  wake_.notify_one();
  return out;
}

void TakeListing::read_lengths(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (wake_.wait(lock, stop, [this] { return !wanted_.empty(); })) {
    const Wanted next = wanted_.front();
    wanted_.pop_front();
    lock.unlock();
    Result<double> seconds = length_s(folder_ / next.name);
    lock.lock();
    lengths_.insert_or_assign(next.name, Length{next.version, std::move(seconds)});
    if (!wanted_.empty()) continue;
    lock.unlock();
    lengths_read_();
    lock.lock();
  }
}

}  // namespace mien::live
