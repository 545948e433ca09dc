#include "mien/sink/address.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "mien/core/ascii.h"
#include "mien/core/host_port.h"

namespace mien::sink {
namespace {

std::unexpected<Error> bad(std::string what, std::string_view text, std::string fix = {}) {
  return fail(ErrorCode::bad_usage, std::move(what), fmt::format("'{}'", text), std::move(fix));
}

template <class T>
std::optional<T> whole(std::string_view text) {
  T value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// "%41" is "A". None when a % is not followed by two hexadecimal digits, or stands for a control character.
std::optional<std::string> decoded(std::string_view text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      plain += text[i];
      continue;
    }
    unsigned value = 0;
    const char* const digits = text.data() + i + 1;
    if (i + 2 >= text.size()) return std::nullopt;
    const auto [end, code] = std::from_chars(digits, digits + 2, value, 16);
    if (code != std::errc{} || end != digits + 2 || value < 0x20 || value == 0x7F) return std::nullopt;
    plain += static_cast<char>(static_cast<unsigned char>(value));
    i += 2;
  }
  return plain;
}

Result<void> parse_options(std::string_view query, std::string_view text, Address& address) {
  while (!query.empty()) {
    const std::string_view one = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(query.size(), one.size() + 1));
    const std::size_t equals = one.find('=');
    if (equals == 0 || equals == std::string_view::npos)
      return bad(fmt::format("'{}' is no option", one), text, "write ?NAME=VALUE&NAME=VALUE");
    const std::string name(one.substr(0, equals));
    auto value = decoded(one.substr(equals + 1));
    if (!value) return bad(fmt::format("the value of '{}' has a broken %", name), text);
    if (address.option(name) != nullptr) return bad(fmt::format("'{}' stands there twice", name), text);
    address.options.emplace_back(name, *std::move(value));
  }
  return {};
}

Result<void> parse_host(std::string_view authority, std::string_view text, Address& address) {
  const auto parsed = parse_host_port(authority);
  if (!parsed) return bad(parsed.error().what, text, parsed.error().fix);
  address.host = parsed->host;
  if (address.host.empty()) return bad("there is no host", text, "write SCHEME://HOST:PORT");
  if (!parsed->port) return {};
  if (*parsed->port == 0) return bad("'0' is no port", text, "write 1 to 65535");
  address.port = *parsed->port;
  return {};
}

}  // namespace

const std::string* Address::option(std::string_view name) const {
  const auto found = std::ranges::find(options, name, &std::pair<std::string, std::string>::first);
  return found == options.end() ? nullptr : &found->second;
}

Result<int> Address::whole_option(std::string_view name, int fallback, int least, int most) const {
  const std::string* const text = option(name);
  if (text == nullptr) return fallback;
  const auto value = whole<int>(*text);
  if (!value) return bad(fmt::format("{} is no whole number", name), *text);
  if (*value < least || *value > most)
    return fail(ErrorCode::out_of_range, fmt::format("{} is not within {} to {}", name, least, most),
                fmt::format("'{}'", *text));
  return *value;
}

Result<void> Address::expect_options(std::initializer_list<std::string_view> known) const {
  for (const auto& [name, value] : options)
    if (std::ranges::find(known, name) == known.end())
      return bad(fmt::format("{} has no such option", scheme), name,
                 fmt::format("it has {}", fmt::join(known, ", ")));
  return {};
}

std::string Address::endpoint(std::uint16_t default_port) const {
  const std::uint16_t number = port == 0 ? default_port : port;
  return host.find(':') == std::string::npos ? fmt::format("{}:{}", host, number)
                                             : fmt::format("[{}]:{}", host, number);
}

Result<Address> parse_address(std::string_view text) {
  if (text.size() > kMaxAddressBytes)
    return fail(ErrorCode::out_of_range, fmt::format("longer than {} bytes", kMaxAddressBytes),
                "a sink's address");
  if (has_control(text)) return fail(ErrorCode::bad_usage, "has control characters", "a sink's address");
  const std::size_t colon = text.find(':');
  Address address;
  address.scheme = text.substr(0, colon);
  std::ranges::transform(address.scheme, address.scheme.begin(), ascii_lower);
  const bool named = !address.scheme.empty() &&
                     std::ranges::all_of(address.scheme, [](char c) { return c >= 'a' && c <= 'z'; });
  if (colon == std::string_view::npos || !named)
    return bad("names no kind of sink", text, "write SCHEME://HOST:PORT or csv:FILE");
  std::string_view rest = text.substr(colon + 1);
  const std::size_t question = rest.find('?');
  if (question != std::string_view::npos) {
    MIEN_TRY(parse_options(rest.substr(question + 1), text, address));
    rest = rest.substr(0, question);
  }
  if (address.scheme == "csv") {
    if (rest.empty()) return bad("there is no file", text, "write csv:FILE");
    address.path = rest;
    return address;
  }
  if (!rest.starts_with("//")) return bad("there is no host", text, "write SCHEME://HOST:PORT");
  rest.remove_prefix(2);
  const std::size_t slash = rest.find('/');
  if (slash != std::string_view::npos) address.path = rest.substr(slash);
  MIEN_TRY(parse_host(rest.substr(0, slash), text, address));
  return address;
}

}  // namespace mien::sink
