#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/core/time.h"
#include "mien/headset/etvr_frames.h"
#include "mien/headset/http_answer.h"
#include "mien/headset/jpeg_gate.h"
#include "mien/headset/multipart.h"
#include "mien/sensor/payload_stream.h"
#include "mien/sensor/protocol.h"

namespace mien::headset {

/// Writes the packet of each of a camera's pictures in memory of its own.
class PictureNumbering {
 public:
  explicit PictureNumbering(sensor::DeviceKey camera) : camera_(camera) {}
  void restart() { first_ = true; }
  /// Of the picture that `counts` counted last. Valid until the next call.
  [[nodiscard]] std::span<const std::byte> packet_of(const sensor::StreamCounts& counts,
                                                     std::optional<DeviceTime> time);

 private:
  sensor::DeviceKey camera_;
  bool first_ = true;
  ByteWriter packet_;
};

/// Where a camera's connection is left by pictures that no session would decode (jpeg_gate.h), each counted
/// by what is wrong with it. No allocation in passes().
class StreamGate {
 public:
  [[nodiscard]] bool passes(std::span<const std::byte> jpeg);
  /// `found`: what the stream was found to hold, its whole pictures before the gate.
  [[nodiscard]] sensor::StreamCounts counts(const sensor::StreamCounts& found) const;
  [[nodiscard]] std::vector<sensor::Refusal> refusals() const;

 private:
  std::array<std::uint64_t, kPictureFaults> faults_{};
  std::uint64_t refused_ = 0;
};

/// A camera that answers GET with a multipart stream of pictures (docs/reference/protocol.md, type 15): the
/// response's head, chunks where it has them, and its parts. What no session would decode (jpeg_gate.h) is
/// refused here, and counted by its fault. Errors of read(): those of parse_response_head()
/// and of ChunkedBody::read().
class MjpegStream final : public sensor::PayloadStream {
 public:
  explicit MjpegStream(sensor::DeviceKey camera);
  void restart() override;
  [[nodiscard]] Result<void> read(std::span<const std::byte> bytes, const OnPayload& on_payload) override;
  [[nodiscard]] sensor::StreamCounts counts() const override { return gate_.counts(parts_.counts()); }
  [[nodiscard]] std::vector<sensor::Refusal> refusals() const override { return gate_.refusals(); }

 private:
  /// True: the head is over.
  Result<bool> read_head(std::span<const std::byte>& bytes);

  std::string head_;
  bool in_body_ = false;
  bool chunked_ = false;
  ChunkedBody chunks_;
  MultipartReader parts_;
  StreamGate gate_;
  PictureNumbering numbering_;
};

/// A camera on a serial line (EtvrFrames), with the same gate. Its pictures have no time. read() has no
/// errors.
class EtvrStream final : public sensor::PayloadStream {
 public:
  explicit EtvrStream(sensor::DeviceKey camera) : numbering_(camera) {}
  void restart() override;
  [[nodiscard]] Result<void> read(std::span<const std::byte> bytes, const OnPayload& on_payload) override;
  [[nodiscard]] sensor::StreamCounts counts() const override { return gate_.counts(frames_.counts()); }
  [[nodiscard]] std::vector<sensor::Refusal> refusals() const override { return gate_.refusals(); }

 private:
  EtvrFrames frames_;
  StreamGate gate_;
  PictureNumbering numbering_;
};

}  // namespace mien::headset
