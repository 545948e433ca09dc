#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/eyewear/light_grid.h"
#include "mien/eyewear/marker_regressor.h"
#include "mien/sensor/calibration.h"
#include "mien/sensor/rig.h"

namespace mien::eyewear {

/// Usual range: width of the middle 90 % of a sensor's log light (natural logarithm) in a range of motion;
/// the prior of every sensor's range. Measured on virtual wearers (docs/method/eyewear.md).
inline constexpr double kUsualRange = 1.0;

/// Normalisation of one sensor's light for its wearer.
struct SensorNormalisation {
  std::string sensor;          ///< Its name in the rig.
  bool valid = false;          ///< Present through the neutral hold; else the sensor is missing.
  double neutral = 0;          ///< Log light of the neutral face.
  double unrest = 0;           ///< Robust standard deviation of the log light in that hold.
  double range = kUsualRange;  ///< Log light that counts as 1; above 0.
  double moved = 0;            ///< Width measured in the range of motion; 0: none.
  bool operator==(const SensorNormalisation&) const = default;

  /// The feature: (log_light - neutral) / range, clamped to [-kLimit, kLimit].
  static constexpr double kLimit = 4;
  [[nodiscard]] float feature(double log_light) const;
};

/// Calibration of smart eyewear on its wearer.
struct Normalisation {
  bool complete = false;                     ///< A neutral hold was observed.
  std::vector<SensorNormalisation> sensors;  ///< One a photo-reflective sensor, in the rig's order.
  std::vector<sensor::Score> scores;
  bool operator==(const Normalisation&) const = default;
};

/// Features of the sensors present and calibrated, the others missing. Resizes `out` the first time.
void read_features(const Normalisation& normalisation, const GridLight& light, LightFrame& out);

/// One JSON object; parse_normalisation restores an equal value.
[[nodiscard]] std::string write_normalisation(const Normalisation& normalisation);
/// Errors: malformed, out_of_range (more than 256 sensors, not finite, a range that is not above 0). `where`
/// names the source in messages.
[[nodiscard]] Result<Normalisation> parse_normalisation(std::string_view json, const std::string& where);

/// A stretch that a calibration is made of.
enum class StretchKind : std::uint8_t {
  neutral,  ///< The face at rest.
  range,    ///< The range of motion.
};

/// Accumulates a neutral hold and a range of motion, frame by frame, and solves for the normalisation. Stores
/// every frame's light, for medians: a blink in the hold has no influence. Allocates. Thread: one at a time.
/// Method: docs/method/eyewear.md.
class NormalisationMaker {
 public:
  /// Most frames stored of one stretch: ten minutes; later ones are ignored.
  static constexpr std::size_t kMostFrames = 36'000;

  explicit NormalisationMaker(const sensor::Rig& rig);

  /// Drops all frames.
  void reset();
  void begin(StretchKind kind) { stretch(kind).begin(names_.size()); }
  /// A frame of a stretch that was begun; of another nothing is kept.
  void add(StretchKind kind, const GridLight& light) { stretch(kind).add(light); }

  /// The normalisation by the stretches since the last reset; a missing one is taken from `before` (glasses
  /// that moved on the same face get a new neutral and keep their ranges). Complete where half of the sensors
  /// were present through the hold. Scores for the stretches observed.
  [[nodiscard]] Normalisation solve(const Normalisation& before) const;

 private:
  /// The log light of each sensor in the frames of one stretch.
  struct Stretch {
    bool begun = false;
    std::size_t frames = 0;
    std::vector<std::vector<double>> light;
    std::vector<std::size_t> saturated;
    void begin(std::size_t sensors);
    void add(const GridLight& seen);
  };
  Stretch& stretch(StretchKind kind) { return kind == StretchKind::neutral ? neutral_ : range_; }
  void judge_neutral(Normalisation& made) const;
  void judge_range(Normalisation& made) const;

  std::vector<std::string> names_;
  Stretch neutral_;
  Stretch range_;
};

}  // namespace mien::eyewear
