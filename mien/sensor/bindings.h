#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "mien/core/error.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/rig.h"

namespace mien::sensor {

/// The id of the virtual node at this place of a rig: 02:4D:49:45:4E:nn ("MIEN"), nn the place, 0 to 255.
[[nodiscard]] constexpr std::uint64_t virtual_device(std::size_t sensor) {
  return 0x024D'4945'4E00ULL + sensor;
}

/// Which device each sensor of the rig is bound to, as the rig says, in its order; sensors that it binds to
/// none are left out. Where it binds none at all, every sensor is bound to the virtual node of its place.
/// Errors: malformed (a binding that is no device), bad_usage (two sensors bound to one).
[[nodiscard]] Result<std::vector<std::pair<DeviceKey, std::uint16_t>>> bindings(const Rig& rig);

/// The rig with bindings() written at its sensors, so that one more that is bound does not take the virtual
/// nodes' from the others. Errors: those of bindings().
[[nodiscard]] Result<Rig> with_bindings(Rig rig);

}  // namespace mien::sensor
