#pragma once

#include <array>

#include "mien/face/profile.h"

namespace mien::tracker {

/// How much of each shape's variance a tracker's answer explains with the sensors that are there, 0 to 1,
/// measured on people whom its model never saw (model::ConfidenceTable). It changes with the sensors and not
/// with the weights, so trackers of one face can be compared by it.
using Explained = std::array<float, face::kShapeCount>;

}  // namespace mien::tracker
