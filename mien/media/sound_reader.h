#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "mien/core/error.h"
#include "mien/face/livelink_csv.h"

namespace mien::media {

/// When a film began, as its time code track says.
struct FilmStart {
  face::Timecode timecode;  ///< Its frames are whole.
  double rate_hz = 0;       ///< By which it counts them.
};

/// Reads a film's sound, or a sound file, as one channel at one rate, from the film's time 0 on, at which its
/// first picture is shown: where its sound begins later, or has gaps, is silence. Only this file is opened,
/// and only as what people record (as VideoReader's; M4A, WAV). Not thread-safe.
class SoundReader {
 public:
  /// A longer one is refused: 4 hours.
  static constexpr double kLongestS = 4 * 3600;
  static constexpr int kMostChannels = 64;

  /// `rate_hz`: 1,000 to 192,000. Errors: not_found (no such file, no sound in it); malformed (no film);
  /// unsupported (FFmpeg lacks its codec); bad_usage (another rate).
  [[nodiscard]] static Result<SoundReader> open(const std::filesystem::path& path, int rate_hz);
  SoundReader(SoundReader&&) noexcept;
  SoundReader& operator=(SoundReader&&) noexcept;
  ~SoundReader();

  /// None where it does not tell, or what it tells is no time code.
  [[nodiscard]] const std::optional<FilmStart>& start() const;

  /// The next samples, -1 to 1; none at the end. Valid until the next call. Errors: malformed (it does not
  /// decode), mismatch (its rate changes), out_of_range (longer than kLongestS, other channels or rates).
  [[nodiscard]] Result<std::optional<std::span<const float>>> next();

 private:
  struct State;
  explicit SoundReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace mien::media
