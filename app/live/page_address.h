#pragma once

#include <string>
#include <vector>

namespace mien::app {

/// This machine's own addresses, as URLs have them (IPv6 in brackets), of interfaces that are up: those that
/// others may reach first, loopback's last. Link-local ones are left out: browsers do not open them.
[[nodiscard]] std::vector<std::string> own_addresses();

/// What a browser can open, where a server says that it is at `served`: the address itself, or, where that
/// stands for every address of this machine (0.0.0.0, [::]), each of `own` in its place; of 0.0.0.0 only
/// IPv4 ones. Never empty.
[[nodiscard]] std::vector<std::string> openable_addresses(const std::string& served,
                                                          const std::vector<std::string>& own);

}  // namespace mien::app
