#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "mien/core/error.h"

namespace mien::media {

/// Reads a film's pictures, in the order in which they are shown, in grey. Only this file is opened, and only
/// as what people record (MP4, QuickTime, Matroska, WebM, AVI, MPEG): a playlist that names others is
/// refused. Not thread-safe.
class VideoReader {
 public:
  /// Pictures larger than `most_width` x `most_height` are made smaller, of one shape. Errors: not_found;
  /// malformed (no film); unsupported (FFmpeg lacks its codec); out_of_range (over 8192 pixels a side).
  [[nodiscard]] static Result<VideoReader> open(const std::filesystem::path& path, int most_width,
                                                int most_height);
  VideoReader(VideoReader&&) noexcept;
  VideoReader& operator=(VideoReader&&) noexcept;
  ~VideoReader();

  [[nodiscard]] int width() const;   ///< Of the pictures that next() gives, pixels.
  [[nodiscard]] int height() const;  ///< The same.
  /// How many pictures there are, as the file says, or by its length and rate; 0: it does not tell.
  [[nodiscard]] std::int64_t about() const;

  /// The next picture, row by row from the top; none at the film's end. Valid until the next call. Errors:
  /// malformed (it does not decode), mismatch (its size changes).
  [[nodiscard]] Result<std::optional<std::span<const std::uint8_t>>> next();

 private:
  struct State;
  explicit VideoReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace mien::media
