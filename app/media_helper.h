#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <utility>

#include "app/child_program.h"
#include "app/private_folder.h"
#include "mien/core/error.h"
#include "mien/core/wav.h"
#include "mien/performer/speaker.h"
#include "mien/render/image.h"
#include "mien/solve/sound_guess.h"

namespace mien::app {

/// An MP4 that `mien-media` writes while this program draws. The file appears when finish() succeeds, whole
/// or not at all. Gone without finish() it stops the helper, which leaves nothing behind. Not thread-safe.
class FilmWriter {
 public:
  /// Sides even, 16 to 8192 pixels; 1 to 240 frames a second. Errors: not_found (no helper), io.
  [[nodiscard]] static Result<FilmWriter> start(const std::filesystem::path& out, int width, int height,
                                                double rate_hz, const std::optional<Sound>& sound);
  /// Errors: mismatch (another size), and what the helper says when it stops.
  [[nodiscard]] Result<void> add_frame(const render::Image& frame);
  [[nodiscard]] Result<void> finish();

 private:
  FilmWriter(Child child, std::optional<PrivateFolder> folder, int width, int height)
      : folder_(std::move(folder)), child_(std::move(child)), width_(width), height_(height) {}
  std::optional<PrivateFolder> folder_;  // Holds the sound; outlives the child.
  Child child_;
  int width_, height_;
};

/// A film's pictures in grey, which `mien-media` decodes while this program reads; stopped when this goes.
/// Not thread-safe.
class FilmReader {
 public:
  /// Pictures larger than this are made smaller, of one shape. Errors: not_found (no helper), and what the
  /// helper says of the film.
  [[nodiscard]] static Result<FilmReader> start(const std::filesystem::path& film, int most_width,
                                                int most_height);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// How many pictures the film says that it has; 0: it does not tell.
  [[nodiscard]] std::size_t about() const { return about_; }
  /// The next one, row by row from the top: height x width; false at the film's end. Errors: mismatch
  /// (another size of `grey`), and what the helper says when it stops.
  [[nodiscard]] Result<bool> next(std::span<std::uint8_t> grey);

 private:
  explicit FilmReader(Child child) : child_(std::move(child)) {}
  Child child_;
  int width_ = 0, height_ = 0;
  std::size_t about_ = 0;
};

/// A film's sound, or a sound file's, which `mien-media` decodes. Errors: not_found (no helper), and what the
/// helper says of the film.
[[nodiscard]] Result<solve::FilmSound> read_film_sound(const std::filesystem::path& film, int rate_hz);

/// Who reads aloud by `mien-media speak`. Errors of what it returns: not_found (no helper), and what the
/// helper says.
[[nodiscard]] performer::Speaker speaker_by_helper();

}  // namespace mien::app
