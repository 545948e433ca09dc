#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/headset/headset_faults.h"
#include "mien/virtual/headset/headset_simulator.h"
#include "mien/virtual/headset/headset_wearer.h"
#include "mien/virtual/virtual_clock.h"

namespace mien::virt {

/// libjpeg's quality (1 to 100, higher is finer) for one of camera boards (0 to 63, lower is finer): pictures
/// of 240 x 240 have 8.9 KB at a board's 7 and 4.4 KB at its 15 (means of 168 pictures of six wearers), as
/// boards' have.
[[nodiscard]] int jpeg_quality_of(double board);

/// One picture of one camera.
struct BoardPicture {
  std::size_t camera = 0;      ///< Of the rig's cameras, in its order.
  std::uint32_t sequence = 0;  ///< Of the camera's pictures, also of those that never come.
  double read_s = 0;           ///< True time when it was read out: its first row's exposure ended.
  double arrival_s = 0;        ///< True time when it has come; ascends a camera.
  std::vector<std::byte> jpeg;
};

/// A performance at one moment, before the cameras.
struct HeadsetMoment {
  HeadsetPose pose;
  bool fails = false;  ///< The failure that the boards were made for happens.
};

/// What a headset's cameras are to show.
struct HeadsetFilming {
  int width = 0;       ///< Pixels of a picture's width, its height in proportion; 0: the rig's.
  double rate_hz = 0;  ///< At most so many pictures a second; 0: the rig's.
  HeadsetFailure failure = HeadsetFailure::none;
};

/// The boards of a headset with cameras, worn: shot after shot, each camera's JPEG of it, when it was read
/// out and when it comes. All cameras are exposed together, since the simulator poses and lights a face once
/// for all of them, and four times as often would cost four times as much; what differs between them is each
/// board's clock, its way to the receiver, and which pictures it loses. One that is slower than the fastest
/// takes part in a share of the shots. The same streams and calls give the same bytes. Thread: one at a time.
class HeadsetBoards {
 public:
  /// Seat, clocks, JPEG quality are drawn. Errors: not_found (a camera that the rig lacks), those of
  /// virtual_devices().
  [[nodiscard]] static Result<HeadsetBoards> put_on(const HeadsetWearer& wearer, const sensor::Rig& rig,
                                                    const HeadsetFaults& faults, const Random& random,
                                                    const HeadsetFilming& filming);

  [[nodiscard]] std::size_t cameras() const { return cameras_.size(); }
  /// Pictures a second.
  [[nodiscard]] double rate_hz() const { return rate_hz_; }
  [[nodiscard]] const VirtualClock& clock(std::size_t camera) const { return cameras_[camera].clock; }
  [[nodiscard]] sensor::DeviceKey device(std::size_t camera) const { return cameras_[camera].device; }

  /// True time of the next shot, s from the performance's time 0, but for its jitter.
  [[nodiscard]] double shot_s() const { return static_cast<double>(shot_) / rate_hz_; }
  /// Appends the next shot's pictures, those that are lost left out. `at`: the performance at a true time.
  /// Errors: the encoder's. Cost: mien bench headset.
  [[nodiscard]] Result<void> shoot(const std::function<HeadsetMoment(double true_s)>& at,
                                   std::vector<BoardPicture>& out);
  /// Leaves the next shot out: its pictures never come.
  void skip();
  /// Whether upper and lower face could be seen in most of the shots in which the failure happened; none
  /// where it did in none.
  [[nodiscard]] std::optional<std::array<bool, 2>> seen_in_failure() const;

 private:
  struct Camera {
    sensor::DeviceKey device;
    VirtualClock clock;
    double exposure_s = 0;
    double share = 1;  // Of the shots.
    double way_s = 0;  // From read-out to arrival, the least.
    Random delay, loss;
    double newest_s;
    std::uint32_t sequence = 0;
  };
  HeadsetBoards(const HeadsetWearer& wearer, const HeadsetFaults& faults, const Random& random,
                const HeadsetFilming& filming);
  /// Whether the camera takes part in the next shot.
  [[nodiscard]] bool takes_part(const Camera& camera) const;

  std::unique_ptr<const HeadsetWearer> wearer_;
  HeadsetFaults faults_;
  std::unique_ptr<HeadsetSimulator> simulator_;
  std::vector<Camera> cameras_;
  std::vector<std::vector<std::uint8_t>> pixels_;
  Random jitter_;
  int quality_ = 0;
  double rate_hz_ = 0;
  std::int64_t shot_ = 0;
  std::size_t failing_shots_ = 0;
  std::array<std::size_t, 2> seen_shots_{};  // Of these, by half of the face.
};

}  // namespace mien::virt
