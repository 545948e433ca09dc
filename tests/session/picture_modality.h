#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/session/session.h"

// A modality made for tests, with what real ones with cameras will have: a datagram that says when a picture
// was taken, the picture as its payload, a tracker that uses each of its bytes, and a reducer.
namespace mien::session::test {

inline constexpr const char* kCameraRig =
    "name = \"camera\"\nreference = \"eye\"\n[[sensor]]\nname = \"eye\"\nkind = \"picture\"\nsite = \"eye\"\n"
    "side = \"L\"\nrole = \"face\"\ndevice = \"02:00:00:00:00:01\"\n";

/// "PIC", a sequence number, the device's time.
inline std::vector<std::byte> picture_datagram(std::uint32_t sequence, DeviceTime time) {
  ByteWriter out;
  out.append("PIC");
  out.little(sequence);
  out.little(time.time_since_epoch().count());
  return out.release();
}

/// The picture of a moment: the same for the same number, and unlike every other.
inline std::vector<std::byte> picture(std::uint32_t sequence, std::size_t bytes) {
  std::vector<std::byte> out(bytes);
  std::uint32_t state = sequence * 2654435761U + 1;
  for (std::byte& one : out) {
    state = state * 1664525U + 1013904223U;
    one = static_cast<std::byte>(state >> 24U);
  }
  return out;
}

class PictureProtocol final : public sensor::Protocol {
 public:
  [[nodiscard]] std::string_view name() const override { return "picture"; }
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override {
    return as_text(datagram).starts_with("PIC");
  }
  sensor::Verdict receive(HostTime, sensor::Peer, std::span<const std::byte>, sensor::Inbox&) override {
    return sensor::Verdict::malformed;  // A picture without its picture.
  }
  sensor::Verdict receive_with_payload(HostTime, sensor::Peer, std::span<const std::byte> datagram,
                                       std::span<const std::byte> payload, sensor::Inbox& inbox) override {
    ByteReader reader(datagram.subspan(3));
    sensor::Reading& reading = inbox.readings.emplace_back();
    reading.from.device = 0x0200'0000'0001;
    reading.sample.sequence = reader.little<std::uint32_t>();
    reading.sample.time = DeviceTime(Duration(reader.little<std::int64_t>()));
    reading.sample.kind = static_cast<sensor::SampleKind>(200);
    reading.sample.count = 1;
    reading.sample.values[0] = 1;
    reading.payload = payload;
    return reader.ok() && reader.left() == 0 ? sensor::Verdict::taken : sensor::Verdict::malformed;
  }
};

/// The jaw is a checksum of the newest payload.
class PictureTracker final : public tracker::Tracker {
 public:
  struct Seen {
    std::size_t payloads = 0;
    std::size_t bytes = 0;  ///< Of the newest.
    std::size_t alone = 0;  ///< Samples without a payload.
  };
  explicit PictureTracker(Seen* seen = nullptr) : seen_(seen != nullptr ? seen : &own_) {}
  [[nodiscard]] std::string_view modality() const override { return "picture"; }
  void add(HostTime, const sensor::Sample&) override { ++seen_->alone; }
  void add_with_payload(HostTime, const sensor::Sample&, std::span<const std::byte> payload) override {
    ++seen_->payloads;
    seen_->bytes = payload.size();
    jaw_ = static_cast<float>(crc32(payload) % 1000U) / 1000;
  }
  void forget(std::uint16_t) override {}
  tracker::TickResult tick(DeviceTime frame, const sensor::TimeLines&, face::OutputFrame& out) override {
    out = {};
    out.time = frame;
    out.weights[face::shape("jawOpen")] = jaw_;
    out.provenance.fill(face::Provenance::measured);
    out.confidence.fill(1);
    return {.sensors_present = 1, .calibration = {}};
  }

 private:
  Seen own_;
  Seen* seen_;
  float jaw_ = 0;
};

/// Of a picture its 16 sums of every 16th byte, scaled. A picture that begins with 0xFFFF has none.
class PictureReducer final : public sensor::Reducer {
 public:
  explicit PictureReducer(std::uint32_t scale = 1)
      : scale_(scale), hash_(sensor::kReducerHashDigits, static_cast<char>('0' + scale)) {}
  [[nodiscard]] std::string_view hash() const override { return hash_; }
  [[nodiscard]] std::optional<std::size_t> reduce(std::span<const std::byte>,
                                                  std::span<const std::byte> payload,
                                                  std::span<std::byte> out) override {
    if (payload.size() < 2 || (payload[0] == std::byte{0xFF} && payload[1] == std::byte{0xFF})) return {};
    std::array<std::uint32_t, 16> sums{};
    for (std::size_t i = 0; i < payload.size(); ++i)
      sums[i % sums.size()] += scale_ * static_cast<std::uint32_t>(payload[i]);
    std::memcpy(out.data(), sums.data(), sizeof(sums));
    return sizeof(sums);
  }

 private:
  std::uint32_t scale_;
  std::string hash_;
};

/// `scale` of the reducer; none: pictures are logged and tracked raw.
inline std::unique_ptr<Session> picture_session(std::optional<std::uint32_t> scale = {},
                                                PictureTracker::Seen* seen = nullptr) {
  Session::Parts parts;
  parts.rig = sensor::parse_rig(kCameraRig, "camera").value();
  parts.trackers.push_back(std::make_unique<PictureTracker>(seen));
  parts.protocols.push_back(std::make_unique<PictureProtocol>());
  if (scale) parts.reducers.push_back({"picture", std::make_unique<PictureReducer>(*scale)});
  return Session::create(std::move(parts)).value();
}

}  // namespace mien::session::test
