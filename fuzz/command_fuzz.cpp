#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/session/command.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::session;
  const auto command = parse_command({reinterpret_cast<const char*>(data), size});
  if (!command) return 0;
  // What was accepted is written as text that reads back as the same.
  const std::string written = write_command(*command);
  const auto again = parse_command(written);
  if (!again) {
    // Only by the escapes of its texts can it have grown too long.
    if (written.size() <= kMaxCommandBytes) std::abort();
    return 0;
  }
  if (again->index() != command->index() || write_command(*again) != written) std::abort();
  return 0;
}
