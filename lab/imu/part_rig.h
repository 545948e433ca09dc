#pragma once

#include <span>
#include <string>

#include "mien/core/error.h"
#include "mien/sensor/rig.h"

namespace mien::lab {

/// The rig as somebody wears it who leaves the other face sensors away: these alone, in the rig's order, with
/// all that are not the face's, and of the `[skin]` table what it says of them (the marginal of a normal
/// distribution). Whoever tells headings by the skin then knows no more than they feel. Errors: not_found (a
/// name that is none of the face's), bad_usage (none is named).
[[nodiscard]] Result<sensor::Rig> rig_with_sensors(const sensor::Rig& rig,
                                                   std::span<const std::string> names);

}  // namespace mien::lab
