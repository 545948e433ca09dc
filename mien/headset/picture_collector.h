#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "mien/headset/jpeg_walker.h"
#include "mien/sensor/payload.h"
#include "mien/sensor/payload_stream.h"

namespace mien::headset {

/// Gathers one JPEG after the other out of a stream, byte by byte, in memory of its own: sensor::kMaxPayload,
/// taken once. What is longer is followed to its end and not kept. No allocation after construction.
class PictureCollector {
 public:
  /// A picture begins, whose first bytes (FF D8 ...) were read already; it has exactly so many bytes where
  /// its stream says so. One that was open is broken.
  void begin(std::span<const std::byte> first, std::optional<std::size_t> length = {});
  /// The next byte of the open picture. True: it was the last, and picture() is whole. False and not open
  /// any more: it is broken or too long.
  bool add(std::byte byte);
  /// Takes the next byte from the front of `bytes` which may begin or end something, and gives the last
  /// eight, the newest lowest; what cannot end the open picture is added to it before. None: all was taken.
  std::optional<std::uint64_t> next(std::span<const std::byte>& bytes);
  /// Another stream begins. What was open is broken.
  void restart();
  [[nodiscard]] bool is_open() const { return open_; }
  /// What there is, and is kept, of the newest picture. Valid until the next is begun or one is added to.
  [[nodiscard]] std::span<const std::byte> picture() const {
    return {bytes_->data(), std::min(size_, bytes_->size())};
  }
  [[nodiscard]] const sensor::StreamCounts& counts() const { return counts_; }

 private:
  /// What was open is broken, or too long.
  void end();
  /// Adds as many of the next bytes at once as cannot end the picture, and gives their number.
  std::size_t add_run(std::span<const std::byte> next);

  using Bytes = std::array<std::byte, sensor::kMaxPayload>;
  std::unique_ptr<Bytes> bytes_ = std::make_unique<Bytes>();
  std::size_t size_ = 0;  // Of what was added, more than is kept where it is too long.
  bool open_ = false;
  std::uint64_t newest_ = 0;  // The last bytes that next() took.
  std::optional<std::size_t> length_;
  JpegWalker walker_;
  sensor::StreamCounts counts_;
};

}  // namespace mien::headset
