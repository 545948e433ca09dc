#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/sink/address.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto address = mien::sink::parse_address(std::string_view(reinterpret_cast<const char*>(data), size));
  if (!address) {
    // One line, whatever was typed.
    if (address.error().message().find('\n') != std::string::npos) std::abort();
    return 0;
  }
  if (address->scheme.empty() || (address->host.empty() == address->path.empty() && address->host.empty()))
    std::abort();
  for (const auto& [name, value] : address->options)
    if (name.empty() || address->option(name) == nullptr || *address->option(name) != value) std::abort();
  (void)address->whole_option("rate", 60, 1, 60);
  (void)address->endpoint(11111);
  return 0;
}
