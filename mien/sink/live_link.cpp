#include "mien/sink/live_link.h"

#include <fmt/format.h>

#include "mien/core/sha256.h"
#include "mien/face/livelink_csv.h"

namespace mien::sink {
namespace {

constexpr std::uint8_t kPacketVersion = 6;
constexpr std::int32_t kRateNumerator = 60;
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

void encode_live_link(const ArkitFrame& frame, const LiveLinkSource& source, std::int64_t frame_index,
                      Datagrams& out) {
  out.begin();
  out.big(kPacketVersion);
  append_text(source.device_id, out);
  append_text(source.subject, out);
  out.big(static_cast<std::int32_t>(frame_index & 0x7FFFFFFF));
  out.big(0.0F);  // Our frames stand on the grid.
  out.big(kRateNumerator);
  out.big(kRateDenominator);
  out.big(static_cast<std::uint8_t>(face::kLiveLinkValueCount));
  for (const float weight : frame.weights.values) out.big(weight);
  const Vec3 head = face::livelink_from_head(frame.head);
  for (int k = 0; k < 3; ++k) out.big(static_cast<float>(head[k]));
  for (const Eigen::Vector2f& eye : frame.eyes_rad) {
    out.big(0.0F - eye.x());  // Never -0, which some logs show as a sign.
    out.big(0.0F - eye.y());
    out.big(0.0F);
  }
}

}  // namespace mien::sink
