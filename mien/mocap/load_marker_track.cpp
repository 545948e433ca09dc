#include "mien/mocap/load_marker_track.h"

#include <fstream>
#include <span>
#include <string_view>
#include <utility>

#include "mien/core/bytes.h"
#include "mien/core/files.h"
#include "mien/mocap/c3d.h"
#include "mien/mocap/marker_csv.h"
#include "mien/mocap/trc.h"

namespace mien::mocap {
namespace {

/// Two hours of 40 markers at 100 Hz are 900 MB of text.
constexpr std::size_t kMaxBytes = std::size_t{1} << 30U;
/// Enough for comments and the first cell; a C3D's header.
constexpr std::size_t kFirstBytes = 4096;

}  // namespace

bool is_marker_recording(const std::filesystem::path& path) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) return false;
  std::ifstream file(path, std::ios::binary);
  std::string first(kFirstBytes, '\0');
  file.read(first.data(), static_cast<std::streamsize>(first.size()));
  first.resize(static_cast<std::size_t>(file.gcount()));
  return is_trc(first) || is_motive_csv(first) || is_marker_csv(first) ||
         is_c3d(std::as_bytes(std::span(first)));
}

Result<MarkerTrack> load_marker_track(const std::filesystem::path& path, std::vector<std::string>* warnings) {
  MIEN_TRY_ASSIGN(const std::vector<std::byte> bytes, read_file(path, kMaxBytes));
  const std::string_view text = as_text(bytes);
  const std::string name = path.string();
  auto recording = is_trc(text)          ? parse_trc(text, name)
                   : is_motive_csv(text) ? parse_motive_csv(text, name)
                   : is_marker_csv(text) ? parse_marker_csv(text, name)
                   : is_c3d(bytes)
                       ? parse_c3d(bytes, name)
                       : fail(ErrorCode::unsupported, "not a recording of markers", name,
                              "CSV with a time_s column, Motive's CSV, TRC and C3D are understood");
  if (!recording) return std::unexpected(std::move(recording).error());
  recording->track.name = path.stem().string();
  if (warnings != nullptr) *warnings = std::move(recording->warnings);
  return std::move(recording->track);
}

Result<void> write_marker_track(const std::filesystem::path& path, const MarkerTrack& track) {
  if (path.extension() == ".trc") return write_file(path, format_trc(track));
  if (path.extension() == ".csv") return write_file(path, format_marker_csv(track));
  return fail(ErrorCode::bad_usage, "markers are written as .trc or .csv", path.string());
}

}  // namespace mien::mocap
