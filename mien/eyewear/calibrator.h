#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/time.h"
#include "mien/eyewear/light_grid.h"
#include "mien/eyewear/normalisation.h"
#include "mien/sensor/rig.h"

namespace mien::eyewear {

/// Detects two seconds of steady light, as a neutral hold for wearers without a calibration. Takes every
/// frame of the 60 Hz grid. No allocation after the first frame.
class SteadyWatch {
 public:
  /// Frames of a hold: two seconds.
  static constexpr std::size_t kFrames = 120;
  /// Steady: at least half of the sensors present in all frames, and the median over these of each one's
  /// standard deviation of log light (natural logarithm) at most this. Raising: expressions pass for neutral.
  /// Lowering: no hold is found, since folds and sway move light at rest too (docs/method/eyewear.md).
  static constexpr double kSteady = 0.25;

  /// True when the last kFrames frames are a steady hold.
  bool add(const GridLight& light);
  /// The last kFrames frames, oldest first; the hold's after add() returned true.
  [[nodiscard]] const GridLight& frame(std::size_t i) const { return frames_[(next_ + i) % kFrames]; }
  void reset() { count_ = 0; }

 private:
  [[nodiscard]] bool steady() const;

  std::vector<GridLight> frames_;  // Ring buffer; next_ is the oldest.
  std::size_t next_ = 0;
  std::size_t count_ = 0;
  mutable std::vector<double> scatter_;
};

/// Calibration of smart eyewear during a session: guided stretches, or a neutral found by SteadyWatch. A pure
/// function of the calls. Thread: one at a time. Allocates where a calibration is made. Method:
/// docs/method/eyewear.md.
class Calibrator {
 public:
  explicit Calibrator(const sensor::Rig& rig);

  /// A guided stretch on the frames [begin, end), reference sensor's clock; given before the frame of its
  /// begin. The neutral's end puts a calibration in force, the range of motion's end one with measured
  /// ranges.
  void guide(StretchKind kind, DeviceTime begin, DeviceTime end);
  /// Ends guidance and restores what was in force before its first stretch.
  void cancel();
  /// Change of the calibration at a frame.
  enum class Change : std::uint8_t {
    none,
    calibrated,  ///< A new one is in force.
    withdrawn,   ///< Guidance failed: what was in force before it is restored.
  };
  /// The next frame, with every sensor's light.
  Change add(DeviceTime frame, const GridLight& light);
  /// The sensor's board was replaced: it is missing until the next calibration. `sensor`: index among the
  /// photo-reflective ones.
  void forget(std::size_t sensor);
  /// Errors: mismatch (other sensors, or another order).
  [[nodiscard]] Result<void> restore(const Normalisation& normalisation);

  [[nodiscard]] const Normalisation& in_force() const { return in_force_; }
  [[nodiscard]] bool guided() const { return !stretches_.empty(); }
  /// Whether a neutral hold is waited for or in progress.
  [[nodiscard]] bool wants_neutral() const;
  /// Why the last guidance failed; empty otherwise. A string literal.
  [[nodiscard]] std::string_view hint() const { return hint_; }
  struct Span {
    DeviceTime begin, end;
  };
  /// The hold that SteadyWatch found; none where the calibration in force is another.
  [[nodiscard]] const std::optional<Span>& found() const { return found_; }

 private:
  struct Stretch {
    StretchKind kind;
    DeviceTime begin, end;
    bool begun = false;
  };
  Change lead(DeviceTime frame, const GridLight& light);
  Change finish(const Stretch& stretch);
  void fall_back();
  Change watch(DeviceTime frame, const GridLight& light);
  void put_in_force(Normalisation made);

  std::vector<std::string> names_;
  NormalisationMaker maker_;
  SteadyWatch steady_;
  std::vector<Stretch> stretches_;  // Not yet ended.
  Normalisation in_force_;
  Normalisation before_;  // In force before the first stretch.
  std::optional<Span> found_, found_before_;
  std::string_view hint_;
};

}  // namespace mien::eyewear
