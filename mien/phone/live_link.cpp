#include "mien/phone/live_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "mien/core/bytes.h"
#include "mien/sensor/packet_envelope.h"

namespace mien::phone {
namespace {

constexpr std::uint8_t kVersion = 6;
constexpr std::uint8_t kLikelyVersions = 32;  // From 1 on: no text, and no packet of ours, begins so.
constexpr std::size_t kLeastBytes = 1 + 4 + 4;
constexpr std::size_t kFrameBytes = 16;  // Its number, sub-frame and rate.
const char* const kWhere = "Live Link packet";
constexpr double kLeastRate_hz = 1, kMostRate_hz = 1000;

std::unexpected<Error> refuse_packet(ErrorCode code, std::string what) {
  return fail(code, std::move(what), kWhere);
}

/// A text behind its length; empty and `ok` false where it is too long.
std::string_view text(ByteReader& reader, bool& ok) {
  const auto size = reader.big<std::int32_t>();
  if (size < 0 || static_cast<std::size_t>(size) > kMostLiveLinkName) {
    ok = false;
    return {};
  }
  return as_text(reader.take(static_cast<std::size_t>(size)));
}

}  // namespace

DeviceTime LiveLinkPacket::time() const {
  return DeviceTime(from_seconds((static_cast<double>(frame) + static_cast<double>(sub_frame)) *
                                 rate_denominator / rate_numerator));
}

bool is_live_link(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  const auto version = reader.big<std::uint8_t>();
  const auto size = reader.big<std::int32_t>();
  return reader.ok() && version > 0 && version < kLikelyVersions && size > 0 &&
         static_cast<std::size_t>(size) <= kMostLiveLinkName &&
         bytes.size() >= kLeastBytes + static_cast<std::size_t>(size);
}

std::optional<unsigned> unknown_live_link_version(std::span<const std::byte> bytes) {
  if (!is_live_link(bytes)) return std::nullopt;
  const auto version = std::to_integer<unsigned>(bytes.front());
  return version == kVersion ? std::nullopt : std::optional(version);
}

Result<LiveLinkPacket> parse_live_link(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  if (const auto version = reader.big<std::uint8_t>(); reader.ok() && version != kVersion)
    return refuse_packet(ErrorCode::unsupported, fmt::format("its version is {}, not {}", version, kVersion));
  LiveLinkPacket packet;
  bool names_ok = true;
  packet.device_id = text(reader, names_ok);
  if (names_ok) packet.subject = text(reader, names_ok);
  if (!names_ok)
    return refuse_packet(ErrorCode::malformed, "a name is longer than 255 bytes, or less than 0");
  if (!reader.ok()) return refuse_packet(ErrorCode::truncated, "it ends inside its names");
  if (reader.left() < kFrameBytes) return packet;  // It tells neither a face nor its frame.
  packet.timed = true;
  const auto frame = reader.big<std::int32_t>();
  packet.sub_frame = reader.big<float>();
  const auto numerator = reader.big<std::int32_t>();
  const auto denominator = reader.big<std::int32_t>();
  if (frame < 0) return refuse_packet(ErrorCode::out_of_range, "its frame has a number below 0");
  if (!(packet.sub_frame >= 0 && packet.sub_frame <= 1))
    return refuse_packet(ErrorCode::out_of_range, "its sub-frame is not from 0 to 1");
  const double rate_hz = denominator > 0 ? static_cast<double>(numerator) / denominator : 0;
  if (!(rate_hz >= kLeastRate_hz && rate_hz <= kMostRate_hz))
    return refuse_packet(ErrorCode::out_of_range,
                         fmt::format("{}/{} is no rate of a phone", numerator, denominator));
  packet.frame = static_cast<std::uint32_t>(frame);
  packet.rate_numerator = static_cast<std::uint32_t>(numerator);
  packet.rate_denominator = static_cast<std::uint32_t>(denominator);
  MIEN_TRY(sensor::check_device_time(packet.time(), kWhere));

  if (reader.left() == 0) return packet;  // No face.
  const auto count = reader.big<std::uint8_t>();
  if (count != 0 && count != face::kLiveLinkValueCount)
    return refuse_packet(ErrorCode::unsupported,
                         fmt::format("it has {} values, not {}", count, face::kLiveLinkValueCount));
  if (count > 0) {
    auto& values = packet.values.emplace();
    for (float& value : values) value = reader.big<float>();
    if (!reader.ok()) return refuse_packet(ErrorCode::truncated, "it ends inside its values");
    if (!std::ranges::all_of(values, [](float value) { return std::abs(value) <= kMostLiveLinkValue; }))
      return refuse_packet(ErrorCode::out_of_range,
                           "a value is not finite, or beyond what weights and angles are");
  }
  if (reader.left() > 0)
    return refuse_packet(ErrorCode::malformed,
                         fmt::format("{} bytes stand behind its last value", reader.left()));
  return packet;
}

ToldFace told_face(const std::array<float, face::kLiveLinkValueCount>& values) {
  ToldFace face;
  face.set = ShapeSet::arkit52;
  const std::size_t count = count_of(face.set);
  for (std::size_t i = 0; i < count; ++i) face.weights[i] = std::clamp(values[i], 0.0F, 1.0F);
  const auto angle = [&](std::size_t i) { return static_cast<double>(values[count + i]); };
  const Vec3 turn_rad(angle(0), angle(1), angle(2));
  face.head = ToldHead{.rotation = wxyz_of(face::head_from_livelink(turn_rad).normalized())};
  return face;
}

using sensor::Verdict;

double LiveLinkProtocol::usual_step(const Phone& phone) {
  std::array<std::uint32_t, kSteps> steps = phone.steps;
  const auto known = std::span(steps).first(std::min(phone.next_step, kSteps));
  if (known.empty()) return 0;
  // A few early frames do not make it shorter, nor lost ones longer.
  std::ranges::sort(known);
  const std::uint32_t least = known[known.size() / 4];
  if (least == 1) return 1;
  double sum = 0, count = 0;
  for (const std::uint32_t step : known)
    if (step == least || step == least + 1) {
      sum += step;
      ++count;
    }
  return sum / count;
}

void LiveLinkProtocol::count(std::uint32_t frame, bool face, Phone& phone) {
  if (!phone.frame) {
    phone.frame = phone.sequence = frame;
    return;
  }
  const auto ahead = static_cast<std::int64_t>(frame) - static_cast<std::int64_t>(*phone.frame);
  if (ahead > 0) phone.steps[phone.next_step++ % kSteps] = static_cast<std::uint32_t>(ahead);
  if (const double usual = usual_step(phone); usual > 0 && ahead != 0) {
    auto frames = std::llround(static_cast<double>(ahead) / usual);
    if (frames == 0) frames = ahead > 0 ? 1 : -1;
    if (!face && frames > 0) --frames;
    phone.sequence += static_cast<std::uint32_t>(frames);
  }
  phone.frame = frame;
}

Verdict LiveLinkProtocol::receive(HostTime arrival, sensor::Peer, std::span<const std::byte> datagram,
                                  sensor::Inbox& inbox) {
  const auto packet = parse_live_link(datagram);
  if (!packet) return packet.error().code == ErrorCode::unsupported ? Verdict::ignored : Verdict::malformed;
  auto* const place = phones_.meet(packet->device_id, arrival);
  if (place == nullptr) return Verdict::ignored;
  Phone& phone = place->state;
  if (packet->timed) count(packet->frame, packet->values.has_value(), phone);
  if (!packet->values) {
    inbox.alive = inbox.no_face = {place->device, 0};
    return Verdict::taken;
  }
  add_readings(told_face(*packet->values), place->device, {phone.sequence, packet->time()}, inbox);
  return Verdict::taken;
}

}  // namespace mien::phone
