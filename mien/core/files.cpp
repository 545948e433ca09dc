#include "mien/core/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>

namespace mien {
namespace fs = std::filesystem;
namespace {

template <class Container>
Result<Container> read_all(const fs::path& path, std::size_t max_bytes) {
  std::error_code code;
  if (!fs::exists(path, code)) return fail(ErrorCode::not_found, "there is no such file", path.string());
  if (fs::is_directory(path, code))
    return fail(ErrorCode::bad_usage, "this is a folder, not a file", path.string());
  std::ifstream file(path, std::ios::binary);
  if (!file) return fail(ErrorCode::io, std::strerror(errno), path.string());
  // Read until the end rather than believe a size: the path may be a pipe, or grow.
  Container content;
  constexpr std::size_t kChunk = std::size_t{1} << 20U;
  while (file) {
    const std::size_t have = content.size();
    if (have > max_bytes)
      return fail(ErrorCode::out_of_range, fmt::format("the file is larger than {} bytes", max_bytes),
                  path.string());
    content.resize(have + kChunk);
    file.read(reinterpret_cast<char*>(content.data() + have), static_cast<std::streamsize>(kChunk));
    content.resize(have + static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad()) return fail(ErrorCode::io, "reading broke off", path.string());
  return content;
}

}  // namespace

Result<std::vector<std::byte>> read_file(const fs::path& path, std::size_t max_bytes) {
  return read_all<std::vector<std::byte>>(path, max_bytes);
}

Result<std::string> read_text(const fs::path& path, std::size_t max_bytes) {
  return read_all<std::string>(path, max_bytes);
}

Result<void> write_file(const fs::path& path, std::span<const std::byte> bytes) {
  std::string name = path.string() + ".XXXXXX";
  const int file = ::mkstemp(name.data());
  if (file < 0)
    return fail(ErrorCode::io, std::strerror(errno), path.string(), "check the folder and its permissions");
  const auto give_up = [&](const char* reason) -> Result<void> {
    const std::string text = reason;
    ::close(file);
    ::unlink(name.c_str());
    return fail(ErrorCode::io, text, path.string(), "nothing was written");
  };
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = ::write(file, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return give_up(std::strerror(errno));
    done += static_cast<std::size_t>(n);
  }
  // mkstemp makes it private; give it what a plain creation would have had.
  const mode_t mask = ::umask(0);
  ::umask(mask);
  if (::fchmod(file, 0666 & ~mask) != 0 || ::fsync(file) != 0) return give_up(std::strerror(errno));
  if (::rename(name.c_str(), path.c_str()) != 0) return give_up(std::strerror(errno));
  ::close(file);
  return {};
}

Result<void> write_file(const fs::path& path, std::string_view text) {
  return write_file(path, std::as_bytes(std::span(text)));
}

Result<fs::path> find_resource(const fs::path& relative) {
  std::error_code code;
  const fs::path program = fs::read_symlink("/proc/self/exe", code);
  if (code) return fail(ErrorCode::io, "the running program's path cannot be read", "/proc/self/exe");
  // build/<preset>/app/mien and <prefix>/bin/mien alike: the nearest folder above that has it.
  for (fs::path folder = program.parent_path();; folder = folder.parent_path()) {
    for (const fs::path& candidate : {folder / relative, folder / "share" / "mien" / relative})
      if (fs::exists(candidate, code)) return candidate;
    if (folder == folder.root_path()) break;
  }
  return fail(ErrorCode::not_found, fmt::format("{} is not installed beside the program", relative.string()),
              program.string(), "install Mien whole, or run it from its build folder");
}

}  // namespace mien
