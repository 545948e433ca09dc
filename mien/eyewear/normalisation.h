#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/eyewear/light_grid.h"
#include "mien/eyewear/marker_regressor.h"
#include "mien/sensor/calibration.h"
#include "mien/sensor/rig.h"

namespace mien::eyewear {

/// What the middle nine tenths of a sensor's log light span in a range of motion, of an ordinary wearer and
/// sensor; what every sensor has before its wearer has made a range of motion. Measured on virtual wearers
/// (docs/method/eyewear.md).
inline constexpr double kUsualRange = 1.0;

/// How one sensor's light stands to its wearer's face.
struct SensorNormalisation {
  std::string sensor;          ///< The rig's name.
  bool valid = false;          ///< It was there through the neutral hold; else it is missing.
  double neutral = 0;          ///< Log light of the neutral face.
  double unrest = 0;           ///< Of the log light in that hold, one sigma, robust.
  double range = kUsualRange;  ///< Log light that counts as 1; above 0.
  double moved = 0;            ///< What the range of motion spanned; 0: there was none.
  bool operator==(const SensorNormalisation&) const = default;

  /// The feature: change of the log light from neutral, in ranges; held to [-kLimit, kLimit].
  static constexpr double kLimit = 4;
  [[nodiscard]] float feature(double log_light) const;
};

/// A calibration of a pair of smart eyewear on its wearer.
struct Normalisation {
  bool complete = false;                     ///< A neutral hold is in.
  std::vector<SensorNormalisation> sensors;  ///< One a photo-reflective sensor, in the rig's order.
  std::vector<sensor::Score> scores;
  bool operator==(const Normalisation&) const = default;
};

/// What a regressor reads of a frame: features of the sensors that are there and calibrated. Resizes `out`
/// the first time.
void read_features(const Normalisation& normalisation, const GridLight& light, LightFrame& out);

/// JSON, one object; parse_normalisation takes it back to an equal value.
[[nodiscard]] std::string write_normalisation(const Normalisation& normalisation);
/// Errors: malformed, out_of_range (more than 256 sensors, not finite, a range that is not above 0).
[[nodiscard]] Result<Normalisation> parse_normalisation(std::string_view json, const std::string& where);

/// Gathers a neutral hold and a range of motion, frame by frame, and makes the normalisation of them. Every
/// frame's light is kept until solve(), which takes medians: a blink in the hold leaves no trace. Allocates.
/// Thread: one at a time.
class NormalisationMaker {
 public:
  /// Of one stretch as many frames are kept as ten minutes have; later ones are passed over.
  static constexpr std::size_t kMostFrames = 36'000;

  explicit NormalisationMaker(const sensor::Rig& rig);

  /// Forgets what was gathered.
  void reset();
  void begin_neutral();
  void add_neutral(const GridLight& light) { neutral_.add(light); }
  void begin_range();
  void add_range(const GridLight& light) { range_.add(light); }

  /// The normalisation by what was gathered since the last reset; what was not comes from `before`: glasses
  /// that moved on the same face keep their ranges and get a new neutral. Complete where half of the sensors
  /// were there through the hold. Scores judge what was gathered.
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
  void judge_neutral(Normalisation& made) const;
  void judge_range(Normalisation& made) const;

  std::vector<std::string> names_;
  Stretch neutral_;
  Stretch range_;
};

}  // namespace mien::eyewear
