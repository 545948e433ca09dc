#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/core/error.h"

namespace mien::sink {

/// Longest address that is read; a longer one is a mistake.
inline constexpr std::size_t kMaxAddressBytes = 2048;

/// Where frames go, as a person types it: `livelink://192.168.1.7:11111?subject=Ann&rate=30`, `csv:take.csv`.
struct Address {
  std::string scheme;      ///< In lower case: "livelink".
  std::string host;        ///< Name or number, IPv6 without its brackets; empty for a file.
  std::uint16_t port = 0;  ///< 0: none was given.
  std::string path;        ///< From the first slash behind the host; of `csv:`, the file.
  std::vector<std::pair<std::string, std::string>> options;  ///< Behind the question mark, decoded.

  /// The option's value, or null.
  [[nodiscard]] const std::string* option(std::string_view name) const;
  /// Errors: bad_usage (not a whole number), out_of_range. `fallback` where the option is not given.
  [[nodiscard]] Result<int> whole_option(std::string_view name, int fallback, int least, int most) const;
  /// Errors: bad_usage, which names the first option that is not among `known`, and these.
  [[nodiscard]] Result<void> expect_options(std::initializer_list<std::string_view> known) const;
  /// "127.0.0.1:11111", "[::1]:11111"; `default_port` where none was given.
  [[nodiscard]] std::string endpoint(std::uint16_t default_port) const;
};

/// Reads `SCHEME://HOST[:PORT][/PATH][?NAME=VALUE[&...]]` or `csv:FILE[?...]`; says nothing about whether the
/// scheme is known. Bytes in options may be written %20. Errors: bad_usage (no scheme, no host, a bad port,
/// an option without a name, doubled or with a broken %, control characters); out_of_range (too long).
[[nodiscard]] Result<Address> parse_address(std::string_view text);

}  // namespace mien::sink
