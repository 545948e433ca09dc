#include "lab/bench/attack_programs.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>

#include "mien/core/bytes.h"
#include "mien/gaze/packet.h"
#include "mien/phone/packet.h"
#include "mien/sensor/packet_envelope.h"
#include "mien/sensor/protocol.h"
#include "mien/sink/live_link.h"

namespace mien::lab {
namespace {

using Bytes = std::vector<std::byte>;

/// OSC's padding: to a multiple of four, with at least one zero.
void write_osc_text(std::string_view text, ByteWriter& out) {
  out.append(text);
  for (std::size_t i = text.size() % 4; i < 4; ++i) out.little(std::uint8_t{0});
}

/// A message whose arguments are these bytes, whatever its types say.
Bytes osc_message(std::string_view address, std::string_view types, std::span<const float> numbers) {
  ByteWriter out;
  write_osc_text(address, out);
  write_osc_text(types, out);
  for (const float number : numbers) out.big(number);
  return out.release();
}

Bytes in_bundle(std::span<const std::byte> element, std::uint32_t said_size) {
  ByteWriter out;
  write_osc_text("#bundle", out);
  out.big(std::uint64_t{1});
  out.big(said_size);
  out.append(element);
  return out.release();
}

constexpr std::array<std::string_view, 6> kCoordinates = {
    "/avatar/parameters/v2/EyeLeftX",  "/avatar/parameters/v2/EyeLeftY", "/avatar/parameters/v2/EyeRightX",
    "/avatar/parameters/v2/EyeRightY", "/tracking/eye/LeftRightVec",     "/avatar/parameters/v2/EyeLidLeft"};

float any_number(Random& random) {
  switch (random.below(6)) {
    case 0:
      return std::numeric_limits<float>::quiet_NaN();
    case 1:
      return 1e30F;
    case 2:
      return -std::numeric_limits<float>::infinity();
    default:
      return static_cast<float>(random.uniform(-1.5, 1.5));
  }
}

class OscPrograms final : public Speech {
 public:
  explicit OscPrograms(Random random) : random_(random) {}

  Bytes next(double time_s, std::size_t) override {
    const std::string_view address = kCoordinates[said_++ % kCoordinates.size()];
    const std::array right = {0.5F * static_cast<float>(std::sin(40 * time_s))};
    const Bytes whole = osc_message(address, ",f", right);
    switch (random_.below(8)) {
      case 0: {  // Numbers that none should be.
        const std::array wrong = {any_number(random_)};
        return osc_message(address, ",f", wrong);
      }
      case 1:  // Other types than the bytes are, among them a blob of a gigabyte and more by its length.
        return osc_message(address, std::array{",s", ",d", ",ffff", ",b", ",["}[random_.below(5)], right);
      case 2:  // An element of 4 GB by its length.
        return in_bundle(whole, 0xFFFF'FFFCU);
      case 3: {  // A hundred bundles, one in the other.
        Bytes deep = whole;
        for (int level = 0; level < 100; ++level)
          deep = in_bundle(deep, static_cast<std::uint32_t>(deep.size()));
        return deep;
      }
      case 4: {  // An address without an end.
        Bytes endless(4 * (1 + random_.below(256)), std::byte{'a'});
        endless[0] = std::byte{'/'};
        return endless;
      }
      case 5:
        return damaged(whole, random_);
      default:
        return whole;
    }
  }

 private:
  Random random_;
  std::size_t said_ = 0;
};

/// The device of the rig's sensor of this kind, or a stranger's.
std::uint64_t device_of(const sensor::Rig& rig, std::string_view kind) {
  for (const auto& sensor : rig.sensors)
    if (sensor.kind == kind)
      if (const auto device = sensor::parse_device(sensor.device)) return device->device;
  return 0x0200'0000'00F0ULL;
}

class FacePrograms final : public Speech {
 public:
  FacePrograms(const sensor::Rig& rig, Random random)
      : gaze_(device_of(rig, "gaze")), weights_(device_of(rig, "weights")), random_(random) {}

