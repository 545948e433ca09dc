#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "mien/phone/live_link.h"

// What was accepted is sound, and goes through samples.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien;
  const auto bytes = std::as_bytes(std::span(data, size));
  if (const auto packet = phone::parse_live_link(bytes); packet && packet->values)
    if (!phone::is_sound(phone::told_face(*packet->values))) std::abort();
  // A conversation: datagrams of up to 255 bytes more than the smallest, each behind its length.
  phone::LiveLinkProtocol protocol;
  sensor::Inbox inbox;
  std::int64_t ms = 0;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t length = std::min(bytes.size() - at - 1, static_cast<std::size_t>(data[at]) + 80);
    inbox.clear();
    protocol.receive(HostTime(std::chrono::milliseconds(ms += 16)), 1, bytes.subspan(at + 1, length), inbox);
    for (const sensor::Reading& reading : inbox.readings) {
      phone::ToldFace face;
      if (!phone::add_sample(reading.sample, face)) std::abort();
    }
    at += 1 + length;
  }
  return 0;
}
