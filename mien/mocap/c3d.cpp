#include "mien/mocap/c3d.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/core/excerpt.h"

namespace mien::mocap {
namespace {

constexpr std::size_t kBlockBytes = 512;
constexpr std::byte kKey{0x50};
constexpr std::uint8_t kIntel = 84;
constexpr std::uint8_t kDec = 85;
constexpr std::uint8_t kMips = 86;
/// Most parameters of a plausible file.
constexpr std::size_t kMaxParameters = 4096;
constexpr double kMaxRateHz = 100'000;
/// Frame count in 16 bits when there are more frames.
constexpr double kManyFrames = 65535;

/// One parameter, as stored in the file.
struct Parameter {
  std::int8_t group = 0;
  std::string_view name;
  std::int8_t type = 0;  // -1 letters, 1 bytes, 2 integers of 16 bits, 4 floats.
  std::vector<std::size_t> sizes;
  std::span<const std::byte> data;
};

struct Parameters {
  std::vector<Parameter> all;
  std::optional<std::int8_t> point;  // The group POINT.

  [[nodiscard]] const Parameter* of_points(std::string_view name) const {
    const auto found = std::ranges::find_if(
        all, [&](const Parameter& p) { return point && p.group == *point && p.name == name; });
    return found == all.end() ? nullptr : &*found;
  }
};

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.remove_suffix(1);
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  return text;
}

/// The records of the parameter section: a list linked by offsets.
Result<Parameters> read_parameters(std::span<const std::byte> section, const std::string& name) {
  Parameters parameters;
  std::size_t at = 4;
  for (std::size_t records = 0; at < section.size(); ++records) {
    if (records >= kMaxParameters) return fail(ErrorCode::out_of_range, "too many parameters", name);
    ByteReader reader(section.subspan(at));
    const auto length = static_cast<std::size_t>(std::abs(int{reader.little<std::int8_t>()}));
    const auto id = reader.little<std::int8_t>();
    if (length == 0) break;
    const std::string_view label = as_text(reader.take(length));
    const std::size_t next_at = at + 2 + length;
    const auto next = reader.little<std::uint16_t>();
    if (!reader.ok()) return fail(ErrorCode::truncated, "its parameters are cut short", name);
    if (id < 0) {
      if (label == "POINT") parameters.point = static_cast<std::int8_t>(-id);
    } else {
      Parameter parameter{.group = id, .name = label};
      parameter.type = reader.little<std::int8_t>();
      const auto dimensions = reader.little<std::uint8_t>();
      if (dimensions > 7)
        return fail(ErrorCode::malformed, "a parameter of more than seven dimensions", name);
      // No overflow: each factor is checked against the bytes left.
      std::size_t size = static_cast<std::size_t>(std::abs(int{parameter.type}));
      for (std::uint8_t d = 0; d < dimensions; ++d) {
        parameter.sizes.push_back(reader.little<std::uint8_t>());
        size *= parameter.sizes.back();
        if (size > section.size()) return fail(ErrorCode::truncated, "a parameter is cut short", name);
      }
      parameter.data = reader.take(size);
      if (!reader.ok()) return fail(ErrorCode::truncated, "a parameter is cut short", name);
      parameters.all.push_back(std::move(parameter));
    }
    if (next == 0) break;
    if (next < 2) return fail(ErrorCode::malformed, "its parameters do not follow each other", name);
    at = next_at + next;
  }
  if (!parameters.point) return fail(ErrorCode::malformed, "it has no group POINT", name);
  return parameters;
}

/// First number of a parameter; integers as unsigned, since counts beyond 32767 are stored so.
Result<double> number_of(const Parameters& parameters, std::string_view what, const std::string& name) {
  const Parameter* parameter = parameters.of_points(what);
  if (parameter != nullptr && !parameter->data.empty()) {
    ByteReader reader(parameter->data);
    if (parameter->type == 2) return static_cast<double>(reader.little<std::uint16_t>());
    if (parameter->type == 4) {
      const auto value = static_cast<double>(reader.little<float>());
      if (std::isfinite(value)) return value;
    }
  }
  return fail(ErrorCode::malformed, fmt::format("POINT:{} is no number, or is not there", what), name);
}

/// Names of the points: LABELS, LABELS2, ..., each a table of characters.
std::vector<std::string> labels_of(const Parameters& parameters, std::size_t points) {
  std::vector<std::string> labels;
  for (std::size_t list = 1; labels.size() < points; ++list) {
    const Parameter* parameter =
        parameters.of_points(list == 1 ? std::string("LABELS") : fmt::format("LABELS{}", list));
    if (parameter == nullptr || parameter->type != -1 || parameter->sizes.empty()) break;
    const std::size_t width = parameter->sizes.front();
    if (width == 0) break;
    for (std::size_t i = 0; i + width <= parameter->data.size() && labels.size() < points; i += width)
      labels.emplace_back(trimmed(as_text(parameter->data.subspan(i, width))));
  }
  labels.resize(points);
  std::set<std::string, std::less<>> known;
  for (std::size_t i = 0; i < points; ++i) {
    const bool usable = std::ranges::none_of(
        labels[i], [](unsigned char c) { return c < 0x20 || c == 0x7F || c == ',' || c == '"'; });
    if (labels[i].empty() || !usable || known.contains(labels[i])) labels[i] = fmt::format("*{}", i + 1);
    known.insert(labels[i]);
  }
  return labels;
}

/// One point: kLostMarker where it was not seen. Positions in the file's unit.
template <class T>
Vec3f point_from(ByteReader& reader, double scale) {
  Vec3 position;
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    position[axis] = scale * static_cast<double>(reader.little<T>());
  const auto residual = reader.little<T>();
  return residual >= 0 && position.allFinite() ? Vec3f(position.cast<float>()) : kLostMarker;
}

/// Number of all-zero frames at the end, within the padding of the last block.
std::size_t padding_frames(std::span<const std::byte> data, std::size_t frame_bytes, std::size_t frames) {
  std::size_t count = 0;
  while (count < frames && (count + 1) * frame_bytes < kBlockBytes &&
         std::ranges::all_of(data.subspan((frames - count - 1) * frame_bytes, frame_bytes),
                             [](std::byte b) { return b == std::byte{0}; }))
    ++count;
  return count;
}

}  // namespace

