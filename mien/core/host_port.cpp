#include "mien/core/host_port.h"

#include <algorithm>
#include <charconv>
#include <string>

namespace mien {
namespace {

bool is_number_with_dots(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return c == '.' || (c >= '0' && c <= '9'); });
}

}  // namespace

Result<HostPort> parse_host_port(std::string_view text) {
  const auto bad = [&](const char* what, const char* fix) {
    return fail(ErrorCode::bad_usage, what, std::string(text), fix);
  };
  HostPort out{host_of(text), {}};
  std::string_view rest = text.substr(out.host.size());
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == std::string_view::npos)
      return bad("the bracket of an IPv6 address is not closed", "write [::1]:PORT");
    rest = text.substr(end + 1);
  }
  if (rest.empty()) return out;
  if (rest.front() != ':') return bad("something stands between host and port", "write HOST:PORT");
  const std::string_view digits = rest.substr(1);
  if (digits.find(':') != std::string_view::npos)
    return bad("an IPv6 address needs brackets", "write [::1]:PORT");
  std::uint16_t port = 0;
  const auto [end, wrong] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (wrong != std::errc{} || end != digits.data() + digits.size())
    return bad("the port is no number to 65535", "write HOST:PORT");
  out.port = port;
  return out;
}

std::string_view host_of(std::string_view text) {
  if (!text.starts_with('[')) return text.substr(0, text.find(':'));
  const std::size_t end = text.find(']');
  return end == std::string_view::npos ? std::string_view() : text.substr(1, end - 1);
}

bool is_loopback(std::string_view host) {
  return host == "localhost" || host == "::1" || (host.starts_with("127.") && is_number_with_dots(host));
}

}  // namespace mien
