#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "fuzz/with_checksum.h"
#include "mien/speech/sound_block.h"
#include "mien/speech/sound_protocol.h"

namespace {

void check(std::span<const std::byte> bytes) {
  // The header, and what is left for its payload.
  const std::size_t header_bytes = std::min(bytes.size(), mien::speech::kHeaderBytes);
  mien::speech::SoundProtocol protocol;
  mien::sensor::Inbox inbox;
  const auto verdict =
      protocol.receive_with_payload({}, 0, bytes.first(header_bytes), bytes.subspan(header_bytes), inbox);
  if ((verdict == mien::sensor::Verdict::taken) == inbox.readings.empty()) std::abort();
  if (verdict == mien::sensor::Verdict::taken) {
    const auto block = mien::speech::samples_of(inbox.readings[0].payload);
    if (!block || !std::ranges::equal(mien::speech::payload_of(*block), bytes.subspan(header_bytes)))
      std::abort();
  }
  if (const auto packet = mien::speech::parse_packet(bytes)) {
    const auto block = mien::speech::samples_of(packet->samples);
    const auto again = mien::speech::encode_packet(packet->header, block.value());
    if (!again || !std::ranges::equal(*again, bytes)) std::abort();
  }
  mien::speech::MicrophoneProtocol microphones;
  mien::sensor::Inbox heard;
  if ((microphones.receive({}, 0, bytes, heard) == mien::sensor::Verdict::taken) == heard.readings.empty())
    std::abort();
  const auto header = mien::speech::parse_header(bytes);
  if (!header) return;
  // What was accepted goes back to the same bytes.
  const auto again = mien::speech::encode_header(*header);
  if (!again || !std::ranges::equal(*again, bytes)) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  with_checksum(data, size, check);
  return 0;
}
