#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/session/command.h"
#include "mien/session/prompt_script.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::session;
  const auto script = parse_prompts({reinterpret_cast<const char*>(data), size}, "input");
  if (!script) return 0;
  if (script->prompts.empty() || script->prompts.size() > kMaxPrompts) std::abort();
  // What was accepted is a command that a session takes, and the same pose again.
  for (const Prompt& prompt : script->prompts) {
    const auto command = parse_command(write_command(AddPrompt{prompt}));
    if (!command || std::get<AddPrompt>(*command).prompt != prompt) std::abort();
  }
  return 0;
}
