#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/performer/long_motion.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/sample.h"
#include "mien/take/take.h"
#include "mien/virtual/imu/device_trouble.h"
#include "mien/virtual/imu/imu_simulator.h"
#include "mien/virtual/imu/skin_site.h"
#include "mien/virtual/reception.h"

namespace mien::virt {

/// What happens to a sensor that is not the reference. Times from the motion's start, s.
struct SensorEvent {
  std::uint16_t sensor = 0;  ///< In the rig.
  double begin_s = 0;
  double end_s = 0;
  /// It is pushed aside on its skin: by so much in all, in the skin's axes, evenly from begin to end; at once
  /// where these are one.
  Vec3 turn_rad = Vec3::Zero();
  bool silent = false;  ///< Nothing is heard of it from begin to end.
  /// Of a silent one: how far off the heading is that is integrated until the end, rad, by a turn that its
  /// gyroscope wrongly felt shortly before. None: by how far the head turned in the silence.
  std::optional<double> heading_rad;
  std::optional<SkinSite> site;  ///< Of a silent one: it is worn there afterwards.
  bool restarts = false;         ///< Its board begins anew at begin_s.
};

/// One frame of a streamed session, and the truth behind it.
struct StreamedFrame {
  take::Tick tick;
  double motion_s = 0;              ///< Since the motion's start; negative in the prologue.
  face::BlendshapeWeights weights;  ///< As performed.
  /// By sensor of the rig: how far it has crept on its skin, rad, in the skin's axes.
  std::span<const Vec3> creep_rad;
};

/// What hears of samples and frames in the log's order, with the time lines as they are at the frame.
struct StreamConsumer {
  std::function<void(HostTime arrival, const sensor::Sample&)> sample;
  std::function<void(const StreamedFrame&, const sensor::TimeLines&)> frame;
};

/// A session of IMUs in the profile *device*, simulated and received a second at a time: the entries,
/// samples, ticks and truth of play_devices(), to the bit, in memory that does not grow with its length.
/// Thread: one at a time.
class StreamedSession {
 public:
  /// Errors: those of the receiver, of virtual_devices() and of TroubledDevices. The rig outlives this.
  [[nodiscard]] static Result<StreamedSession> create(const sensor::Rig& rig, std::vector<SkinSite> sites,
                                                      const DeviceFaults& faults,
                                                      performer::LongMotion motion, const Random& random,
                                                      std::vector<SensorEvent> events = {});

  /// The prologue's guided phases, on the reference's clock.
  [[nodiscard]] std::vector<take::Event> events() const;
  [[nodiscard]] const std::vector<SkinSite>& sites() const { return *sites_; }
  /// Time up to which the performance is simulated, and of its last frame, s from the prologue's start.
  [[nodiscard]] double simulated_s() const { return tracer_.traced_s(); }
  [[nodiscard]] double duration_s() const { return motion_->duration_s(); }
  [[nodiscard]] bool done() const { return tracer_.done(); }
  /// What arrives in the next second; at the end, all that is under way. Entries and ticks are numbered on
  /// from call to call; the first has the events. Errors: those of the packets' encoder.
  [[nodiscard]] Result<VirtualSession> next(const StreamConsumer& consumer = {});

 private:
  StreamedSession(const sensor::Rig& rig, Reception reception, std::vector<sensor::DeviceKey> devices,
                  std::vector<SkinSite> sites, performer::LongMotion motion);
  [[nodiscard]] const VirtualClock& reference_clock() const;
  /// What happens to sensors in the next second.
  void apply_events();

  const sensor::Rig* rig_;
  Reception reception_;
  std::vector<sensor::DeviceKey> devices_;
  // Where the tracer looks at them, wherever this is moved.
  std::unique_ptr<performer::LongMotion> motion_;
  std::unique_ptr<std::vector<SkinSite>> sites_;
  SkinTracer tracer_;
  DeviceFaults faults_;
  std::vector<SensorEvent> sensor_events_;
  TroubledDevices troubled_;
  std::vector<ImuSimulator> simulators_;
  std::vector<std::vector<Datagram>> waiting_;  // Sent and not received yet, by sensor.
  bool begun_ = false;
};

}  // namespace mien::virt
