#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "mien/core/random.h"
#include "mien/eyewear/linearise.h"
#include "mien/face/profile.h"
#include "mien/sensor/sample.h"
#include "mien/virtual/eyewear/eyewear_faults.h"
#include "mien/virtual/eyewear/eyewear_wearer.h"
#include "mien/virtual/eyewear/photo_sensor.h"
#include "mien/virtual/virtual_clock.h"

namespace mien::virt {

/// Photo-reflective glasses on a moving face: rays from each sensor to the skin, the light that comes back,
/// and what the board makes of it. The same wearer, random stream and calls give the same samples. Not
/// thread-safe; several may run side by side.
class EyewearSimulator {
 public:
  /// The glasses are put on as they were fitted; put_on() draws another seat. The wearer must outlive it.
  EyewearSimulator(const EyewearWearer& wearer, const EyewearFaults& faults, const Random& random);
  EyewearSimulator(EyewearSimulator&&) noexcept;
  ~EyewearSimulator();

  /// Taken off and put on again: another seat, drawn. One that would press a sensor into the neutral skin is
  /// drawn anew.
  void put_on();
  /// Or exactly here, for studies of shifts.
  void sit(const EyewearSeat& seat);
  [[nodiscard]] EyewearSeat seat() const;

  /// `pairs` LED-on and LED-off readings of every sensor from true time `begin_s` on, at the pair rate: in
  /// each pair the sensors are read in turn. The face goes from `from` to `to` in that time; light is traced
  /// at both ends and taken to change evenly between, so windows of some 50 ms are right. Slip, sway, folds,
  /// blood, sweat and lamps go on from the last call's time; times do not run backwards. Samples by time;
  /// SampleKind::eyewear_light, `sequence` counts pairs. Cost: about a millisecond.
  [[nodiscard]] std::vector<sensor::Sample> play(double begin_s, int pairs,
                                                 const face::BlendshapeWeights& from,
                                                 const face::BlendshapeWeights& to);

  /// What comes back to each sensor of its LED's light now, with the skin so: as a white surface at the peak
  /// gives 1.
  [[nodiscard]] std::vector<double> reflected(const face::BlendshapeWeights& weights);
  /// How far each sensor's middle ray goes to the skin, metres; not finite where it meets none.
  [[nodiscard]] std::vector<double> distances_m(const face::BlendshapeWeights& weights);

  /// Each sensor before a card of mean skin's reflectance in the dark, from 1 to 30 mm: what a maker measures
  /// once, to linearise by.
  [[nodiscard]] std::vector<eyewear::BenchReading> bench(std::size_t sensor) const;

  [[nodiscard]] const VirtualClock& clock() const { return clock_; }
  [[nodiscard]] double pair_period_s() const { return 1 / faults_.pair_rate_hz; }

 private:
  class Skin;
  void wait_until(double time_s);
  /// The seat, its sway, and what raised cheeks and a wrinkled nose lift.
  [[nodiscard]] EyewearSeat seat_with(const face::BlendshapeWeights& weights) const;

  const EyewearWearer* wearer_;
  EyewearFaults faults_;
  PhotoResponse response_;
  std::unique_ptr<Skin> skin_;
  std::vector<PhotoSensor> parts_;
  std::vector<double> sweat_;  ///< Logarithm of each spot's factor.
  double blush_ = 0;           ///< Logarithm.
  EyewearSeat seat_;
  EyewearSeat sway_;              ///< Added to the seat.
  std::vector<double> tissue_m_;  ///< How far each spot's skin stands out beyond what the shapes say.
  VirtualClock clock_;
  double now_s_ = 0;
  std::uint32_t sequence_ = 0;
  Random seats_;
  Random slip_;
  Random skin_walk_;
  Random sways_;
  Random tissues_;
};

}  // namespace mien::virt
