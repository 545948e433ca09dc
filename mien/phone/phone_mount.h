#pragma once

#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/rig.h"

namespace mien::phone {

/// What a phone beside sensors is for.
enum class PhoneUse {
  truth,   ///< It is recorded and moves nothing.
  source,  ///< The face follows it as it does trackers.
};

/// Those of these devices that the rig binds to no sensor. Errors: sensor::bindings'.
[[nodiscard]] Result<std::vector<sensor::DeviceKey>> without_sensor(
    const sensor::Rig& rig, std::span<const sensor::DeviceKey> devices);

/// The rig with a sensor for each of these devices, of which it binds none: "phone", with underscores behind
/// where that name is taken. Its other sensors are bound as they were, as sensor::with_bindings writes it,
/// and all is as a take's reader sees it. Errors: parse_rig's.
[[nodiscard]] Result<sensor::Rig> with_phones(sensor::Rig rig, std::span<const sensor::DeviceKey> devices,
                                              PhoneUse use);

}  // namespace mien::phone
