#include "mien/dataset/take_videos.h"

#include <system_error>

namespace mien::dataset {
namespace {

/// A take has at most so many (live::VideoWriter::kMostFiles).
constexpr int kMostVideos = 100;

}  // namespace

std::vector<TakeVideo> videos_beside(const std::filesystem::path& take) {
  std::vector<TakeVideo> videos;
  const std::filesystem::path folder = take.parent_path();
  for (int n = 1; n <= kMostVideos; ++n) {
    const std::string name = take.stem().string() + (n > 1 ? "_" + std::to_string(n) : "");
    std::error_code code;
    if (n > 1 && std::filesystem::exists(folder / (name + ".mien"), code)) continue;
    for (const char* const ending : {".webm", ".mp4"}) {
      const std::filesystem::path file = folder / (name + ending);
      if (!std::filesystem::is_regular_file(file, code)) continue;
      const std::uintmax_t bytes = std::filesystem::file_size(file, code);
      videos.push_back({file.filename().string(), code ? 0 : bytes});
    }
  }
  return videos;
}

double megabytes_of(const std::vector<TakeVideo>& videos) {
  std::uint64_t bytes = 0;
  for (const TakeVideo& video : videos) bytes += video.bytes;
  return static_cast<double>(bytes) / 1e6;
}

}  // namespace mien::dataset
