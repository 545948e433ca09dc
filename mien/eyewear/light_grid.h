#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/time.h"
#include "mien/eyewear/ambient.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/rig.h"
#include "mien/sensor/sample.h"

namespace mien::eyewear {

/// The rig's photo-reflective sensors (of the kind "eyewear"), by their numbers in the rig, in its order.
[[nodiscard]] std::vector<std::uint16_t> photo_sensors(const sensor::Rig& rig);
[[nodiscard]] std::vector<std::string> photo_sensor_names(const sensor::Rig& rig);  ///< Of the same.

/// What the sensors see at one frame of the grid; an entry a photo-reflective sensor, in the rig's order.
struct GridLight {
  /// Natural logarithm of its own LED's light, as a share of full scale. Rises as skin comes nearer.
  std::vector<double> log_light;
  std::vector<std::uint8_t> present;    ///< 0: not heard lately, or blinded; log_light then says nothing.
  std::vector<std::uint8_t> saturated;  ///< 1: its newest reading stood at the end of its range.
};

/// From samples as they arrive to every sensor's light at the frames of the grid: ambient light and strobes
/// taken off (AmbientFilter), the logarithm, and linear interpolation between the two samples that stand
/// about the frame; after the newest sample its light is held, so that nothing of the future is used. Where
/// the reading with the LED off stands at the end of the range other light blinds the sensor, and the sample
/// is passed over. A pure function of the calls. Thread: one at a time. No allocation after the first tick.
class LightGrid {
 public:
  /// Light below half a step of a converter of ten bits counts as this: its logarithm would only be noise.
  static constexpr double kDimmest = 0.5 / 1023;
  /// A sensor whose newest sample is older than this at a frame is missing.
  static constexpr Duration kSilence = std::chrono::milliseconds(100);

  explicit LightGrid(const sensor::Rig& rig);

  /// A decoded sample as it arrives; those of other kinds are ignored.
  void add(const sensor::Sample& sample);
  /// The sensor's next samples are another board's.
  void forget(std::uint16_t sensor);
  /// At a frame of the grid. `lines`: every sensor's clock, with all samples that were added.
  void tick(DeviceTime frame, const sensor::TimeLines& lines, GridLight& out) const;

 private:
  /// The newest light of one sensor, on its own clock.
  class Track {
   public:
    void add(const sensor::Sample& sample);
    void reset();
    /// The logarithm of the light at `time`; none when nothing was heard lately.
    [[nodiscard]] std::optional<double> at(DeviceTime time) const;
    [[nodiscard]] bool saturated() const { return saturated_; }

   private:
    static constexpr std::size_t kKept = 64;  // A frame's wait and more, of 1000 samples a second.
    struct Light {
      DeviceTime time;
      double log_light = 0;
    };
    /// `back` samples before the newest.
    [[nodiscard]] const Light& light(std::size_t back) const { return lights_[(next_ - 1 - back) % kKept]; }

    AmbientFilter filter_;
    std::array<Light, kKept> lights_{};
    std::size_t next_ = 0;  // Samples so far.
    bool saturated_ = false;
  };

  std::vector<std::uint16_t> sensors_;  // Numbers in the rig.
  std::vector<Track> tracks_;           // Of the same.
  std::vector<std::size_t> track_of_;   // By number in the rig; tracks_.size(): none.
};

}  // namespace mien::eyewear
