#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "mien/core/newest.h"
#include "mien/gaze/eyes.h"
#include "mien/sensor/rig.h"
#include "mien/tracker/tracker.h"

namespace mien::gaze {

/// Tracker of the modality "gaze": each eye's direction is that of the newest sample, of the rig's sensors
/// the one that is surest of the eye, provenance measured; the frame's confidence is both eyes' mean. An eye
/// that is not seen turns with the other. While neither is (a blink), the last directions are held, with
/// confidence 0. Where openness is known eyeBlink is 1 - openness, measured, confidence 1. All else is
/// neutral: of lids that follow the eyes the shaper knows (shaping/lids.h). Nothing to calibrate. No
/// allocation.
class GazeTracker final : public tracker::Tracker {
 public:
  /// A sensor without a sample for so long is not present.
  static constexpr Duration kPresent = std::chrono::milliseconds(200);

  /// Errors: mismatch (a rig without sensors of the kind "gaze").
  [[nodiscard]] static Result<std::unique_ptr<GazeTracker>> create(const sensor::Rig& rig);

  [[nodiscard]] std::string_view modality() const override { return "gaze"; }
  void add(HostTime arrival, const sensor::Sample& sample) override;
  void forget(std::uint16_t sensor) override;
  tracker::TickResult tick(DeviceTime frame, const sensor::TimeLines& lines, face::OutputFrame& out) override;

 private:
  struct Seen {
    DeviceTime time;
    Eyes eyes;
  };
  /// One sensor's newest samples: a frame may be older than the newest.
  struct Channel {
    std::uint16_t sensor = 0;
    Newest<Seen, 32> samples;
    /// The newest that is not after `time`, nor older than kPresent before it; null for none.
    [[nodiscard]] const Seen* at(DeviceTime time) const;
  };
  explicit GazeTracker(std::vector<Channel> channels) : channels_(std::move(channels)) {}
  void answer(const Eyes& eyes, face::OutputFrame& out);

  std::vector<Channel> channels_;
  std::optional<std::array<Eigen::Vector2f, 2>> last_rad_;  // Directions last seen.
};

}  // namespace mien::gaze
