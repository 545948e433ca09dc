#include "mien/sink/ws_admission.h"

#include <algorithm>

#include "mien/core/host_port.h"
#include "mien/core/secret.h"

namespace mien::sink {

Admission judge_upgrade(std::string_view target, std::optional<std::string_view> origin,
                        std::string_view host, std::string_view token) {
  if (!token.empty() && !same_secret(token_of(target), token)) return Admission::no_token;
  if (!origin) return Admission::admitted;
  const std::size_t scheme = origin->find("://");
  if (scheme == std::string_view::npos) return Admission::foreign_origin;
  const std::string_view from = host_of(origin->substr(scheme + 3));
  if (from.empty()) return Admission::foreign_origin;
  if (is_loopback(from)) return Admission::admitted;
  return !token.empty() && from == host_of(host) ? Admission::admitted : Admission::foreign_origin;
}

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

bool is_token(std::string_view token) {
  return token.size() >= 8 && token.size() <= 128 && std::ranges::all_of(token, [](char c) {
           return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' ||
                  c == '.' || c == '_' || c == '~';
         });
}

}  // namespace mien::sink
