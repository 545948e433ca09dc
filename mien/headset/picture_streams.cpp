#include "mien/headset/picture_streams.h"

#include <algorithm>
#include <tuple>

#include "mien/headset/http_answer.h"
#include "mien/headset/picture_packet.h"

namespace mien::headset {

std::span<const std::byte> PictureNumbering::packet_of(const sensor::StreamCounts& counts,
                                                       std::optional<DeviceTime> time) {
  packet_.clear();
  const auto written = write_picture_packet({.from = camera_,
                                             .sequence = static_cast<std::uint32_t>(counts.all() - 1),
                                             .time = time,
                                             .first = first_},
                                            packet_);
  static_cast<void>(written);  // MultipartReader gives no time that is out of range.
  first_ = false;
  return packet_.bytes();
}

bool StreamGate::passes(std::span<const std::byte> jpeg) {
  const auto header = check_jpeg(jpeg);
  if (header) return true;
  ++faults_[static_cast<std::size_t>(header.error())];
  ++refused_;
  return false;
}

sensor::StreamCounts StreamGate::counts(const sensor::StreamCounts& found) const {
  sensor::StreamCounts counts = found;
  counts.whole -= refused_;
  counts.refused = refused_;
  return counts;
}

std::vector<sensor::Refusal> StreamGate::refusals() const {
  std::vector<sensor::Refusal> all;
  for (std::size_t i = 0; i < faults_.size(); ++i)
    if (faults_[i] > 0) all.push_back({name_of(static_cast<PictureFault>(i)), faults_[i]});
  // The most frequent first, those of one count by their names.
  std::ranges::sort(all, [](const sensor::Refusal& a, const sensor::Refusal& b) {
    return std::tie(b.count, a.why) < std::tie(a.count, b.why);
  });
  return all;
}

MjpegStream::MjpegStream(sensor::DeviceKey camera) : numbering_(camera) {
  head_.reserve(kMaxHeadBytes + 1);
}

void MjpegStream::restart() {
  head_.clear();
  in_body_ = false;
  chunked_ = false;
  chunks_.restart();
  parts_.restart();
  numbering_.restart();
}

Result<bool> MjpegStream::read_head(std::span<const std::byte>& bytes) {
  while (!bytes.empty()) {
    head_ += static_cast<char>(bytes.front());
    bytes = bytes.subspan(1);
    const bool ends = head_.ends_with("\n\r\n") || head_.ends_with("\n\n");
    if (!ends && head_.size() <= kMaxHeadBytes) continue;
    if (ends) head_.resize(head_.size() - (head_.ends_with("\r\n") ? 2 : 1));
    MIEN_TRY_ASSIGN(const ResponseHead head, parse_response_head(head_));
    chunked_ = head.chunked;
    return true;
  }
  return false;
}

Result<void> MjpegStream::read(std::span<const std::byte> bytes, const OnPayload& on_payload) {
  if (!in_body_) {
    MIEN_TRY_ASSIGN(in_body_, read_head(bytes));
  }
  while (!bytes.empty()) {
    std::span<const std::byte> content = bytes;
    if (chunked_) {
      MIEN_TRY_ASSIGN(content, chunks_.read(bytes));
    } else {
      bytes = {};
    }
    while (const auto picture = parts_.read(content))
      if (gate_.passes(picture->jpeg))
        on_payload(numbering_.packet_of(parts_.counts(), picture->time), picture->jpeg);
  }
  return {};
}

void EtvrStream::restart() {
  frames_.restart();
  numbering_.restart();
}

Result<void> EtvrStream::read(std::span<const std::byte> bytes, const OnPayload& on_payload) {
  while (const auto picture = frames_.read(bytes))
    if (gate_.passes(*picture)) on_payload(numbering_.packet_of(frames_.counts(), std::nullopt), *picture);
  return {};
}

}  // namespace mien::headset
