#include "mien/face/load_motion.h"

#include <algorithm>
#include <utility>

#include "mien/core/files.h"

namespace mien::face {

Result<LiveLinkMotion> load_livelink(const std::filesystem::path& path) {
  // Four hours at 60 frames a second are 700 MB.
  constexpr std::size_t kMaxMotionBytes = std::size_t{1} << 30U;
  MIEN_TRY_ASSIGN(const std::string text, read_text(path, kMaxMotionBytes));
  MIEN_TRY_ASSIGN(const LiveLinkCsv csv, parse_livelink_csv(text, path.string()));
  LiveLinkMotion loaded = motion_from_livelink(csv, path.stem().string());
  if (std::ranges::none_of(loaded.motion.frames, &MotionFrame::has_face))
    return fail(ErrorCode::not_found, "the face is lost in every row", path.string());
  return loaded;
}

Result<Motion> load_motion(const std::filesystem::path& path, std::vector<std::string>* warnings) {
  MIEN_TRY_ASSIGN(LiveLinkMotion loaded, load_livelink(path));
  if (warnings != nullptr) *warnings = std::move(loaded.warnings);
  return std::move(loaded.motion);
}

}  // namespace mien::face
