#include "mien/live/camera_news.h"

#include <fmt/format.h>

#include <utility>

namespace mien::live {

std::optional<Sentence> CameraNews::tell(HostTime now, const CameraStatus& camera) {
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

std::vector<Sentence> LineNews::tell(HostTime now, std::span<const SerialPort::Status> lines) {
  lines_.resize(lines.size());
  std::vector<Sentence> out;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const SerialPort::Status& line = lines[i];
    Line& known = lines_[i];
    const bool changed = line.open != std::exchange(known.open, line.open);
    if (line.camera) {
      if (auto news = known.camera.tell(now, *line.camera)) out.push_back(*std::move(news));
    } else if (changed && line.open) {
      out.push_back({"line_back", line.address + " is back"});
    } else if (changed) {
      out.push_back(
          {"line_lost", line.address + " is " + line.problem + "; it is opened again when it is back"});
    }
  }
  return out;
}

}  // namespace mien::live
