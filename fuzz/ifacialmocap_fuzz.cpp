#include <cstdint>
#include <cstdlib>
#include <span>

#include "mien/phone/ifacialmocap.h"

// What was accepted is sound, and goes through samples.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien;
  const auto bytes = std::as_bytes(std::span(data, size));
  static_cast<void>(phone::is_ifacialmocap(bytes));
  const auto frame = phone::parse_ifacialmocap(bytes);
  if (!frame) return 0;
  if (!phone::is_sound(frame->face)) std::abort();
  phone::IFacialMocapProtocol protocol;
  sensor::Inbox inbox;
  if (protocol.receive({}, 1, bytes, inbox) != sensor::Verdict::taken) std::abort();
  phone::ToldFace face;
  for (const sensor::Reading& reading : inbox.readings)
    if (!phone::add_sample(reading.sample, face)) std::abort();
  return 0;
}
