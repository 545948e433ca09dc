#include "mien/sink/ifacialmocap.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "mien/core/units.h"
#include "mien/face/ifacialmocap_request.h"
#include "mien/face/livelink_csv.h"

namespace mien::sink {
namespace {

/// "eyeBlinkLeft" is "eyeBlink_L" here; jawLeft, jawRight, mouthLeft and mouthRight keep their names.
std::string short_name(std::string_view name) {
  const bool direction = name.starts_with("jaw") || name == "mouthLeft" || name == "mouthRight";
  if (!direction && name.ends_with("Left")) return std::string(name.substr(0, name.size() - 4)) + "_L";
  if (!direction && name.ends_with("Right")) return std::string(name.substr(0, name.size() - 5)) + "_R";
  return std::string(name);
}

const std::array<std::string, 52>& short_names() {
  static const auto names = [] {
    std::array<std::string, 52> list;
    for (std::size_t i = 0; i < list.size(); ++i) list[i] = short_name(face::arkit52().shapes[i]);
    return list;
  }();
  return names;
}

/// Formats into `out` by way of the stack.
template <class... Value>
void put(Datagrams& out, fmt::format_string<Value...> format, Value&&... values) {
  std::array<char, 128> text;
  const auto result = fmt::format_to_n(text.data(), text.size(), format, std::forward<Value>(values)...);
  out.append(std::string_view(text.data(), std::min<std::size_t>(result.size, text.size())));
}

void put_eye(Datagrams& out, const char* name, const Eigen::Vector2f& yaw_left_pitch_up) {
  put(out, "{}#{:.4f},{:.4f},0|", name, 0.0 - kDegPerRad * static_cast<double>(yaw_left_pitch_up.y()),
      0.0 + kDegPerRad * static_cast<double>(yaw_left_pitch_up.x()));
}

}  // namespace

std::optional<IFacialMocapRequest> parse_ifacialmocap_request(std::span<const std::byte> bytes) {
  constexpr std::size_t kLongest = 128;
  if (bytes.size() > kLongest) return std::nullopt;
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  while (!text.empty() && (text.back() == '\0' || text.back() == '\n' || text.back() == '\r'))
    text.remove_suffix(1);
  const auto cut = [&text](std::string_view front) {
    if (!text.starts_with(front)) return false;
    text.remove_prefix(front.size());
    return true;
  };
  if (!cut(face::kIFacialMocapAsks)) return std::nullopt;
  IFacialMocapRequest request = IFacialMocapRequest::v1;
  if (cut("UDPTCPSTOP_"))
    request = IFacialMocapRequest::tcp_stop;
  else if (cut("UDPTCP_"))
    request = IFacialMocapRequest::tcp;
  if (!cut(face::kIFacialMocapSecret)) return std::nullopt;
  if (request == IFacialMocapRequest::v1 && cut(face::kIFacialMocapAsksV2)) request = IFacialMocapRequest::v2;
  if (!text.empty()) return std::nullopt;
  return request;
}

void encode_ifacialmocap(const ArkitFrame& frame, IFacialMocapVersion version, Datagrams& out) {
  out.begin();
  const char separator = version == IFacialMocapVersion::v1 ? '-' : '&';
  // Some receivers throw the first field away; in version 1 phones have no field to spare either.
  if (version == IFacialMocapVersion::v2) out.append("trackingStatus&1|");
  for (std::size_t i = 0; i < short_names().size(); ++i)
    put(out, "{}{}{}|", short_names()[i], separator, std::lround(100 * frame.weights.values[i]));
  // Yaw to the right, pitch down and roll to the right are turns about -Y, +X and +Z.
  const Vec3 head = face::livelink_from_head(frame.head) * kDegPerRad;
  put(out, "=head#{:.4f},{:.4f},{:.4f},", head.y() + 0.0, 0.0 - head.x(), head.z() + 0.0);
  if (const Vec3f& p = frame.head_position_m; frame.head_position_known)
    put(out, "{:.4f},{:.4f},{:.4f}|", p.x() + 0.0F, p.y() + 0.0F, p.z() + 0.0F);
  else
    out.append("0,0,0|");
  put_eye(out, "rightEye", frame.eyes_rad[1]);
  put_eye(out, "leftEye", frame.eyes_rad[0]);
}

}  // namespace mien::sink
