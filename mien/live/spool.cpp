#include "mien/live/spool.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <utility>

namespace mien::live {
namespace {

constexpr Duration kRateWindow = std::chrono::seconds(10);
/// A rate of less says nothing.
constexpr Duration kShortestRate = std::chrono::seconds(1);

/// A file without a name, which goes when it is closed; null with errno when the folder takes none.
std::FILE* open_nameless(const std::filesystem::path& folder) {
  int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file < 0) {  // Not every file system has such files: a name for a moment, then.
    std::string name = (folder / ".mien-session-XXXXXX").string();
    file = ::mkostemp(name.data(), O_CLOEXEC);
    if (file < 0) return nullptr;
    ::unlink(name.c_str());
  }
  std::FILE* const opened = ::fdopen(file, "w+b");
  if (opened == nullptr) {
    const int why = errno;
    ::close(file);
    errno = why;
  }
  return opened;
}

double seconds_until(std::uint64_t limit, std::uint64_t bytes, std::uint64_t before, double seconds) {
  const double rate = static_cast<double>(bytes - before) / seconds;
  return static_cast<double>(limit - std::min(limit, bytes)) / rate;  // Infinite where nothing comes.
}

}  // namespace

Spool::Spool(std::filesystem::path folder, std::uint64_t limit)
    : folder_(std::move(folder)), limit_(limit), log_{open_nameless(folder_)} {
  if (!is_open()) problem_ = no_room();
}

Spool::~Spool() {
  close();
}

std::string Spool::no_room() const {
  return fmt::format("the folder of takes, {}, does not take the session ({})", folder_.string(),
                     std::generic_category().message(errno));
}

Result<void> Spool::write(File& to, std::span<const std::byte> bytes) {
  if (to.file == nullptr) return fail(ErrorCode::io, "the session's log is closed", folder_.string());
  if (std::fwrite(bytes.data(), 1, bytes.size(), to.file) != bytes.size())
    return fail(ErrorCode::io, no_room(), folder_.string());
  to.bytes += bytes.size();
  return {};
}

std::unexpected<Error> Spool::full(std::string_view what) const {
  return fail(
      ErrorCode::io,
      fmt::format("the session has run for too long to be recorded from its beginning: {} the {:g} GB "
                  "of --log-limit",
                  what, 1e-9 * static_cast<double>(limit_)),
      folder_.string());
}

Result<void> Spool::append(std::span<const std::byte> record) {
  const auto size = static_cast<std::uint32_t>(record.size());
  if (log_.bytes + payloads_.bytes + sizeof(size) + size > limit_) return full("its log has reached");
  MIEN_TRY(write(log_, std::as_bytes(std::span(&size, 1))));
  return write(log_, record);
}

Result<void> Spool::append_payload(std::span<const std::byte> payload) {
  if (is_open() && payloads_.file == nullptr) {
    payloads_.file = open_nameless(folder_);
    if (payloads_.file == nullptr) return fail(ErrorCode::io, no_room(), folder_.string());
  }
  if (payloads_.bytes + payload.size() > limit_ / 2)
    return full("its pictures and sound have reached half of");
  if (log_.bytes + payloads_.bytes + payload.size() > limit_) return full("its log has reached");
  return write(payloads_, payload);
}

Result<std::size_t> Spool::read(const File& from, std::uint64_t at, std::span<std::byte> out) {
  if (from.file == nullptr || std::fflush(from.file) != 0)
    return fail(ErrorCode::io, no_room(), folder_.string());
  const auto got = ::pread(::fileno(from.file), out.data(), out.size(), static_cast<off_t>(at));
  if (got < 0) return fail(ErrorCode::io, "the session's log cannot be read back", folder_.string());
  return static_cast<std::size_t>(got);
}

Result<std::size_t> Spool::read(std::uint64_t at, std::span<std::byte> out) {
  return read(log_, at, out);
}

Result<std::size_t> Spool::read_payloads(std::uint64_t at, std::span<std::byte> out) {
  return read(payloads_, at, out);
}

void Spool::close() {
  for (File* const one : {&log_, &payloads_})
    if (one->file != nullptr) std::fclose(std::exchange(one->file, nullptr));
}

Spool::Usage Spool::usage(HostTime now) {
  Usage usage{log_.bytes + payloads_.bytes, limit_, payloads_.bytes, limit_ / 2, {}};
  if (now - newer_.at >= kRateWindow) older_ = std::exchange(newer_, {now, usage.bytes, payloads_.bytes});
  if (!is_open() || now - older_.at < kShortestRate) return usage;
  const double seconds = to_seconds(now - older_.at);
  const double left = std::min(seconds_until(limit_, usage.bytes, older_.bytes, seconds),
                               seconds_until(limit_ / 2, payloads_.bytes, older_.payload_bytes, seconds));
  if (left < 1e9) usage.seconds_left = left;
  return usage;
}

}  // namespace mien::live
