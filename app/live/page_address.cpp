#include "app/live/page_address.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <array>
#include <memory>
#include <string_view>

#include "mien/core/host_port.h"

namespace mien::app {
namespace {

/// Empty where a browser cannot open it.
std::string text_of(const sockaddr& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (address.sa_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(address).sin_addr;
    const std::uint32_t number = ntohl(v4.s_addr);
    const bool link_local = number >> 16U == 0xA9FE;
    if (link_local || ::inet_ntop(AF_INET, &v4, text.data(), text.size()) == nullptr) return {};
    return text.data();
  }
  if (address.sa_family == AF_INET6) {
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
    if (IN6_IS_ADDR_LINKLOCAL(&v6) || ::inet_ntop(AF_INET6, &v6, text.data(), text.size()) == nullptr)
      return {};
    return std::string("[") + text.data() + "]";
  }
  return {};
}

}  // namespace

std::vector<std::string> own_addresses() {
  std::vector<std::string> out;
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return out;
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> owned(list, &::freeifaddrs);
  for (const ifaddrs* one = list; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || (one->ifa_flags & IFF_UP) == 0) continue;
    if (std::string text = text_of(*one->ifa_addr); !text.empty()) out.push_back(std::move(text));
  }
  // Loopback's last, each kind in the machine's own order.
  std::vector<std::string> own;
  for (const bool loopback : {false, true})
    for (const std::string& address : out)
      if (is_loopback(host_of(address)) == loopback) own.push_back(address);
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
