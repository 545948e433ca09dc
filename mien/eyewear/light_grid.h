#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/newest.h"
#include "mien/core/time.h"
#include "mien/eyewear/ambient.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/rig.h"
#include "mien/sensor/sample.h"

namespace mien::eyewear {

/// The rig's photo-reflective sensors (kind "eyewear"), by their numbers in the rig, in its order.
[[nodiscard]] std::vector<std::uint16_t> photo_sensors(const sensor::Rig& rig);
[[nodiscard]] std::vector<std::string> photo_sensor_names(const sensor::Rig& rig);  ///< Of the same.

/// Light at one frame of the grid; one entry a photo-reflective sensor, in the rig's order.
struct GridLight {
  /// Natural logarithm of the own LED's reflected light, as a share of full scale; log(kDimmest) to 0. Rises
  /// as skin comes nearer.
  std::vector<double> log_light;
  std::vector<std::uint8_t> present;    ///< 0: not received lately, or blinded; log_light is then invalid.
  std::vector<std::uint8_t> saturated;  ///< 1: its newest sample was saturated.
};

/// From samples as they arrive to every sensor's light at the frames of the 60 Hz grid: ambient light and
/// strobes removed (AmbientFilter), logarithm, linear interpolation between the two samples about the frame;
/// after the newest sample its light is held, so that it is causal. A sample whose LED-off reading is at the
/// end of the range is ignored: other light blinds the sensor. A pure function of the calls. Thread: one at a
/// time. No allocation after the first tick.
class LightGrid {
 public:
  /// Floor of the light, share of full scale: half a step of a ten-bit converter, below which the logarithm
  /// is noise.
  static constexpr double kDimmest = 0.5 / 1023;
  /// Time-out: a sensor whose newest sample is older than this at a frame is missing. Raising: drop-outs hide
  /// behind held values. Lowering: sensors are missing sooner.
  static constexpr Duration kSilence = std::chrono::milliseconds(100);

  explicit LightGrid(const sensor::Rig& rig);

  /// A decoded sample as it arrives; those of other kinds are ignored.
  void add(const sensor::Sample& sample);
  /// The sensor's next samples come from another board: drops the earlier ones.
  void forget(std::uint16_t sensor);
  /// The light at a frame of the grid, reference sensor's clock. `lines`: every sensor's clock model, with
  /// all samples that were added.
  void tick(DeviceTime frame, const sensor::TimeLines& lines, GridLight& out) const;

 private:
  /// The newest light of one sensor, on its own clock.
  class Track {
   public:
    void add(const sensor::Sample& sample);
    void reset();
    /// Log light at `time`, the sensor's clock; none where nothing was received lately.
    [[nodiscard]] std::optional<double> at(DeviceTime time) const;
    [[nodiscard]] bool saturated() const { return saturated_; }

   private:
    struct Light {
      DeviceTime time;
      double log_light = 0;
    };

    AmbientFilter filter_;
    Newest<Light, 64> lights_;  // Longer than a frame's latency at 1000 samples a second.
    bool saturated_ = false;
  };

  std::vector<std::uint16_t> sensors_;  // Numbers in the rig.
  std::vector<Track> tracks_;           // Of the same.
  std::vector<std::size_t> track_of_;   // By number in the rig; tracks_.size(): none.
};

}  // namespace mien::eyewear
