#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/sink/ws_admission.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // A request's target, Origin and Host, a line each.
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  const auto line = [&rest] {
    const std::string_view front = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(front.size() < rest.size() ? front.size() + 1 : rest.size());
    return front;
  };
  const std::string_view target = line();
  const std::string_view origin = line();
  const std::string_view host = line();
  using mien::sink::Admission;
  const auto open = mien::sink::judge_upgrade(target, origin, host, "");
  const auto guarded = mien::sink::judge_upgrade(target, origin, host, "abcd1234");
  // Without a token only pages of this machine come in; with one, none comes in that does not say it.
  if (open == Admission::no_token) std::abort();
  if (open == Admission::admitted && origin.find("localhost") == std::string_view::npos &&
      origin.find("127.") == std::string_view::npos && origin.find("::1") == std::string_view::npos)
    std::abort();
  if (guarded == Admission::admitted && target.find("token=abcd1234") == std::string_view::npos) std::abort();
  return 0;
}
