#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "mien/eyewear/light_grid.h"
#include "mien/eyewear/normalisation.h"
#include "mien/face/motion.h"
#include "mien/face/profile.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/eyewear/eyewear_simulator.h"

namespace mien::synthetic {

/// The first minute with glasses: neutral for this long, ...
inline constexpr double kHoldS = 10;
/// ... then a range of motion.
inline constexpr double kRangeS = 50;
/// The neutral hold after glasses were taken off and put on again.
inline constexpr double kRemountS = 5;

/// What a person is asked for in the range of motion: sixteen poses of three seconds, each as far as it goes,
/// of brows, lids, nose, cheeks, mouth and jaw; and how a person follows (mien/performer/mimic.h). As long as
/// kRangeS.
[[nodiscard]] face::Motion range_of_motion(const Random& random);

/// Virtual glasses on a wearer, as a live session sees them: light on the frames' grid, beside what the face
/// did. Time goes on from call to call. One face at a time; the simulator must outlive it.
class WornGlasses {
 public:
  WornGlasses(virt::EyewearSimulator& simulator, const sensor::Rig& rig);

  using See = std::function<void(const eyewear::GridLight&, const face::BlendshapeWeights&)>;
  /// From now on: what becomes of a performance's samples before they are received, in the order in which
  /// they are.
  using Spoil = std::function<void(std::vector<sensor::Sample>&)>;
  void spoil(Spoil spoil) { spoil_ = std::move(spoil); }

  /// Plays the motion's first `seconds`; `see` is called at every frame of 60 Hz, the first at its beginning.
  /// Cost: a fiftieth of real time.
  void play(const face::Motion& motion, double seconds, const See& see);
  /// Nobody looks.
  void rest(double seconds) { now_s_ += seconds; }
  [[nodiscard]] double now_s() const { return now_s_; }

  /// The first minute: kHoldS of neutral and the range of motion; `see` as in play(), may be empty.
  [[nodiscard]] eyewear::Normalisation first_minute(const Random& random, const See& see);
  /// kRemountS of neutral; ranges stay.
  [[nodiscard]] eyewear::Normalisation hold_neutral(const eyewear::Normalisation& before,
                                                    const Random& random);

 private:
  virt::EyewearSimulator* simulator_;
  sensor::Rig rig_;
  sensor::TimeLines lines_;
  eyewear::LightGrid grid_;
  eyewear::GridLight light_;
  Spoil spoil_;
  double now_s_ = 0;
};

}  // namespace mien::synthetic
