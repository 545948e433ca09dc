#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "mien/core/error.h"
#include "mien/core/wav.h"
#include "mien/performer/speaker.h"
#include "mien/render/image.h"
#include "mien/solve/sound_guess.h"

namespace mien::app {

/// An MP4 that `mien-media` writes while this program draws. The file appears when finish() succeeds, whole
/// or not at all. Not thread-safe.
class FilmWriter {
 public:
  /// Sides even, 16 to 8192 pixels; 1 to 240 frames a second. Errors: not_found (no helper), io.
  [[nodiscard]] static Result<FilmWriter> start(const std::filesystem::path& out, int width, int height,
                                                double rate_hz, const std::optional<Sound>& sound);
  FilmWriter(FilmWriter&&) noexcept;
  FilmWriter& operator=(FilmWriter&&) noexcept;
  ~FilmWriter();  ///< Without finish() stops the helper, which leaves nothing behind.

  /// Errors: mismatch (another size), and what the helper says when it stops.
  [[nodiscard]] Result<void> add_frame(const render::Image& frame);
  [[nodiscard]] Result<void> finish();

 private:
  struct State;
  explicit FilmWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// A film's pictures in grey, which `mien-media` decodes while this program reads. Not thread-safe.
class FilmReader {
 public:
  /// Pictures larger than this are made smaller, of one shape. Errors: not_found (no helper), and what the
  /// helper says of the film.
  [[nodiscard]] static Result<FilmReader> start(const std::filesystem::path& film, int most_width,
                                                int most_height);
  FilmReader(FilmReader&&) noexcept;
  FilmReader& operator=(FilmReader&&) noexcept;
  ~FilmReader();  ///< Stops the helper.

  [[nodiscard]] int width() const;
  [[nodiscard]] int height() const;
  /// How many pictures the film says that it has; 0: it does not tell.
  [[nodiscard]] std::size_t about() const;
  /// The next one, row by row from the top: height x width; false at the film's end. Errors: mismatch
  /// (another size of `grey`), and what the helper says when it stops.
  [[nodiscard]] Result<bool> next(std::span<std::uint8_t> grey);

 private:
  struct State;
  explicit FilmReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// A film's sound, or a sound file's, which `mien-media` decodes. Errors: not_found (no helper), and what the
/// helper says of the film.
[[nodiscard]] Result<solve::FilmSound> read_film_sound(const std::filesystem::path& film, int rate_hz);

/// Who reads aloud by `mien-media speak`. Errors of what it returns: not_found (no helper), and what the
/// helper says.
[[nodiscard]] performer::Speaker speaker_by_helper();

}  // namespace mien::app
