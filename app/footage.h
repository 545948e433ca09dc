#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/headset/picture_file.h"

namespace mien::app {

/// What one camera recorded: a folder of pictures, or a film. Not thread-safe.
class Footage {
 public:
  struct Shot {
    headset::PictureCopy picture;
    std::vector<std::byte> jpeg;  ///< The same as it was recorded; empty where that is no JPEG.
    std::string where;            ///< For messages.
  };

  /// So many pictures of one camera at most: over three hours at 40 a second.
  static constexpr std::size_t kMostPictures = 500'000;

  /// Pictures of a folder are its .jpg, .jpeg, .pgm and .ppm files in the order of their names, numbers in
  /// these by value. Anything else is a film, which `mien-media` decodes, made smaller where it is larger
  /// than a camera's picture may be. Errors: not_found (nothing there, a folder without pictures, no helper),
  /// out_of_range (kMostPictures), and what the helper says of the film.
  [[nodiscard]] static Result<std::unique_ptr<Footage>> open(const std::filesystem::path& path);
  virtual ~Footage() = default;

  /// The next picture; none at the end. Errors: those of parse_picture and the helper.
  [[nodiscard]] virtual Result<std::optional<Shot>> next() = 0;
  /// How many pictures there are; 0: that is not known.
  [[nodiscard]] virtual std::size_t about() const = 0;
};

}  // namespace mien::app
