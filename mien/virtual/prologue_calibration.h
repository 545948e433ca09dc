#pragma once

#include <vector>

#include "mien/take/take.h"
#include "mien/virtual/session.h"
#include "mien/virtual/stage.h"

namespace mien::virt {

/// The calibrations that the prologue gives, as a live session that was led through it would have made them;
/// none in the profile *lab*, where it is the identity.
[[nodiscard]] std::vector<take::CalibrationVersion> prologue_calibrations(const Stage& stage,
                                                                          const VirtualSession& session);

}  // namespace mien::virt
