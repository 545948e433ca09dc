#pragma once

#include <optional>
#include <string_view>

namespace mien::sink {

/// Whether a WebSocket connection may be had.
enum class Admission {
  admitted,
  no_token,        ///< A token is required, and this is not it.
  foreign_origin,  ///< A web page of somebody else asks.
};

/// Judges a WebSocket's upgrade request. `target` is its path with query, `origin` and `host` its headers of
/// these names, `token` what `?token=` must be, or empty where none is required. A page may ask when it comes
/// from this machine's loopback, or, with a token, from the host that it is asking; a program without an
/// Origin may ask. (Without a token every name may be made to mean this machine by whoever owns the name, so
/// the Host header says nothing there.) No allocation; the token's comparison takes equally long.
[[nodiscard]] Admission judge_upgrade(std::string_view target, std::optional<std::string_view> origin,
                                      std::string_view host, std::string_view token);

/// What a request's target gives for `token`, "abcd" in "/path?a=b&token=abcd"; empty where it gives none.
/// The first counts. No allocation.
[[nodiscard]] std::string_view token_of(std::string_view target);

/// A token's letters are such as need no escaping, 8 to 128 of them: A-Z a-z 0-9 - . _ ~
[[nodiscard]] bool is_token(std::string_view token);

}  // namespace mien::sink
