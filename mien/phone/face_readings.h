#pragma once

#include <cstdint>

#include "mien/phone/told_face.h"
#include "mien/sensor/protocol.h"

namespace mien::phone {

/// When a face was told: all its samples share it.
struct ToldWhen {
  std::uint32_t sequence = 0;
  DeviceTime time;
  bool estimated = false;  ///< The wire carries no time.
};

/// A sound face as readings of a device's first sensor; one of which nothing is told says that it is alive,
/// one that is held that it sees no face.
void add_readings(const ToldFace& face, std::uint64_t device, const ToldWhen& when, sensor::Inbox& inbox);

}  // namespace mien::phone
