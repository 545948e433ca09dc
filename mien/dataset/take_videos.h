#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace mien::dataset {

/// A video of the performer's face that was recorded beside a take.
struct TakeVideo {
  std::string file;  ///< Its name, in the take's folder.
  std::uint64_t bytes = 0;
};

/// The videos beside a take, in the order in which they were begun: of NAME.mien NAME.webm or NAME.mp4, then
/// NAME_2 and so on, but for those of a take of such a name.
[[nodiscard]] std::vector<TakeVideo> videos_beside(const std::filesystem::path& take);

/// What they have together, MB.
[[nodiscard]] double megabytes_of(const std::vector<TakeVideo>& videos);

}  // namespace mien::dataset
