#include "app/live/pairing_key.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sodium.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <system_error>

#include "app/private_folder.h"
#include "mien/core/encoding.h"
#include "mien/core/excerpt.h"
#include "mien/core/files.h"

namespace mien::app {
namespace fs = std::filesystem;
namespace {

void warn_where_others_read(const fs::path& file) {
  std::error_code unknown;
  const fs::perms mode = fs::status(file, unknown).permissions();
  if (unknown || (mode & (fs::perms::group_read | fs::perms::others_read)) == fs::perms::none) return;
  fmt::print(
      stderr,
      "mien: {}: other users of this machine can read this key; run chmod 600 on it, or make another\n",
      without_controls(file.string()));
}

}  // namespace

Result<sensor::SealKey> read_pairing_key(const fs::path& file) {
  MIEN_TRY_ASSIGN(const std::string text, read_text(file, 4096));
  sensor::SealKey key;
  unsigned id = 0;
  const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), id);
  std::size_t length = 0;
  const char* rest = nullptr;
  const bool good = wrong == std::errc{} && id < 256 &&
                    sodium_hex2bin(reinterpret_cast<unsigned char*>(key.secret.data()), key.secret.size(),
                                   end, static_cast<std::size_t>(text.data() + text.size() - end), " \t\r\n",
                                   &length, &rest) == 0 &&
                    length == key.secret.size() && rest == text.data() + text.size();
  if (!good)
    return fail(ErrorCode::malformed, "not a key file", file.string(),
                "write a number from 0 to 255, a space and 64 hexadecimal digits into it");
  key.id = static_cast<std::uint8_t>(id);
  warn_where_others_read(file);
  return key;
}

Result<fs::path> default_pairing_key() {
  const auto variable = [](const char* name) {
    const char* const value = std::getenv(name);
    return std::string_view(value != nullptr ? value : "");
  };
  // A relative one is to be ignored, says the XDG base directory specification.
  if (const auto config = variable("XDG_CONFIG_HOME"); config.starts_with('/'))
    return fs::path(config) / "mien/pairing.key";
  if (const auto home = variable("HOME"); home.starts_with('/'))
    return fs::path(home) / ".config/mien/pairing.key";
  return fail(ErrorCode::not_found, "there is no place for your settings", "pairing key",
              "set HOME, or write a key file of your own and give it with --key");
}

Result<sensor::SealKey> make_pairing_key(const fs::path& file) {
  const auto wrong = [&] {
    return fail(ErrorCode::io, std::strerror(errno), file.string(), "see that its folder can be written");
  };
  if (sodium_init() < 0) return fail(ErrorCode::internal, "libsodium does not start", "pairing key");
  MIEN_TRY(make_private_folders(file.parent_path()));
  sensor::SealKey key{.id = 1, .secret = {}};
  randombytes_buf(key.secret.data(), key.secret.size());
  const std::string text = fmt::format("{} {}\n", key.id, hex(key.secret));
  // Whole, or not there: made beside its place, then given its name, if nobody has it.
  std::string beside = file.string() + "-XXXXXX";
  const int made = ::mkstemp(beside.data());  // Mode 600.
  if (made < 0) return wrong();
  const bool written =
      ::write(made, text.data(), text.size()) == static_cast<ssize_t>(text.size()) && ::fsync(made) == 0;
  const bool named = written && ::link(beside.c_str(), file.c_str()) == 0;
  const int problem = errno;
  ::close(made);
  ::unlink(beside.c_str());
  if (named) return key;
  if (written && problem == EEXIST) return read_pairing_key(file);
  errno = problem;
  return wrong();
}

std::string firmware_line(const sensor::SealKey& key) {
  std::string line = fmt::format("static const uint8_t kMienKey[33] = {{{}", key.id);
  for (const std::byte byte : key.secret) line += fmt::format(", 0x{:02x}", std::to_integer<unsigned>(byte));
  return line + "};";
}

std::string keyed_command(const fs::path& file) {
  std::string quoted;
  for (const char c : file.string()) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  const bool plain = quoted.find_first_not_of(
                         "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                         "/._-+=@%") == std::string::npos;
  return "mien live --key " + (plain ? quoted : "'" + quoted + "'");
}

}  // namespace mien::app