  Bytes next(double time_s, std::size_t) override {
    ++said_;
    Bytes packet = said_ % 2 == 0 ? gaze_packet(time_s) : weights_packet(time_s);
    switch (random_.below(4)) {
      case 0:
        return damaged(std::move(packet), random_);
      case 1: {  // A number that none should be, somewhere behind the head, under a checksum that is right.
        ByteWriter number;
        number.little(any_number(random_));
        const std::size_t at = 4 * (8 + random_.below(packet.size() / 4 - 9));
        std::ranges::copy(number.bytes(), packet.begin() + static_cast<std::ptrdiff_t>(at));
        mend_checksum(packet);
        return packet;
      }
      default:
        return packet;
    }
  }

 private:
  static DeviceTime device_time(double time_s) {
    return DeviceTime(std::chrono::floor<std::chrono::microseconds>(from_seconds(100 + time_s)));
  }
  Bytes gaze_packet(double time_s) const {
    gaze::Packet packet{.device = gaze_, .sequence = static_cast<std::uint32_t>(said_)};
    packet.time = device_time(time_s);
    packet.eyes.fill({.yaw_rad = 1.5F, .pitch_rad = -1.5F, .confidence = 1, .openness = 0.0F});
    return gaze::encode_packet(packet).value_or(Bytes());
  }
  Bytes weights_packet(double time_s) const {
    phone::Packet packet{.device = weights_, .sequence = static_cast<std::uint32_t>(said_)};
    packet.time = device_time(time_s);
    packet.face.set = phone::ShapeSet::unified;
    packet.face.origin = phone::Origin::measured;
    packet.face.weights.fill(1);
    packet.face.confidence.fill(1);
    packet.face.head =
        phone::ToldHead{.position_m = {99, -99, 99}, .position_known = true, .rotation = {0, 1, 0, 0}};
    return phone::encode_packet(packet).value_or(Bytes());
  }

  std::uint64_t gaze_, weights_;
  Random random_;
  std::size_t said_ = 0;
};

class FacePhones final : public Speech {
 public:
  explicit FacePhones(Random random) : random_(random) {}

  Bytes next(double time_s, std::size_t socket) override {
    sink::LiveLinkSource source = sources_[socket / 2 % sources_.size()];
    sink::LiveLinkFrame frame;
    frame.number = kBegins + std::llround(frame.rate_hz * time_s);
    frame.values.emplace().fill(0.9F);
    const std::uint64_t manner = random_.below(8);
    if (manner == 1) source.subject = "somebody else";
    if (manner == 2) frame.number += std::int64_t{3600} * frame.rate_hz;
    if (manner == 3) frame.values.reset();
    if (manner == 4) (*frame.values)[random_.below(frame.values->size())] = any_number(random_);
    out_.clear();
    sink::encode_live_link(frame, source, out_);
    Bytes packet(out_[0].begin(), out_[0].end());
    return manner == 0 ? damaged(std::move(packet), random_) : packet;
  }

 private:
  static constexpr std::int64_t kBegins = 500'000;
  std::array<sink::LiveLinkSource, 2> sources_ = {sink::live_link_source("a phone"),
                                                  sink::live_link_source("another phone")};
  Random random_;
  sink::Datagrams out_;
};

}  // namespace

std::unique_ptr<Speech> osc_programs(const Victims&, Random random) {
  return std::make_unique<OscPrograms>(random);
}

std::unique_ptr<Speech> face_programs(const Victims& victims, Random random) {
  return std::make_unique<FacePrograms>(victims.rig, random);
}

std::unique_ptr<Speech> face_phones(const Victims&, Random random) {
  return std::make_unique<FacePhones>(random);
}

std::vector<std::byte> damaged(std::vector<std::byte> datagram, Random& random) {
  switch (random.below(3)) {
    case 0:
      for (std::uint64_t flips = 1 + random.below(8); flips > 0; --flips)
        datagram[random.below(datagram.size())] ^= static_cast<std::byte>(1U << random.below(8));
      break;
    case 1:
      datagram.resize(1 + random.below(datagram.size()));
      break;
    default:
      for (std::uint64_t more = 1 + random.below(64); more > 0; --more)
        datagram.push_back(static_cast<std::byte>(random.below(256)));
  }
  if (!random.chance(0.5)) mend_checksum(datagram);
  return datagram;
}

void mend_checksum(std::vector<std::byte>& datagram) {
  if (datagram.size() <= sensor::kChecksumBytes) return;
  datagram.resize(datagram.size() - sensor::kChecksumBytes);
  ByteWriter mended;
  mended.append(datagram);
  sensor::write_checksum(0, mended);
  datagram = mended.release();
}

}  // namespace mien::lab
