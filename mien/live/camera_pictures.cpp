#include "mien/live/camera_pictures.h"

#include <fmt/format.h>

#include <utility>

#include "mien/sensor/payload.h"

namespace mien::live {

CameraPictures::CameraPictures(std::string address, std::string sensor,
                               std::unique_ptr<sensor::PayloadStream> stream,
                               sensor::PayloadStream::OnPayload on_payload, Clock clock)
    : stream_(std::move(stream)), clock_(std::move(clock)) {
  status_.address = std::move(address);
  status_.sensor = std::move(sensor);
  on_payload_ = [this, hand_on = std::move(on_payload)](std::span<const std::byte> datagram,
                                                        std::span<const std::byte> payload) {
    const HostTime now = clock_();
    deadline_ = now + kPatience;
    if (!status_.open) {
      status_.open = true;
      status_.problem.clear();
      open_since_ = now;
    }
    if (pictures_.spend(now, kMaxPicturesPerSecond))
      hand_on(datagram, payload);
    else
      ++status_.too_fast;
  };
}

void CameraPictures::begin() {
  stream_->restart();
  at_begin_ = stream_->counts();
  deadline_ = clock_() + kPatience;
}

Result<void> CameraPictures::read(std::span<const std::byte> bytes) {
  status_.bytes += bytes.size();
  return stream_->read(bytes, on_payload_);
}

bool CameraPictures::may_read_on(std::size_t read_bytes) {
  if (bytes_.spend(clock_(), kMaxBytesPerSecond, static_cast<double>(read_bytes))) return true;
  ++status_.held_back;
  return false;
}

void CameraPictures::end(std::string problem) {
  if (status_.open) ++status_.lost;
  status_.open = false;
  status_.problem = std::move(problem);
}

std::string CameraPictures::no_picture() const {
  const std::string text = "no whole picture for two seconds; ";
  const sensor::StreamCounts counts = stream_->counts();
  if (counts.overlong > at_begin_.overlong)
    return text +
           fmt::format("its pictures are over {} KiB, let it make smaller ones", sensor::kMaxPayload >> 10U);
  if (counts.refused > at_begin_.refused)
    return text +
           fmt::format("its pictures are refused ({}), let it send plain JPEGs", stream_->refusals()[0].why);
  return text + "look at its power and its radio or cable, and whether another program has its stream";
}

CameraStatus CameraPictures::status() const {
  CameraStatus status = status_;
  status.pictures = stream_->counts();
  status.refusals = stream_->refusals();
  return status;
}

}  // namespace mien::live
