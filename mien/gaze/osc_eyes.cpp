#include "mien/gaze/osc_eyes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "mien/core/excerpt.h"
#include "mien/core/units.h"
#include "mien/gaze/eyes.h"
#include "mien/gaze/osc.h"

namespace mien::gaze {
namespace {

const char* const kOscEyes = "OSC of eyes";
constexpr std::string_view kAvatar = "/avatar/parameters/";
constexpr std::string_view kTracking = "/tracking/eye/";

enum class Meaning : std::uint8_t {
  x,          // To the performer's right, tangent.
  y,          // Upwards, tangent.
  openness,   // 0 to 1.
  closed,     // 1 - openness.
  lid_v2,     // 0.75 openness + 0.25 wide: 0.75 is open as at rest.
  lid_v1,     // 0.8 is open as at rest, above is wide, below 0 squeezed.
  pupil,      // Diameter, cm.
  pitch_yaw,  // Degrees, down and right; for each eye, or one for both.
  vector,     // Right, up, ahead; likewise.
};

/// Addresses that tell the same of one eye, of the other, and of both.
struct Addresses {
  Dialect dialect;
  Meaning meaning;
  std::array<std::string_view, 3> names;  // Left, right, both; empty: there is none.
  std::size_t numbers = 1;
};

constexpr std::array kAddresses = {
    // VRChat's documentation, "OSC Eye Tracking" (docs.vrchat.com/docs/osc-eye-tracking). EyeTrackVR sends
    // LeftRightVec and EyesClosedAmount (EyeTrackVR/EyeTrackVR, EyeTrackApp/osc/VRChatOSCSender.py).
    Addresses{Dialect::native, Meaning::pitch_yaw, {"", "", "CenterPitchYaw"}, 2},
    Addresses{Dialect::native, Meaning::pitch_yaw, {"", "", "CenterPitchYawDist"}, 3},
    Addresses{Dialect::native, Meaning::vector, {"", "", "CenterVec"}, 3},
    Addresses{Dialect::native, Meaning::vector, {"", "", "CenterVecFull"}, 3},
    Addresses{Dialect::native, Meaning::pitch_yaw, {"", "", "LeftRightPitchYaw"}, 4},
    Addresses{Dialect::native, Meaning::vector, {"", "", "LeftRightVec"}, 6},
    Addresses{Dialect::native, Meaning::closed, {"", "", "EyesClosedAmount"}},
    // benaclejames/VRCFaceTracking, VRCFaceTracking.Core/Params/Expressions/UnifiedExpressionsParameters.cs;
    // of these EyeTrackVR sends Eye..., EyeLid... (same file as above).
    Addresses{Dialect::v2, Meaning::x, {"EyeLeftX", "EyeRightX", "EyeX"}},
    Addresses{Dialect::v2, Meaning::y, {"EyeLeftY", "EyeRightY", "EyeY"}},
    Addresses{Dialect::v2, Meaning::lid_v2, {"EyeLidLeft", "EyeLidRight", "EyeLid"}},
    Addresses{Dialect::v2, Meaning::openness, {"EyeOpenLeft", "EyeOpenRight", "EyeOpen"}},
    Addresses{Dialect::v2, Meaning::closed, {"EyeClosedLeft", "EyeClosedRight", "EyeClosed"}},
    Addresses{Dialect::v2, Meaning::pupil, {"PupilDiameterLeft", "PupilDiameterRight", "PupilDiameter"}},
    // The same program's first parameters (its README); of these EyeTrackVR sends LeftEyeX, RightEyeX, EyesY
    // and the lids' ExpandedSqueeze.
    Addresses{Dialect::v1, Meaning::x, {"LeftEyeX", "RightEyeX", "EyesX"}},
    Addresses{Dialect::v1, Meaning::y, {"LeftEyeY", "RightEyeY", "EyesY"}},
    Addresses{Dialect::v1, Meaning::openness, {"LeftEyeLid", "RightEyeLid", ""}},
    Addresses{Dialect::v1, Meaning::lid_v1, {"LeftEyeLidExpandedSqueeze", "RightEyeLidExpandedSqueeze", ""}},
    // Project-Babble/Baballonia, src/VRCFaceTracking.Baballonia/BabbleOSC.cs: with either first letter.
    Addresses{Dialect::baballonia, Meaning::x, {"LeftEyeX", "RightEyeX", ""}},
    Addresses{Dialect::baballonia, Meaning::y, {"LeftEyeY", "RightEyeY", ""}},
    Addresses{Dialect::baballonia, Meaning::openness, {"LeftEyeLid", "RightEyeLid", ""}},
    Addresses{Dialect::baballonia, Meaning::x, {"leftEyeX", "rightEyeX", ""}},
    Addresses{Dialect::baballonia, Meaning::y, {"leftEyeY", "rightEyeY", ""}},
    Addresses{Dialect::baballonia, Meaning::openness, {"leftEyeLid", "rightEyeLid", ""}},
};

struct Found {
  const Addresses* addresses = nullptr;  // None: an address of no table.
  std::size_t eye = 0;                   // Place among its names.
};

Found find(Dialect dialect, std::string_view name) {
  for (const Addresses& one : kAddresses) {
    const auto place = std::ranges::find(one.names, name);
    if (one.dialect == dialect && !name.empty() && place != one.names.end())
      return {&one, static_cast<std::size_t>(place - one.names.begin())};
  }
  return {};
}

/// Avatars nest v2's parameters under any prefix: /avatar/parameters/FT/v2/EyeLeftX.
Found find(std::string_view address) {
  if (address.starts_with(kTracking)) return find(Dialect::native, address.substr(kTracking.size()));
  if (!address.starts_with(kAvatar)) return find(Dialect::baballonia, address.substr(1));
  const std::string_view parameter = address.substr(kAvatar.size());
  constexpr std::string_view kV2 = "v2/";
  const std::size_t at = parameter.rfind(kV2);
  if (at == std::string_view::npos) return find(Dialect::v1, parameter);
  if (at > 0 && parameter[at - 1] != '/') return {};
  return find(Dialect::v2, parameter.substr(at + kV2.size()));
}

float angle(double radians) {
  return std::clamp(static_cast<float>(radians), -kMostRad, kMostRad);
}

float share(double value) {
  return static_cast<float>(std::clamp(value, 0.0, 1.0));
}

class EyesListener final : public OscListener {
 public:
  Result<void> hear(const OscMessage& message) override {
    const auto [address, which] = find(message.address);
    if (address == nullptr) {
      ++eyes.unknown;
      return {};
    }
    if (!message.numeric || message.count != address->numbers)
      return fail(ErrorCode::malformed,
                  fmt::format("{} has not its {} number{}", excerpt(message.address), address->numbers,
                              address->numbers == 1 ? "" : "s"),
                  kOscEyes);
    const auto numbers = std::span(message.numbers).first(message.count);
    if (!std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); }))
      return fail(ErrorCode::out_of_range, "a number that is not finite", kOscEyes);
    ++eyes.known;
    for (std::size_t e = 0; e < 2; ++e) {
      if (which == 1 - e) continue;  // Of the other eye alone.
      MIEN_TRY(say(*address, numbers, e, eyes.said[static_cast<std::size_t>(address->dialect)][e]));
    }
    return {};
  }

  OscEyes eyes;

 private:
  static Result<void> say(const Addresses& address, std::span<const double> numbers, std::size_t eye,
                          SaidOfEye& out) {
    const double value = numbers[0];
    switch (address.meaning) {
      case Meaning::x:
        out.lost[0] = std::abs(value) > kMostCoordinate;
        out.yaw_rad = angle(-std::atan(value));
        return {};
      case Meaning::y:
        out.lost[1] = std::abs(value) > kMostCoordinate;
        out.pitch_rad = angle(std::atan(value));
        return {};
      case Meaning::openness:
        out.openness = share(value);
        return {};
      case Meaning::closed:
        out.openness = share(1 - value);
        return {};
      case Meaning::lid_v2:
        out.openness = share(value / 0.75);
        return {};
      case Meaning::lid_v1:
        out.openness = share(value / 0.8);
        return {};
      case Meaning::pupil:
        out.pupil_mm = static_cast<float>(std::clamp<double>(10 * value, 0, kMostPupilMm));
        return {};
      case Meaning::pitch_yaw:
        return say_angles(numbers.subspan(numbers.size() == 4 ? 2 * eye : 0, 2), out);
      case Meaning::vector:
        return say_vector(numbers.subspan(numbers.size() == 6 ? 3 * eye : 0, 3), out);
    }
    return {};
  }

  static Result<void> say_angles(std::span<const double> pitch_yaw, SaidOfEye& out) {
    if (std::max(std::abs(pitch_yaw[0]), std::abs(pitch_yaw[1])) > 90)
      return fail(ErrorCode::out_of_range, "an angle beyond a quarter turn", kOscEyes);
    out.pitch_rad = angle(-pitch_yaw[0] * kRadPerDeg);
    out.yaw_rad = angle(-pitch_yaw[1] * kRadPerDeg);
    return {};
  }

  /// A direction of any length. One that does not look ahead is none.
  static Result<void> say_vector(std::span<const double> v, SaidOfEye& out) {
    const double most = kMostCoordinate * v[2];
    const bool lost = !(v[2] > 0) || std::abs(v[0]) > most || std::abs(v[1]) > most;
    out.lost.fill(lost);
    out.yaw_rad = lost ? 0 : angle(-std::atan2(v[0], v[2]));
    out.pitch_rad = lost ? 0 : angle(std::atan2(v[1], std::hypot(v[0], v[2])));
    return {};
  }
};

}  // namespace

Result<OscEyes> parse_osc_eyes(std::span<const std::byte> datagram) {
  EyesListener listener;
  MIEN_TRY(read_osc(datagram, listener));
  return listener.eyes;
}

}  // namespace mien::gaze
