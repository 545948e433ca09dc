#include "mien/sink/ws_admission.h"

#include <algorithm>

namespace mien::sink {
namespace {

/// "localhost" of "localhost:8740", "::1" of "[::1]:8740".
std::string_view host_of(std::string_view authority) {
  if (authority.starts_with('[')) {
    const std::size_t end = authority.find(']');
    return end == std::string_view::npos ? std::string_view() : authority.substr(1, end - 1);
  }
  return authority.substr(0, authority.find(':'));
}

bool is_number_with_dots(std::string_view text) {
  return !text.empty() &&
         std::ranges::all_of(text, [](char c) { return c == '.' || (c >= '0' && c <= '9'); });
}

bool is_loopback(std::string_view host) {
  return host == "localhost" || host == "::1" || (host.starts_with("127.") && is_number_with_dots(host));
}

/// The value of `token` in "/path?a=b&token=...".
std::string_view token_of(std::string_view target) {
  const std::size_t question = target.find('?');
  if (question == std::string_view::npos) return {};
  std::string_view query = target.substr(question + 1);
  while (!query.empty()) {
    const std::string_view one = query.substr(0, query.find('&'));
    if (one.starts_with("token=")) return one.substr(6);
    query.remove_prefix(std::min(query.size(), one.size() + 1));
  }
  return {};
}

bool same(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return difference == 0;
}

}  // namespace

Admission judge_upgrade(std::string_view target, std::optional<std::string_view> origin,
                        std::string_view host, std::string_view token) {
  if (!token.empty() && !same(token_of(target), token)) return Admission::no_token;
  if (!origin) return Admission::admitted;
  const std::size_t scheme = origin->find("://");
  if (scheme == std::string_view::npos) return Admission::foreign_origin;
  const std::string_view from = host_of(origin->substr(scheme + 3));
  if (from.empty()) return Admission::foreign_origin;
  if (is_loopback(from)) return Admission::admitted;
  return !token.empty() && from == host_of(host) ? Admission::admitted : Admission::foreign_origin;
}

bool is_token(std::string_view token) {
  return token.size() >= 8 && token.size() <= 128 && std::ranges::all_of(token, [](char c) {
           return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' ||
                  c == '.' || c == '_' || c == '~';
         });
}

}  // namespace mien::sink
