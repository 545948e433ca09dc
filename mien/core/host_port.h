#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "mien/core/error.h"

namespace mien {

/// A host with or without a port, as people, URLs and HTTP's Host header write them.
struct HostPort {
  std::string_view host;  ///< Name or number, IPv6 without its brackets. Part of the text; may be empty.
  std::optional<std::uint16_t> port;  ///< None where none was given; 0 is one.
};

/// Reads "127.0.0.1:8740", "[::1]:8740", "studio", "[::1]"; says nothing about whether the host is one.
/// Errors: bad_usage (a port that is no number to 65535, IPv6 without brackets, a bracket that is not
/// closed).
[[nodiscard]] Result<HostPort> parse_host_port(std::string_view text);

/// The host alone, of a text that was written by a stranger: "localhost" of "localhost:8740", "::1" of
/// "[::1]:8740"; empty where a bracket is not closed. No allocation.
[[nodiscard]] std::string_view host_of(std::string_view text);

/// Whether a host names this machine's loopback whoever resolves it: "localhost", "::1" or 127 and numbers.
/// No allocation.
[[nodiscard]] bool is_loopback(std::string_view host);

}  // namespace mien
