#include "mien/live/line_news.h"

#include <utility>

namespace mien::live {

std::vector<CameraNews::Sentence> LineNews::tell(HostTime now, std::span<const SerialPort::Status> lines) {
  lines_.resize(lines.size());
  std::vector<CameraNews::Sentence> out;
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
