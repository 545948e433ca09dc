#include "mien/phone/ifacialmocap.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "mien/core/bytes.h"
#include "mien/core/excerpt.h"
#include "mien/core/units.h"
#include "mien/face/livelink_csv.h"
#include "mien/face/profile.h"

namespace mien::phone {
namespace {

constexpr std::size_t kLongestName = 40;
constexpr double kMostPercent = 1000, kMostDegrees = 720;
constexpr std::string_view kTracking = "trackingStatus", kHead = "head";

std::unexpected<Error> refuse_frame(ErrorCode code, std::string what) {
  return fail(code, std::move(what), "iFacialMocap frame");
}

bool is_letter(char c) {  // Of a name.
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// The number that is the whole of a text; none for any other, and for one that is not finite.
std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Numbers that commas set apart: as many as there are places, or none.
template <std::size_t N>
std::optional<std::array<double, N>> numbers(std::string_view text) {
  std::array<double, N> values{};
  for (std::size_t i = 0; i < N; ++i) {
    const std::size_t end = i + 1 < N ? text.find(',') : text.size();
    if (end == std::string_view::npos) return std::nullopt;
    const auto value = number(text.substr(0, end));
    if (!value) return std::nullopt;
    values[i] = *value;
    text.remove_prefix(std::min(text.size(), end + 1));
  }
  return values;
}

/// A field that names a weight or a state: its name and what stands behind `&` or the first `-`.
struct Named {
  std::string_view name, value;
};
std::optional<Named> named(std::string_view field) {
  std::size_t at = field.find('&');
  if (at == std::string_view::npos) at = field.find('-');
  if (at == std::string_view::npos || at == 0 || at > kLongestName) return std::nullopt;
  if (!std::ranges::all_of(field.substr(0, at), is_letter)) return std::nullopt;
  return Named{field.substr(0, at), field.substr(at + 1)};
}

/// Head or eyes: `name#numbers`.
Result<void> add_pose(std::string_view name, std::string_view values, ToldFace& face) {
  if (name.starts_with('=')) name.remove_prefix(1);
  if (name != kHead) return {};
  const auto told = numbers<6>(values);
  if (!told) return refuse_frame(ErrorCode::malformed, "its head is not six numbers");
  const auto& [x, y, z, px, py, pz] = *told;
  if (std::max({std::abs(x), std::abs(y), std::abs(z)}) > kMostDegrees ||
      std::max({std::abs(px), std::abs(py), std::abs(pz)}) > static_cast<double>(kMostHead_m))
    return refuse_frame(ErrorCode::out_of_range, "its head is beyond its range");
  // Turns about +X, -Y and +Z are pitch down, yaw to the right and roll to the right.
  ToldHead& head = face.head.emplace();
  head.rotation = wxyz_of(face::head_from_livelink(Vec3(-y, x, z) / kDegPerRad).normalized());
  head.position_known = px != 0 || py != 0 || pz != 0;
  if (head.position_known) head.position_m = Vec3(px, py, pz).cast<float>();
  return {};
}

Result<void> add_field(std::string_view field, IFacialMocapFrame& frame) {
  if (const std::size_t at = field.find('#'); at != std::string_view::npos)
    return add_pose(field.substr(0, at), field.substr(at + 1), frame.face);
  const auto said = named(field);
  if (!said) return {};  // Of a version that tells more.
  const std::size_t shape = face::arkit_index(said->name);
  const bool state = said->name == kTracking;
  if (shape >= face::arkit52().shapes.size() && !state) return {};
  const auto value = number(said->value);
  if (!value || std::abs(*value) > kMostPercent)
    return refuse_frame(ErrorCode::out_of_range, fmt::format("\"{}\" has no percentage", excerpt(field)));
  if (state)
    frame.tracked = *value != 0;
  else
    frame.face.weights[shape] = static_cast<float>(std::clamp(*value / 100, 0.0, 1.0));
  return {};
}

}  // namespace

bool is_ifacialmocap(std::span<const std::byte> bytes) {
  const std::string_view text = as_text(bytes);
  const std::string_view first = text.substr(0, std::min(text.find('|'), text.size()));
  if (first.size() == text.size()) return false;  // No field ends.
  if (first.starts_with("=head#")) return true;
  const auto said = named(first);
  return said && !said->value.empty() && (is_digit(said->value[0]) || said->value[0] == '-');
}

Result<IFacialMocapFrame> parse_ifacialmocap(std::span<const std::byte> bytes) {
  if (bytes.size() > kMostIFacialMocapBytes)
    return refuse_frame(ErrorCode::out_of_range, fmt::format("{} bytes are no frame", bytes.size()));
  IFacialMocapFrame frame;
  frame.face.set = ShapeSet::arkit52;
  std::string_view text = as_text(bytes);
  while (!text.empty() && (text.back() == '\0' || text.back() == '\n' || text.back() == '\r'))
    text.remove_suffix(1);
  bool told = false;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('|'), text.size());
    if (end > 0) {
      MIEN_TRY(add_field(text.substr(0, end), frame));
      told = true;
    }
    text.remove_prefix(std::min(text.size(), end + 1));
  }
  if (!told || (frame.tracked && frame.face.told() == 0 && !frame.face.head))
    return refuse_frame(ErrorCode::malformed, "it tells nothing");
  return frame;
}

using sensor::Verdict;

Verdict IFacialMocapProtocol::receive(HostTime arrival, sensor::Peer peer,
                                      std::span<const std::byte> datagram, sensor::Inbox& inbox) {
  const auto frame = parse_ifacialmocap(datagram);
  if (!frame) return Verdict::malformed;
  auto* const place = phones_.meet(peer, arrival);
  if (place == nullptr) return Verdict::ignored;
  Phone& phone = place->state;
  const DeviceTime time = phone.clock.add(arrival, ++phone.frames);
  if (!frame->tracked) {
    inbox.alive = inbox.no_face = {place->device, 0};
    return Verdict::taken;
  }
  add_readings(frame->face, place->device, {static_cast<std::uint32_t>(phone.frames), time, true}, inbox);
  return Verdict::taken;
}

}  // namespace mien::phone
