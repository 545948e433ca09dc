#pragma once

#include <string>

#include "app/command_line.h"
#include "mien/core/error.h"

namespace mien::app {

/// The token of a session's page, as a command line gives it.
struct TokenOption {
  std::string token;  ///< --token
  std::string file;   ///< --token-file
};

/// Adds --token and --token-file, which exclude each other. `what` says what the token is.
void add_token_options(Command command, TokenOption& given, const std::string& what);

/// The option's token, else the first line of its file, else `otherwise`, else what the environment's
/// MIEN_TOKEN holds; empty where there is none. Errors: bad_usage (not a token, sink::is_token(); of all but
/// `otherwise`), read_text()'s.
[[nodiscard]] Result<std::string> given_token(const TokenOption& given, const std::string& otherwise = {});

}  // namespace mien::app
