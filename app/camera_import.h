#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command_line.h"
#include "mien/core/error.h"
#include "mien/face/motion.h"
#include "mien/take/take.h"

namespace mien::app {

/// How recorded pictures of a headset's cameras become a take: the options that `mien import` has for it.
struct CameraImport {
  std::vector<std::string> cameras;   ///< "NAME=FOLDER" or "NAME=FILM".
  double fps = 0;                     ///< Pictures a second, of each camera; 0: not given.
  std::vector<std::string> mirrored;  ///< Names.
  std::vector<std::string> crops;     ///< "NAME=LEFT,TOP,WIDTH,HEIGHT".
  std::string events;                 ///< CSV of prompts; empty: none.

  void add_to(Command command);
};

/// What came of it.
struct ImportedPictures {
  struct Camera {
    std::string name;
    std::size_t pictures = 0;
    std::size_t scaled = 0;  ///< Pictures of another size than those of the take.
    int width = 0, height = 0;
  };
  std::vector<Camera> cameras;
  std::size_t frames = 0;  ///< Of the 60 Hz grid.
  std::size_t truth = 0;   ///< Of these, with truth that counts.
  std::size_t events = 0;
  double seconds = 0;  ///< The longest camera's.
};

/// Writes a take of recorded pictures, whole or not at all: one by one, so that any number fits into memory.
/// `header` has all but the rig; `rig` is its file. `truth`: what the face did, its time 0 at the first
/// picture; null: nobody knows. Errors: bad_usage (options, a
/// camera that the rig does not have), those of the rig's reader, of Footage and of parse_event_list,
/// out_of_range (a picture under 16 x 16, or that no JPEG of a camera holds), cancelled.
[[nodiscard]] Result<ImportedPictures> import_pictures(const CameraImport& options,
                                                       const std::filesystem::path& rig, take::Header header,
                                                       const face::Motion* truth,
                                                       const std::filesystem::path& out, bool replace);

/// What was found and done, for people and for machines.
[[nodiscard]] std::string pictures_text(const ImportedPictures& imported);
[[nodiscard]] nlohmann::json pictures_json(const ImportedPictures& imported);

}  // namespace mien::app
