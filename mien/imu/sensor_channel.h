#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>

#include "mien/core/rotation.h"
#include "mien/core/time.h"
#include "mien/imu/fusion.h"
#include "mien/imu/orientation_track.h"
#include "mien/imu/sample_history.h"

namespace mien::imu {

/// A restarted board is used after this time without another long gap: where two boards share one number,
/// that never happens.
inline constexpr Duration kSettleTime = std::chrono::milliseconds(200);

/// Packets overtake one another while one did within this time: then a gap counts once no late packet can
/// fill it any more, after kFilledWithin.
inline constexpr Duration kDisorderLasts = std::chrono::seconds(10);
inline constexpr Duration kFilledWithin = std::chrono::milliseconds(100);

/// Uncertainty that gaps added to an orientation since it was last read.
struct Gaps {
  double sigma_rad = 0;         ///< One standard deviation, rad.
  bool tilt_restarted = false;  ///< A gap was so long that the inclination was begun anew.
};

/// One sensor of the rig: from samples to fused orientations, on its own clock.
struct Channel {
  explicit Channel(const FusionSettings& settings) : integration(settings) {}
  /// What gaps have added since the last call, by the fusion's sums at a sample of that time: once each, so
  /// nothing where an earlier sample is asked than the last time.
  Gaps take_gaps(double sigma, std::uint64_t restarts_by_then, DeviceTime then) {
    if (gaps_until && then <= *gaps_until) return {};
    const Gaps gaps{std::sqrt(std::max(0.0, sigma * sigma - gap_sigma * gap_sigma)),
                    restarts_by_then > restarts};
    gap_sigma = sigma;
    restarts = restarts_by_then;
    gaps_until = then;
    return gaps;
  }
  Gaps take_gaps() {
    if (!integration.newest) return {};
    return take_gaps(integration.fusion.gap_sigma_rad(), integration.fusion.restarts(), *integration.newest);
  }
  /// False for a while after a restart, until the new stream has run without a long gap.
  [[nodiscard]] bool settled() const {
    return !restarted || !integration.newest || *integration.newest - integration.steady_since >= kSettleTime;
  }
  /// Whether a packet was overtaken lately.
  [[nodiscard]] bool disordered() const {
    return overtaken && integration.newest && *integration.newest - *overtaken < kDisorderLasts;
  }

  Integration integration;
  SampleHistory history;
  bool behind = false;  // The history has samples that are not integrated.
  OrientationTrack track;
  double gap_sigma = 0;                  // The fusion's at the last take_gaps(), ...
  std::uint64_t restarts = 0;            // ... its restarts, ...
  std::optional<DeviceTime> gaps_until;  // ... and of which sample they were.
  std::optional<DeviceTime> overtaken;   // The newest time when a late sample last came.
  bool restarted = false;                // Its heading is unrelated to the calibrated one.
  bool may_be_unchanged = false;         // Sends nothing while its rotation is constant.
  std::uint64_t dropped = 0;             // As SensorStatus has it.
};

}  // namespace mien::imu
