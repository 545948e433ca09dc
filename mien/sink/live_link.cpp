#include "mien/sink/live_link.h"

#include <fmt/format.h>

#include <algorithm>

#include "mien/core/sha256.h"

namespace mien::sink {
namespace {

constexpr std::uint8_t kPacketVersion = 6;
constexpr std::int32_t kRateDenominator = 1;

void append_text(const std::string& text, Datagrams& out) {
  const std::string_view part = std::string_view(text).substr(0, kMaxLiveLinkName);
  out.big(static_cast<std::int32_t>(part.size()));
  out.append(part);
}

}  // namespace

LiveLinkSource live_link_source(std::string_view subject) {
  Sha256 hash;
  hash.add(std::as_bytes(std::span(std::string_view("mien live link subject "))));
  hash.add(std::as_bytes(std::span(subject)));
  std::string digits = hash.hex().substr(0, 32);
  digits[12] = '8';  // UUID version 8: made by a rule of our own (RFC 9562).
  digits[16] = "89ab"[static_cast<std::size_t>(digits[16]) % 4];
  const std::string_view d = digits;
  return {fmt::format("{}-{}-{}-{}-{}", d.substr(0, 8), d.substr(8, 4), d.substr(12, 4), d.substr(16, 4),
                      d.substr(20)),
          std::string(subject.substr(0, kMaxLiveLinkName))};
}

std::array<float, face::kLiveLinkValueCount> live_link_values(const ArkitFrame& frame) {
  std::array<float, face::kLiveLinkValueCount> values{};
  auto next = std::ranges::copy(frame.weights.values, values.begin()).out;
  // Zero is added, or subtracted from, so that no -0 is sent: logs would show it as a sign.
  const Vec3 head = face::livelink_from_head(frame.head);
  for (int k = 0; k < 3; ++k) *next++ = static_cast<float>(head[k]) + 0.0F;
  for (const Eigen::Vector2f& eye : frame.eyes_rad) {
    *next++ = 0.0F - eye.x();
    *next++ = 0.0F - eye.y();
    *next++ = 0.0F;
  }
  return values;
}

void encode_live_link(const LiveLinkFrame& frame, const LiveLinkSource& source, Datagrams& out) {
  out.begin();
  out.big(kPacketVersion);
  append_text(source.device_id, out);
  append_text(source.subject, out);
  out.big(static_cast<std::int32_t>(frame.number & 0x7FFFFFFF));
  out.big(0.0F);  // Frames of ours, and of a virtual phone, stand on their grid.
  out.big(frame.rate_hz);
  out.big(kRateDenominator);
  if (!frame.values) return;
  out.big(static_cast<std::uint8_t>(frame.values->size()));
  for (const float value : *frame.values) out.big(value);
}

void encode_live_link(const ArkitFrame& frame, const LiveLinkSource& source, std::int64_t frame_index,
                      Datagrams& out) {
  encode_live_link({.number = frame_index, .values = live_link_values(frame)}, source, out);
}

}  // namespace mien::sink
