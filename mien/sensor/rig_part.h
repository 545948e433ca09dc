#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "mien/sensor/rig.h"

namespace mien::sensor {

/// The kinds of the rig's sensors, each once, in the order in which they come; a truth, here and below, is of
/// none.
[[nodiscard]] std::vector<std::string> kinds_of(const Rig& rig);
/// The sensors of one kind, by their numbers in the rig, in its order.
[[nodiscard]] std::vector<std::uint16_t> sensors_of(const Rig& rig, std::string_view kind);
/// The sensors that are truths, likewise.
[[nodiscard]] std::vector<std::uint16_t> truths_of(const Rig& rig);
/// The rig as those see it who know one kind of sensor: the others keep their numbers, so that samples need
/// no renumbering, and their clocks, since one of them may carry the frame grid; but they have no role, so
/// that they are neither the face's nor the head's.
[[nodiscard]] Rig part_of(const Rig& rig, std::string_view kind);

}  // namespace mien::sensor
