#pragma once

#include <functional>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/sample.h"
#include "mien/study/imu/hours_motion.h"
#include "mien/study/performance.h"
#include "mien/take/take.h"
#include "mien/virtual/imu/imu_simulator.h"
#include "mien/virtual/reception.h"

namespace mien::study {

/// A sensor that is pushed aside on its skin.
struct Push {
  std::uint16_t sensor = 0;      ///< In the rig.
  double begin_s = 0;            ///< From the motion's start.
  double end_s = 0;              ///< Turned evenly until then; begin_s: at once.
  Vec3 turn_rad = Vec3::Zero();  ///< In all, in the skin's axes.
};

/// One frame of a session of hours, and the truth behind it.
struct HoursFrame {
  take::Tick tick;
  double motion_s = 0;              ///< Since the motion's start; negative in the prologue.
  face::BlendshapeWeights weights;  ///< As performed.
  /// By sensor of the rig: how far it has crept on its skin, rad, in the skin's axes.
  std::span<const Vec3> creep_rad;
};

/// What its consumer is given, in the log's order.
struct HoursConsumer {
  std::function<void(HostTime arrival, const sensor::Sample&)> sample;
  std::function<void(const HoursFrame&, const sensor::TimeLines&)> frame;
};

/// A virtual session of hours in the profile *device*, simulated and received a second at a time: the same
/// simulators, packets and receiver as of a short one (play_devices()), in memory that does not grow. Thread:
/// one at a time.
class HoursSession {
 public:
  /// Errors: those of the receiver and of virtual_devices(). The rig outlives this.
  [[nodiscard]] static Result<HoursSession> create(const sensor::Rig& rig, std::vector<virt::SkinSite> sites,
                                                   const virt::DeviceFaults& faults, HoursMotion motion,
                                                   const Random& random, std::vector<Push> pushes = {});

  /// The prologue's guided phases, on the reference's clock.
  [[nodiscard]] std::vector<take::Event> events() const;
  [[nodiscard]] const std::vector<virt::SkinSite>& sites() const { return sites_; }
  /// The next second. Errors: those of the packets' encoder.
  [[nodiscard]] Result<void> next(const HoursConsumer& consumer);

 private:
  HoursSession(const sensor::Rig& rig, virt::Reception reception, std::vector<sensor::DeviceKey> devices,
               HoursMotion motion);
  [[nodiscard]] virt::SkinTrajectory trace(std::size_t points);
  void push();

  const sensor::Rig* rig_;
  virt::Reception reception_;
  std::vector<sensor::DeviceKey> devices_;
  HoursMotion motion_;
  std::vector<virt::SkinSite> sites_;
  virt::DeviceFaults faults_;
  std::vector<Push> pushes_;
  std::vector<virt::ImuSimulator> simulators_;
  std::vector<virt::Datagram> waiting_;  // Sent, and not received yet; by arrival.
  std::size_t traced_ = 0;               // Grid points.
};

}  // namespace mien::study
