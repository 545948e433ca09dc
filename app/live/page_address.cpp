#include "app/live/page_address.h"

#include <string_view>

#include "mien/live/network_interfaces.h"

namespace mien::app {

std::vector<std::string> own_addresses() {
  std::vector<std::string> own;
  for (const live::NetworkInterface& one : live::network_interfaces()) {
    if (one.address.starts_with("169.254.") || one.address.starts_with("fe80:")) continue;
    own.push_back(one.address.find(':') == std::string::npos ? one.address : "[" + one.address + "]");
  }
  return own;
}

std::vector<std::string> openable_addresses(const std::string& served, const std::vector<std::string>& own) {
  constexpr std::string_view kEveryV4 = "http://0.0.0.0:";
  constexpr std::string_view kEvery = "http://[::]:";
  const bool v4 = served.starts_with(kEveryV4);
  if (!v4 && !served.starts_with(kEvery)) return {served};
  const std::string rest = served.substr((v4 ? kEveryV4 : kEvery).size() - 1);
  std::vector<std::string> out;
  for (const std::string& address : own)
    if (!v4 || !address.starts_with('[')) out.push_back("http://" + address + rest);
  if (out.empty()) out.push_back("http://localhost" + rest);
  return out;
}

}  // namespace mien::app
