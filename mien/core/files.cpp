#include "mien/core/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace mien {
namespace fs = std::filesystem;
namespace {

/// A file descriptor, closed when it goes.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return number_; }

 private:
  int number_;
};

template <class Container>
Result<Container> read_all(const fs::path& path, std::size_t max_bytes) {
  std::error_code code;
  const fs::file_status status = fs::status(path, code);
  if (status.type() == fs::file_type::not_found)
    return fail(ErrorCode::not_found, "there is no such file", path.string());
  if (status.type() == fs::file_type::none) return fail(ErrorCode::io, code.message(), path.string());
  if (fs::is_directory(status))
    return fail(ErrorCode::bad_usage, "this is a folder, not a file", path.string());
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) return fail(ErrorCode::io, std::strerror(errno), path.string());
  // A size spares growing, but is not believed: the path may be a pipe, or grow. One byte more, so that the
  // end of the file is seen without.
  constexpr std::size_t kChunk = std::size_t{1} << 16U;
  const std::uintmax_t size = fs::is_regular_file(status) ? fs::file_size(path, code) : 0;
  Container content;
  content.resize(code || size == 0 || size > max_bytes ? kChunk : size + 1);
  std::size_t have = 0;
  for (;;) {
    if (have == content.size()) content.resize(std::min(2 * have, max_bytes + 1));
    const ssize_t n = ::read(file.get(), content.data() + have, content.size() - have);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fail(ErrorCode::io, std::strerror(errno), path.string());
    if (n == 0) break;
    have += static_cast<std::size_t>(n);
    if (have > max_bytes)
      return fail(ErrorCode::out_of_range, fmt::format("the file is larger than {} bytes", max_bytes),
                  path.string());
  }
  content.resize(have);
  return content;
}

/// False, and errno says why, when not all of it could be written.
bool write_all(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(file, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return true;
}

std::unexpected<Error> cannot_write(int reason, const fs::path& path) {
  if (reason == ENOENT || reason == ENOTDIR)
    return fail(ErrorCode::not_found, "its folder is not there", path.string(), "make the folder first");
  return fail(ErrorCode::io, std::strerror(reason), path.string(), "nothing was written");
}

}  // namespace

Result<std::vector<std::byte>> read_file(const fs::path& path, std::size_t max_bytes) {
  return read_all<std::vector<std::byte>>(path, max_bytes);
}

Result<std::string> read_text(const fs::path& path, std::size_t max_bytes) {
  return read_all<std::string>(path, max_bytes);
}

Result<void> write_file(const fs::path& path, std::span<const std::byte> bytes) {
  std::error_code code;
  const fs::file_status status = fs::status(path, code);
  if (fs::is_directory(status))
    return fail(ErrorCode::bad_usage, "this is a folder, not a file", path.string());
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    // A rename would put a plain file in the place of /dev/null or of a pipe.
    const Descriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
    if (file.get() < 0 || !write_all(file.get(), bytes)) return cannot_write(errno, path);
    return {};
  }
  fs::path target = path;
  if (fs::exists(status)) {
    target = fs::canonical(path, code);
    if (code) return cannot_write(code.value(), path);
  }

  // A name that nobody else has; made by open(), so that the process's umask holds.
  static std::atomic<unsigned> counter = 0;
  std::string name;
  int number = -1;
  do {
    name = fmt::format("{}.{}-{}.part", target.string(), ::getpid(), counter++);
    number = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (number < 0 && errno == EEXIST);
  const Descriptor file(number);
  if (file.get() < 0) return cannot_write(errno, path);
  if (!write_all(file.get(), bytes) || ::fsync(file.get()) != 0 ||
      ::rename(name.c_str(), target.c_str()) != 0) {
    const int reason = errno;
    ::unlink(name.c_str());
    return cannot_write(reason, path);
  }
  // The new name reaches the disk with its folder; a file system that cannot flush a folder is no reason to
  // fail.
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const Descriptor parent(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (parent.get() >= 0) ::fsync(parent.get());
  return {};
}

Result<void> write_file(const fs::path& path, std::string_view text) {
  return write_file(path, std::as_bytes(std::span(text)));
}

Result<fs::path> running_program() {
  std::error_code code;
  fs::path program = fs::read_symlink("/proc/self/exe", code);
  if (code) return fail(ErrorCode::io, "the running program's path cannot be read", "/proc/self/exe");
  return program;
}

Result<fs::path> find_resource(const fs::path& relative) {
  MIEN_TRY_ASSIGN(const fs::path program, running_program());
  std::error_code code;
  // build/<preset>/app/mien and <prefix>/bin/mien alike: the nearest folder above that has it.
  for (fs::path folder = program.parent_path();; folder = folder.parent_path()) {
    for (const fs::path& candidate : {folder / relative, folder / "share" / "mien" / relative})
      if (fs::exists(candidate, code)) return candidate;
    if (folder == folder.root_path()) break;
  }
  return fail(ErrorCode::not_found, fmt::format("{} is not installed beside the program", relative.string()),
              program.string(), "install Mien whole, or run it from its build folder");
}

fs::path cache_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache != nullptr && *cache == '/') return fs::path(cache) / "mien";
  const char* home = std::getenv("HOME");
  if (home != nullptr && *home == '/') return fs::path(home) / ".cache" / "mien";
  return {};
}

}  // namespace mien
