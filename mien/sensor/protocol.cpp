#include "mien/sensor/protocol.h"

#include <fmt/format.h>

#include <charconv>

#include "mien/sensor/packet_envelope.h"

namespace mien::sensor {

std::string format_device(const DeviceKey& key) {
  std::string text;
  for (int octet = 5; octet >= 0; --octet)
    text += fmt::format("{}{:02X}", text.empty() ? "" : ":",
                        (key.device >> (8U * static_cast<unsigned>(octet))) & 0xFFU);
  if (key.channel != 0) text += fmt::format("/{}", key.channel);
  return text;
}

Result<DeviceKey> parse_device(std::string_view text) {
  const auto bad = [&] {
    return fail(ErrorCode::malformed, "not a device", std::string(text),
                "write it as 02:4D:49:45:4E:07, or 02:4D:49:45:4E:07/1 for a board's second sensor");
  };
  DeviceKey key;
  const std::string_view whole = text;
  for (int octet = 0; octet < 6; ++octet) {
    unsigned value = 0;
    if (text.size() < 2) return bad();
    const auto [end, code] = std::from_chars(text.data(), text.data() + 2, value, 16);
    if (code != std::errc{} || end != text.data() + 2) return bad();
    key.device = key.device << 8U | value;
    text.remove_prefix(2);
    if (octet == 5) break;
    if (text.empty() || text.front() != ':') return bad();
    text.remove_prefix(1);
  }
  if (text.empty()) return key;
  if (text.front() != '/' || text.size() < 2) return bad();
  const auto [end, code] = std::from_chars(text.data() + 1, text.data() + text.size(), key.channel);
  if (code != std::errc{} || end != whole.data() + whole.size()) return bad();
  return key;
}

std::optional<unsigned> Protocol::unknown_version(std::span<const std::byte> datagram) const {
  return unknown_packet_version(datagram);
}

void Inbox::clear() {
  readings.clear();
  announcements.clear();
  batteries.clear();
  pulses.clear();
  alive.reset();
  no_face.reset();
  recentre = false;
  reply.clear();
  opened.clear();
}

}  // namespace mien::sensor
