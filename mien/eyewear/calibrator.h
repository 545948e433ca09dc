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

/// Finds lights that stay as they are for two seconds, while nothing else tells what a wearer's neutral face
/// is. Fed with one frame of the grid after the other. No allocation after the first frame.
class SteadyWatch {
 public:
  /// A hold has so many frames: two seconds.
  static constexpr std::size_t kFrames = 120;
  /// Steady: at least half of the sensors were there in all of them, and the log light of the middle one of
  /// these scattered by no more than this (one sigma).
  static constexpr double kSteady = 0.25;

  /// True when this frame and those before it make a steady hold.
  bool add(const GridLight& light);
  /// The newest frames, the hold's when add() said so; oldest first.
  [[nodiscard]] const GridLight& frame(std::size_t i) const { return frames_[(next_ + i) % kFrames]; }
  void reset() { count_ = 0; }

 private:
  [[nodiscard]] bool steady() const;

  std::vector<GridLight> frames_;  // A ring; next_ is the oldest.
  std::size_t next_ = 0;
  std::size_t count_ = 0;
  mutable std::vector<double> scatter_;
};

/// The calibration of a pair of smart eyewear as time goes on: guided stretches, or a neutral that it finds
/// by itself. A pure function of the calls. Thread: one at a time. Allocates where a calibration is made.
class Calibrator {
 public:
  explicit Calibrator(const sensor::Rig& rig);

  /// A guided stretch on the frames [begin, end); given before the frame of its begin. The neutral's end puts
  /// a calibration in force, and the range of motion's end the one with ranges.
  void guide_neutral(DeviceTime begin, DeviceTime end);
  void guide_range(DeviceTime begin, DeviceTime end);
  /// Ends guidance; what was in force before its first stretch is in force again.
  void cancel();
  /// What became of the calibration at a frame.
  enum class Change : std::uint8_t {
    none,
    calibrated,  ///< Another one is in force.
    withdrawn,   ///< Guidance failed: what was in force before its first stretch is in force again.
  };
  /// The next frame, with what the sensors see.
  Change add(DeviceTime frame, const GridLight& light);
  /// Another board's light says nothing about this one's neutral: the sensor, by its place among the
  /// photo-reflective ones, is missing until the next calibration.
  void forget(std::size_t sensor);
  /// Errors: mismatch (other sensors, or another order).
  [[nodiscard]] Result<void> restore(const Normalisation& normalisation);

  [[nodiscard]] const Normalisation& in_force() const { return in_force_; }
  [[nodiscard]] bool guided() const { return !stretches_.empty(); }
  /// A neutral face is waited for, or held.
  [[nodiscard]] bool wants_neutral() const;
  /// Why the last guidance did not do; empty when it did.
  [[nodiscard]] std::string_view hint() const { return hint_; }
  struct Span {
    DeviceTime begin, end;
  };
  /// The hold that it found by itself; none where the calibration in force is another.
  [[nodiscard]] const std::optional<Span>& found() const { return found_; }

 private:
  struct Stretch {
    bool neutral = true;
    DeviceTime begin, end;
    bool begun = false;
  };
  void guide(const Stretch& stretch);
  Change lead(DeviceTime frame, const GridLight& light);
  Change finish(const Stretch& stretch);
  void fall_back();
  Change watch(DeviceTime frame, const GridLight& light);
  void put_in_force(Normalisation made);

  std::vector<std::string> names_;
  NormalisationMaker maker_;
  SteadyWatch steady_;
  std::vector<Stretch> stretches_;  // Those that are not over.
  Normalisation in_force_;
  Normalisation before_;  // In force when the first stretch was given.
  std::optional<Span> found_, found_before_;
  std::string_view hint_;
};

}  // namespace mien::eyewear
