#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "mien/core/time.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/sample_values.h"

namespace mien::session {

/// Finds the camera whose lens a finger covers: the one whose pictures have less contrast than they had, for
/// half a second, while the others' have not. What counts is contrast beside brightness: a camera with
/// exposure control makes a covered lens as bright as a face, and then shows how its lens shades its corners.
/// A lens that showed nothing from the beginning is not one that is covered. A pure function of the calls. No
/// allocation in add but at the end of a wait.
class CoverWatch {
 public:
  /// A lens is covered for so long until that is clear.
  static constexpr Duration kHeld = std::chrono::milliseconds(500);
  /// Another one that is covered for so long by then makes it unclear.
  static constexpr Duration kBeside = std::chrono::milliseconds(150);
  /// From the first picture on.
  static constexpr Duration kPatience = std::chrono::seconds(20);

  struct Covered {
    std::string sensor;
    sensor::DeviceKey device;
  };

  /// Waits for a lens, for this sensor of the rig; an empty name waits no more. What was in the way of the
  /// wait before is forgotten.
  void arm(std::string sensor);
  [[nodiscard]] const std::string& armed() const { return sensor_; }
  /// Why the last wait ended without a camera, one line; empty: it did not. Static storage.
  [[nodiscard]] std::string_view trouble() const { return trouble_; }

  /// A reading; pictures tell, others only how time goes. Returns the camera once that is clear, and waits no
  /// more; nor does it where two are covered, or none was in time.
  [[nodiscard]] std::optional<Covered> add(HostTime arrival, const sensor::Reading& reading);

 private:
  static constexpr std::size_t kDevices = 16;
  struct Device {
    sensor::DeviceKey key;
    float contrast = 0;               // Usual, of pictures while it is not covered: 98 % level less 2 %, ...
    float relative = 0;               // ... and that as a share of the mean level.
    std::optional<HostTime> covered;  // Since when.
    HostTime received;
    bool used = false;
  };
  /// Whether it has been covered for so long, by pictures of which the newest is one of now.
  static bool is_covered(const Device& device, HostTime now, Duration held);
  Device* find(const sensor::DeviceKey& key);
  /// One more picture of it.
  static void look(Device& device, HostTime arrival, const sensor::PictureLight& light);
  void give_up(std::string_view why);

  std::string sensor_;
  std::array<Device, kDevices> devices_;
  std::optional<HostTime> first_;
  std::string_view trouble_;
};

}  // namespace mien::session
