#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/mapped_file.h"
#include "mien/face/profile.h"

namespace mien::synthetic {

/// What is true of one moment of a film.
struct FilmTruth {
  std::array<float, face::kShapeCount> weights{};
  float tongue_out = 0;
  std::array<float, 4>
      gaze_rad{};  ///< Left eye's yaw to the performer's left and pitch upwards, right eye's.
  std::array<float, 2> openness{};  ///< Gap between the lids, left and right: 1 as in the neutral, 0 closed.
  std::array<float, 2> pupil_mm{};  ///< Diameters.
  std::array<float, 2> visible{1, 1};  ///< headset::half_of_face: 0 where a failure hides it.
  float neutral = 0;                   ///< 1 while the face rests for the neutral.
  float time_s = 0;                    ///< Since the headset was put on: 0 in each donning's first frame.
};
static_assert(sizeof(FilmTruth) == 66 * sizeof(float));

/// A wearer's film: what the network sees of every camera, and the truth, frame by frame, in a file that is
/// mapped, since films of hundreds of wearers are larger than memory.
class HeadsetFilm {
 public:
  /// Errors: io, malformed (no film, or one that was cut off).
  [[nodiscard]] static Result<HeadsetFilm> open(const std::filesystem::path& path);

  [[nodiscard]] std::size_t frames() const { return frames_; }
  [[nodiscard]] std::size_t views() const { return views_; }
  /// Pixels of a view either way.
  [[nodiscard]] std::size_t side() const { return side_; }
  /// Of what it was rendered from: equal hashes are equal films.
  [[nodiscard]] std::string_view hash() const { return hash_; }

  /// side x side, grey, row by row.
  [[nodiscard]] std::span<const std::uint8_t> view(std::size_t frame, std::size_t view) const;
  [[nodiscard]] FilmTruth truth(std::size_t frame) const;

  /// From when the headset is put on until it is put on anew: frames [begin, end), at rest before rest_end.
  struct Donning {
    std::size_t begin = 0, rest_end = 0, end = 0;
  };
  [[nodiscard]] std::vector<Donning> donnings() const;

 private:
  explicit HeadsetFilm(MappedFile file) : file_(std::move(file)) {}
  [[nodiscard]] std::span<const std::byte> frame_bytes(std::size_t frame) const;

  MappedFile file_;
  std::size_t frames_ = 0, views_ = 0, side_ = 0;
  std::string hash_;
};

/// One frame of a film that is being made.
struct FilmFrame {
  FilmTruth truth;
  std::vector<std::vector<std::uint8_t>> views;
};
/// Writes a film, whole or not at all. `hash`: 64 digits. Errors: io; mismatch (views of another number or
/// size).
[[nodiscard]] Result<void> write_film(const std::filesystem::path& path, std::string_view hash,
                                      std::size_t views, std::size_t side, std::span<const FilmFrame> frames);

}  // namespace mien::synthetic
