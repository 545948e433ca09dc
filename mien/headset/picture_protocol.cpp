#include "mien/headset/picture_protocol.h"

#include <algorithm>
#include <utility>

#include "mien/headset/feature_record.h"
#include "mien/headset/picture_statistics.h"

namespace mien::headset {
namespace {

using sensor::Verdict;

/// Cameras of headsets give 30 to 120 pictures a second, and 10 in the dark.
constexpr sensor::EstimatedClockSettings kPictureClock = {.first_period = std::chrono::microseconds(16'667),
                                                          .min_period = std::chrono::milliseconds(4),
                                                          .max_period = std::chrono::milliseconds(120)};

}  // namespace

std::optional<sensor::Sample> PictureProtocol::read(std::span<const std::byte> payload) {
  if (is_feature_record(payload)) {
    const auto record = parse_feature_record(payload);
    if (!record) return std::nullopt;
    return sample_of(record->statistics, record->jpeg_bytes);
  }
  if (!decoder_) {
    auto made = PictureDecoder::create();
    if (!made) return std::nullopt;
    decoder_ = *std::move(made);
  }
  const auto picture = decoder_->decode(payload, kMeasuredSide, kMeasuredSide);
  if (!picture) return std::nullopt;
  return sample_of(statistics_of(*picture), payload.size());
}

PictureProtocol::Camera* PictureProtocol::meet(const sensor::DeviceKey& key, HostTime arrival) {
  const auto known = std::ranges::find(cameras_, key, &Camera::key);
  if (known != cameras_.end()) return &*known;
  Camera* place = nullptr;
  if (cameras_.size() < kMostCameras) {
    place = &cameras_.emplace_back();
  } else {
    const auto silent = std::ranges::min_element(cameras_, {}, &Camera::received);
    if (arrival - silent->received > kGone) place = &*silent;
  }
  if (place == nullptr) return nullptr;
  *place = {.key = key, .received = arrival, .clock = sensor::EstimatedClock(kPictureClock)};
  return place;
}

Verdict PictureProtocol::receive_with_payload(HostTime arrival, sensor::Peer,
                                              std::span<const std::byte> datagram,
                                              std::span<const std::byte> payload, sensor::Inbox& inbox) {
  const auto packet = parse_picture_packet(datagram);
  // Of another version too: what is ignored is logged, and a picture must not be.
  if (!packet) return Verdict::malformed;
  std::optional<sensor::Sample> sample = read(payload);
  if (!sample) return Verdict::malformed;
  Camera* const camera = meet(packet->from, arrival);
  if (camera == nullptr) return Verdict::ignored;
  const bool known = std::exchange(camera->begun, true);
  if (packet->first || !known) {
    camera->tells_time = packet->time.has_value();
    camera->stands_still = 0;
    camera->clock.restart();
  } else if (camera->tells_time) {
    const bool runs_on = packet->time && *packet->time > camera->newest;
    camera->stands_still = runs_on ? 0 : camera->stands_still + 1;
    if (camera->stands_still >= kStandsStill) camera->tells_time = false;
  }
  camera->newest = packet->time.value_or(camera->newest);
  camera->received = arrival;
  if (camera->tells_time && !packet->time) return Verdict::ignored;
  sample->sequence = packet->sequence;
  sample->time_estimated = !camera->tells_time;
  sample->time =
      camera->tells_time ? *packet->time : camera->clock.add(arrival, std::uint64_t{packet->sequence} + 1);
  inbox.readings.push_back({.from = packet->from, .sample = *sample, .payload = payload});
  return Verdict::taken;
}

}  // namespace mien::headset
