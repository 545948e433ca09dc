#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "mien/core/error.h"
#include "mien/imu/packets/packet.h"
#include "mien/virtual/network.h"

namespace mien::virt {

/// What goes wrong on nodes of our own, told by their packets: times are seconds of the session (the host's
/// clock), sensors their places in the rig. Several may hit one sensor; they act in the order in which they
/// stand here.
struct DeviceTroubles {
  /// The crystal is off, and the clock is stepped now and then.
  struct Clock {
    std::uint16_t sensor = 0;
    double drift_ppm = 0;      ///< Beyond what the device has already; within +-1000.
    double step_us = 0;        ///< Added each time; may be negative. Within +-10,000.
    double step_every_s = 10;  ///< Above 0.
  };
  /// The values stay as they are; packets, times and numbers go on.
  struct Frozen {
    std::uint16_t sensor = 0;
    double from_s = 0;
    double to_s = 0;
  };
  /// The board begins anew: silence while it boots, then its clock and its sequence from nought.
  struct Restart {
    std::uint16_t sensor = 0;
    double at_s = 0;
    double boot_s = 1.5;
  };
  /// Nothing is heard.
  struct Silence {
    std::optional<std::uint16_t> sensor;  ///< None: all of them.
    double from_s = 0;
    double to_s = 0;
  };
  /// Two boards believe that they are the same one.
  struct SharedId {
    std::uint16_t sensor = 0;
    std::uint16_t as = 0;
  };
  std::vector<Clock> clocks;
  std::vector<Frozen> frozen;
  std::vector<Restart> restarts;
  std::vector<Silence> silences;
  std::vector<SharedId> shared_ids;
};

/// One packet on its way through all that is wrong with its device.
struct PassingPacket {
  double at_s = 0;  ///< When it is sent.
  imu::Packet packet;
};

/// Devices in trouble, datagram by datagram.
class TroubledDevices {
 public:
  /// Errors: out_of_range (a trouble).
  [[nodiscard]] static Result<TroubledDevices> create(const DeviceTroubles& troubles);
  /// What a node sends instead of this; false: nothing. Called in each source's order of sending;
  /// Datagram::source is the sensor. Errors: bad_usage (a datagram that is no packet of samples).
  [[nodiscard]] Result<bool> pass(Datagram& datagram);

 private:
  using Trouble = std::function<bool(PassingPacket&)>;
  std::multimap<std::uint16_t, Trouble> of_sensor_;
  std::vector<Trouble> of_all_;
};

/// What the nodes send instead: the packets taken apart and made anew. Shape: `sent` in each source's order
/// of sending; Datagram::source is the sensor. Errors: out_of_range (a trouble); bad_usage (a datagram that
/// is no packet of samples).
[[nodiscard]] Result<std::vector<Datagram>> trouble_devices(std::vector<Datagram> sent,
                                                            const DeviceTroubles& troubles);

}  // namespace mien::virt
