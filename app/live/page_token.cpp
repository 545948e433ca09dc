#include "app/live/page_token.h"

#include <algorithm>
#include <cstdlib>

#include "mien/core/files.h"
#include "mien/sink/ws_admission.h"

namespace mien::app {
namespace {

constexpr const char* kTokenVariable = "MIEN_TOKEN";
constexpr std::size_t kMaxTokenFileBytes = 4096;

/// Never repeats it: what is wrong with a token is no reason to show it.
Result<std::string> checked_token(std::string token, const std::string& where) {
  if (!sink::is_token(token))
    return fail(ErrorCode::bad_usage, "a token has 8 to 128 letters, digits, or - . _ ~", where);
  return token;
}

}  // namespace

void add_token_options(Command command, TokenOption& given, const std::string& what) {
  const Option token = command.add_option(
      "--token", given.token,
      what + ". Other users of the machine can see it in its list of processes: --token-file hides it");
  command
      .add_option("--token-file", given.file,
                  "A file with the token in its first line (without either: the environment's MIEN_TOKEN)")
      .excludes(token);
}

Result<std::string> given_token(const TokenOption& given, const std::string& otherwise) {
  if (!given.token.empty()) return checked_token(given.token, "--token");
  if (!given.file.empty()) {
    MIEN_TRY_ASSIGN(std::string text, read_text(given.file, kMaxTokenFileBytes));
    text.resize(std::min(text.find('\n'), text.size()));
    const std::size_t begin = text.find_first_not_of(" \t\r");
    if (begin == std::string::npos)
      return fail(ErrorCode::bad_usage, "there is no token in its first line", given.file);
    return checked_token(text.substr(begin, text.find_last_not_of(" \t\r") + 1 - begin), given.file);
  }
  if (!otherwise.empty()) return otherwise;
  const char* const variable = std::getenv(kTokenVariable);
  if (variable == nullptr || *variable == '\0') return std::string();
  return checked_token(variable, kTokenVariable);
}

}  // namespace mien::app
