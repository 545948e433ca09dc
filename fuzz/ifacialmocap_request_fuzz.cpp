#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "mien/sink/ifacialmocap.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  const auto request = mien::sink::parse_ifacialmocap_request(bytes);
  if (!request) return 0;
  // Whatever is a request has the phrase that no other program says, and a line end changes nothing.
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (text.find("sahuasouryya9218sauhuiayeta91555dy3719") == std::string_view::npos) std::abort();
  std::vector<std::byte> line(bytes.begin(), bytes.end());
  line.push_back(std::byte{'\n'});
  const auto again = mien::sink::parse_ifacialmocap_request(line);
  if (line.size() <= 128 && again != request) std::abort();
  return 0;
}
