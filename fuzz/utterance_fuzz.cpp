#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/performer/performer.h"
#include "mien/performer/speech.h"

/// Whatever is read is also performed, briefly: no JSON may reach an impossible frame.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien;
  const auto utterance = performer::parse_utterance({reinterpret_cast<const char*>(data), size});
  if (!utterance) return 0;
  performer::Script script;
  performer::Segment segment;
  segment.block = performer::Block::reading;
  segment.duration_s = 0.5;
  segment.utterance = *utterance;
  script.segments.push_back(segment);
  for (const auto& frame : performer::perform(script, performer::plain_style(), Random(1)).frames)
    for (const float weight : frame.weights.values)
      if (!(weight >= 0 && weight <= 1.1001F)) std::abort();
  return 0;
}
