#include <cstdint>
#include <cstdlib>
#include <span>

#include "mien/modalities/osc_commands.h"

// Any bytes are a command, or malformed, or none; a button asks for something only where it is pressed, and
// the same bytes say the same again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  mien::modalities::OscCommands commands;
  const bool recognised = commands.recognises(bytes);
  mien::sensor::Inbox inbox, again;
  const auto verdict = commands.receive({}, 0, bytes, inbox);
  if (inbox.recentre != (verdict == mien::sensor::Verdict::taken)) std::abort();
  if (verdict == mien::sensor::Verdict::refused || !inbox.readings.empty()) std::abort();
  if (commands.receive({}, 1, bytes, again) != verdict || again.recentre != inbox.recentre) std::abort();
  if (commands.recognises(bytes) != recognised) std::abort();
  return 0;
}
