#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "mien/core/error.h"

namespace mien::live {

/// What a browser's MediaRecorder wraps its video in.
enum class VideoContainer : std::uint8_t { webm = 1, mp4 = 2 };

/// "webm" or "mp4": the name in logs, and a file's ending.
[[nodiscard]] std::string_view container_name(VideoContainer container);

/// A chunk of video as the page sends it from a browser's camera. Layout, byte by byte:
/// docs/reference/page_protocol.md.
struct VideoMessage {
  VideoContainer container = VideoContainer::webm;
  std::uint32_t sequence = 0;  ///< Number of the chunk, 0 the first: with it a file begins.
  std::uint32_t age_ms = 0;    ///< Since the first frame when the chunk was made, by the browser's clock.
  std::span<const std::byte> data;  ///< 1 to kMaxVideoChunk; lives as long as what was parsed.
};

/// The longest chunk, bytes: 25 times what a second of the page's own has.
inline constexpr std::size_t kMaxVideoChunk = std::size_t{8} << 20U;
inline constexpr std::size_t kVideoHeadBytes = 16;

/// Whether a message is meant to be video: it begins with "MVID".
[[nodiscard]] bool is_video_message(std::span<const std::byte> bytes);
/// Errors: truncated; malformed (magic, reserved bytes, a first chunk that begins as no such container);
/// unsupported (version, container); out_of_range (longer than kMaxVideoChunk). No allocation. Thread-safe.
[[nodiscard]] Result<VideoMessage> parse_video_message(std::span<const std::byte> bytes);
/// Inverse of parse_video_message, to the byte.
[[nodiscard]] std::vector<std::byte> encode_video_message(const VideoMessage& message);

}  // namespace mien::live
