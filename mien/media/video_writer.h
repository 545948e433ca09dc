#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "mien/core/error.h"
#include "mien/core/wav.h"

namespace mien::media {

struct VideoOptions {
  int width = 0;               ///< Pixels, even, 16 to 8192.
  int height = 0;              ///< The same.
  double rate_hz = 30;         ///< Frames a second, 1 to 240.
  int quality = 20;            ///< H.264's constant rate factor, 0 to 51; lower is better and larger.
  std::optional<Sound> sound;  ///< Played from the first frame; cut where the pictures end.
};

/// Writes an MP4: H.264 where this machine's FFmpeg has x264, else MPEG-4 part 2; sound as AAC. The file
/// appears under its name when finish() succeeds, whole or not at all. The same frames give the same bytes on
/// the same build of FFmpeg. Not thread-safe.
class VideoWriter {
 public:
  /// Errors: bad_usage (a size or rate out of range), unsupported (FFmpeg lacks a codec), io.
  [[nodiscard]] static Result<VideoWriter> create(const std::filesystem::path& path, VideoOptions options);
  VideoWriter(VideoWriter&&) noexcept;
  VideoWriter& operator=(VideoWriter&&) noexcept;
  ~VideoWriter();  ///< Without finish() leaves nothing behind.

  /// The next frame. Shape: height x width x 3, sRGB. Errors: mismatch (another size), io.
  [[nodiscard]] Result<void> add_frame(std::span<const std::uint8_t> rgb);
  /// Ends the file and gives it its name. Errors: bad_usage (no frames), io.
  [[nodiscard]] Result<void> finish();

 private:
  struct State;
  explicit VideoWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace mien::media
