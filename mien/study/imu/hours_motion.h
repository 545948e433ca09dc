#pragma once

#include "mien/performer/long_motion.h"

namespace mien::study {

using performer::HeldExpression;
using performer::kPieceS;
using HoursMotion = performer::LongMotion;

}  // namespace mien::study
