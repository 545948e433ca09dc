#include "mien/live/camera_news.h"

#include <fmt/format.h>

namespace mien::live {

std::optional<CameraNews::Sentence> CameraNews::tell(HostTime now, const CameraStatus& camera) {
  if (!camera.open && camera.problem.empty()) return std::nullopt;  // Nothing is known.
  const std::uint64_t losses = camera.lost - losses_;
  if (said_anything_ && losses == 0 && said_ == camera.problem) return std::nullopt;
  std::optional<HostTime>& said = camera.open ? said_open_ : said_lost_;
  if (said && now - *said < kQuiet) return std::nullopt;
  std::string text = camera.address + ": " + (camera.open ? "pictures come" : camera.problem);
  // A loss that is said now, or was said, is no news of its own.
  const bool first_loss = losses == 1 && !camera.open;
  if (losses > 0 && !first_loss)
    text += fmt::format(" (they ended {} time{} since this was said)", losses, losses == 1 ? "" : "s");
  said = now;
  said_ = camera.problem;
  said_anything_ = true;
  losses_ = camera.lost;
  return Sentence{camera.open ? "camera" : "camera_lost", std::move(text)};
}

}  // namespace mien::live
