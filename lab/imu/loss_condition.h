#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/imu/device_trouble.h"
#include "mien/virtual/network.h"

namespace mien::lab {

/// What is made worse: the network, the devices' clocks, or the devices themselves.
enum class Fault : std::uint8_t {
  none,            ///< Nothing beyond the rig's own faults, which are there in every condition.
  loss,            ///< `amount` percent of the packets are lost, each by itself.
  bursts,          ///< The same, ten in a row on average.
  jitter,          ///< Every packet takes some time more, `amount` ms on average (exponential).
  even_jitter,     ///< Every packet takes 0 to `amount` ms more, evenly.
  lag,             ///< Every packet takes `amount` ms more.
  disorder,        ///< `amount` percent come twice, and packets overtake each other by up to 40 ms.
  clock_drift,     ///< Every clock is `amount` ppm off, either way, and stepped by 500 us every ten seconds.
  restart,         ///< One face sensor restarts half-way, with a new clock.
  shared_id,       ///< One face sensor sends with another's id; the first of the two is received.
  sensor_silent,   ///< The face sensor `sensor` is never heard.
  sensors_silent,  ///< `amount` face sensors are never heard.
  head_silent,     ///< The head's sensor is not heard for `amount` seconds, half-way.
  corrupted,       ///< `amount` percent of the packets have one to four bytes changed.
  truncated,       ///< Of `amount` percent only a beginning arrives.
  frozen,          ///< `amount` face sensors say the same from the motion's beginning to its end.
  all_silent,      ///< Nothing is heard for `amount` seconds, half-way.
};

/// One setting that performances are heard under. Sensors that are not named are drawn for each performance.
struct LossCondition {
  Fault fault = Fault::none;
  double amount = 0;
  std::string sensor;  ///< Of Fault::sensor_silent.

  /// As a table's row has it.
  [[nodiscard]] std::string name() const;
};

/// The study's own conditions for a rig, in the order in which they are shown: loss and bursts to 20 %,
/// jitter and lag to 100 ms, disorder, clocks, a restart, two nodes with one id, every face sensor silent,
/// two and three at once, the head's for two seconds. Without Fault::none, and without what the rig has too
/// few sensors for.
[[nodiscard]] std::vector<LossCondition> loss_conditions(const sensor::Rig& rig);

/// What a condition asks of the network and the devices.
struct Impairment {
  virt::NetworkSettings network;
  virt::DeviceTroubles troubles;
};

/// The condition's impairment of one performance, whose motion lasts from `begin_s` to `end_s` of the
/// session. Sensors and clocks that it does not name are drawn from `random`; three that fall silent are the
/// two and one more. Errors: not_found (a sensor; too few of them).
[[nodiscard]] Result<Impairment> impairment(const LossCondition& condition, const sensor::Rig& rig,
                                            double begin_s, double end_s, const Random& random);

}  // namespace mien::lab
