#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "mien/headset/picture_decoder.h"
#include "mien/headset/picture_packet.h"
#include "mien/sensor/estimated_clock.h"
#include "mien/sensor/protocol.h"

namespace mien::headset {

/// Host side of cameras: pictures (headset/picture_packet.h), each with its JPEG or what was kept of it
/// (FeatureRecord) as payload. Each becomes one sample of SampleKind::picture (headset/picture_statistics.h),
/// whose payload that is. A packet without a payload, or with one that does not decode, is malformed.
///
/// A sample's time is when the exposure ended: the camera's own, or, of a camera that tells none, an estimate
/// by its pictures' numbers and arrivals. Whether a camera tells times is decided by the first picture of its
/// connection; a picture of that connection which then has none is ignored. One whose times have not run on,
/// or were missing, for kStandsStill pictures in a row tells none any more until its next connection.
class PictureProtocol final : public sensor::Protocol {
 public:
  static constexpr std::string_view kName = "picture";
  /// Cameras that are followed at a time. One that was silent for kGone gives its place to another, whose
  /// pictures are ignored until then.
  static constexpr std::size_t kMostCameras = 16;
  static constexpr Duration kGone = std::chrono::seconds(2);
  static constexpr int kStandsStill = 10;

  [[nodiscard]] std::string_view name() const override { return kName; }
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override {
    return is_picture_packet(datagram);
  }
  sensor::Verdict receive_with_payload(HostTime arrival, sensor::Peer peer,
                                       std::span<const std::byte> datagram,
                                       std::span<const std::byte> payload, sensor::Inbox& inbox) override;

 private:
  struct Camera {
    sensor::DeviceKey key;
    HostTime received;
    bool begun = false;
    bool tells_time = false;
    DeviceTime newest;             // Of those that it told, ...
    int stands_still = 0;          // ... and how many pictures in a row told none that is later.
    sensor::EstimatedClock clock;  // Of one that does not.
  };
  /// What a payload says of its picture, but for its time; none where it is neither.
  std::optional<sensor::Sample> read(std::span<const std::byte> payload);
  /// Null: there is no place for another one.
  Camera* meet(const sensor::DeviceKey& key, HostTime arrival);

  std::vector<Camera> cameras_;
  std::optional<PictureDecoder> decoder_;  // Made for the first picture that was not reduced.
};

}  // namespace mien::headset