bool is_c3d(std::span<const std::byte> bytes) {
  return bytes.size() >= kBlockBytes && bytes[1] == kKey && bytes[0] != std::byte{0};
}

Result<MarkerRecording> parse_c3d(std::span<const std::byte> bytes, const std::string& name) {
  if (!is_c3d(bytes)) return fail(ErrorCode::malformed, "not a C3D file", name);
  const std::size_t section_at = (std::to_integer<std::size_t>(bytes[0]) - 1) * kBlockBytes;
  if (section_at == 0 || section_at + 4 > bytes.size())
    return fail(ErrorCode::truncated, "its parameters are not there", name);
  const auto processor = std::to_integer<std::uint8_t>(bytes[section_at + 3]);
  if (processor == kDec || processor == kMips)
    return fail(ErrorCode::unsupported,
                fmt::format("its numbers are in the order of {} machines", processor == kDec ? "DEC" : "SGI"),
                name, "save it in the PC's (Intel's) order");
  if (processor != kIntel) return fail(ErrorCode::malformed, "it names no processor that there is", name);
  MIEN_TRY_ASSIGN(const Parameters parameters, read_parameters(bytes.subspan(section_at), name));

  MIEN_TRY_ASSIGN(const double used, number_of(parameters, "USED", name));
  MIEN_TRY_ASSIGN(const double scale, number_of(parameters, "SCALE", name));
  MIEN_TRY_ASSIGN(const double rate_hz, number_of(parameters, "RATE", name));
  MIEN_TRY_ASSIGN(const double data_block, number_of(parameters, "DATA_START", name));
  MIEN_TRY_ASSIGN(const double promised, number_of(parameters, "FRAMES", name));
  if (!(rate_hz > 0 && rate_hz <= kMaxRateHz))
    return fail(ErrorCode::out_of_range, "no rate of a camera", name);
  if (!(used >= 1)) return fail(ErrorCode::malformed, "there is no point in it", name);
  if (used > kMaxTrackMarkers)
    return fail(ErrorCode::out_of_range, fmt::format("more than {} points", kMaxTrackMarkers), name);
  if (scale == 0) return fail(ErrorCode::malformed, "POINT:SCALE is 0", name);
  const Parameter* units = parameters.of_points("UNITS");
  if (units == nullptr || units->type != -1) return fail(ErrorCode::malformed, "it says no unit", name);
  MIEN_TRY_ASSIGN(const double metres, unit_m(trimmed(as_text(units->data)), name));

  // A negative scale marks points as floats, already scaled.
  const bool floats = scale < 0;
  const auto points = static_cast<std::size_t>(used);
  const std::size_t number_bytes = floats ? 4 : 2;
  const std::size_t analogue = ByteReader(bytes.subspan(4)).little<std::uint16_t>();
  const std::size_t frame_bytes = (4 * points + analogue) * number_bytes;
  if (!(data_block >= 2) || (data_block - 1) * kBlockBytes > static_cast<double>(bytes.size()))
    return fail(ErrorCode::truncated, "its points are not there", name);
  const std::span<const std::byte> data =
      bytes.subspan((static_cast<std::size_t>(data_block) - 1) * kBlockBytes);
  const std::size_t there = data.size() / frame_bytes;
  // A count of 65535 also means more frames: then all frames in the file, less the padding of the last block.
  const std::size_t frames =
      promised == kManyFrames
          ? there - padding_frames(data, frame_bytes, there)
          : static_cast<std::size_t>(std::clamp(promised, 0.0, static_cast<double>(bytes.size())));
  if (frames == 0) return fail(ErrorCode::truncated, "there is no frame in it", name);
  if (frames > there)
    return fail(ErrorCode::truncated, fmt::format("{} frames, not {}", there, promised), name);

  if (static_cast<double>(frames) / rate_hz > kMaxTrackTimeS)
    return fail(ErrorCode::out_of_range, "its rate would make it longer than thirty years", name);

  MarkerRecording recording;
  MarkerTrack& track = recording.track;
  track.markers = labels_of(parameters, points);
  track.time_s.reserve(frames);
  track.position_m.reserve(frames * points);
  for (std::size_t i = 0; i < frames; ++i) {
    track.time_s.push_back(static_cast<double>(i) / rate_hz);
    ByteReader reader(data.subspan(i * frame_bytes, frame_bytes));
    for (std::size_t p = 0; p < points; ++p) {
      Vec3f position = floats ? point_from<float>(reader, 1) : point_from<std::int16_t>(reader, scale);
      position *= static_cast<float>(metres);
      if (is_seen(position) && static_cast<double>(position.cwiseAbs().maxCoeff()) > kMaxTrackPositionM)
        return fail(ErrorCode::out_of_range,
                    fmt::format("farther than {} m from the origin", kMaxTrackPositionM),
                    fmt::format("{}, frame {}, marker {}", name, i + 1, excerpt(track.markers[p])),
                    "see whether the file names the right unit");
      track.position_m.push_back(position);
    }
  }
  MIEN_TRY(check_markers(track.markers, name));
  return recording;
}

}  // namespace mien::mocap
