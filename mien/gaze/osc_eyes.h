#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "mien/core/error.h"

namespace mien::gaze {

/// The addresses that programs send eyes to, the fullest first: of several at once the first is believed.
enum class Dialect : std::uint8_t {
  native,      ///< VRChat's own: /tracking/eye/LeftRightVec and its kin.
  v2,          ///< VRCFaceTracking's unified parameters: /avatar/parameters/v2/EyeLeftX.
  v1,          ///< Its older ones: /avatar/parameters/LeftEyeX.
  baballonia,  ///< Without a prefix: /LeftEyeX.
};
inline constexpr std::size_t kDialectCount = 4;

/// What a datagram says of one eye; what it does not name is not known.
struct SaidOfEye {
  /// Rad, as Eye has them. Programs send coordinates whose tangents' scale is 1 = 45 degrees, x to the
  /// performer's right and y upwards: yaw = -atan(x), pitch = atan(y).
  std::optional<float> yaw_rad;
  std::optional<float> pitch_rad;
  std::optional<float> openness;  ///< 0 closed to 1 open as at rest; wider is 1.
  std::optional<float> pupil_mm;
  /// Of yaw and of pitch: a coordinate beyond kMostCoordinate was sent, so the program has no direction of
  /// this eye (EyeTrackVR sends 621 until it has).
  std::array<bool, 2> lost{};
  bool operator==(const SaidOfEye&) const = default;
};
/// 63 degrees: farther than eyes turn.
inline constexpr double kMostCoordinate = 2;

/// What one datagram says of the eyes: left, right.
struct OscEyes {
  std::array<std::array<SaidOfEye, 2>, kDialectCount> said{};  ///< By Dialect.
  std::size_t known = 0;                                       ///< Messages to addresses of the table.
  std::size_t unknown = 0;                                     ///< Messages to others: no error.
  bool operator==(const OscEyes&) const = default;
};

/// Errors: read_osc()'s; malformed (an address of the table with other types, or another number of them, than
/// it has), out_of_range (a number that is not finite, an angle beyond a quarter turn). No allocation but in
/// errors. Thread-safe.
[[nodiscard]] Result<OscEyes> parse_osc_eyes(std::span<const std::byte> datagram);

}  // namespace mien::gaze
