#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mien/core/time.h"
#include "mien/tracker/tracker.h"

namespace mien::session {

/// Watches how uncertain the sensors' rotations have become since the calibration, and tells when re-centring
/// is worth a person's two seconds: once they are less certain than kLimit_rad, or a sensor is left out for
/// its uncertainty, all through kFor. Cameras state no uncertainty: a headset that slips is not noticed. A
/// pure function of the calls, on frame time. No allocation but where it tells.
class DriftWatch {
 public:
  /// RMS over the sensors (5 degrees): twice what hours of a session have where all goes well
  /// (docs/experiments/hours.md), and about where a face is visibly wrong.
  static constexpr double kLimit_rad = 0.087;
  static constexpr Duration kFor = std::chrono::seconds(10);
  /// Who does not care to re-centre is told again so much later.
  static constexpr Duration kAgain = std::chrono::minutes(10);

  struct Advice {
    double sigma_rad = 0;
    std::vector<std::uint16_t> left_out;  ///< Numbers in the rig.
  };

  /// About once a second. Shape: an entry a sensor of the rig; none where nothing is known of it.
  [[nodiscard]] std::optional<Advice> add(DeviceTime frame,
                                          std::span<const std::optional<tracker::SensorCertainty>> sensors);
  /// A calibration or re-centring is in force from here on.
  void reset();

  /// RMS over the sensors at the last add(), rad; none where nothing is known.
  [[nodiscard]] std::optional<double> sigma_rad() const { return sigma_rad_; }
  /// Whether re-centring is worth it now.
  [[nodiscard]] bool advises() const { return advises_; }

 private:
  std::optional<double> sigma_rad_;
  std::optional<DeviceTime> since_;  // It has been uncertain.
  std::optional<DeviceTime> told_;
  bool advises_ = false;
};

}  // namespace mien::session
