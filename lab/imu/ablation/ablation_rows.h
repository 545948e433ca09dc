#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lab/imu/person_errors.h"
#include "lab/imu/short_recipe.h"
#include "mien/core/error.h"
#include "mien/sensor/rig.h"

namespace mien::lab {

/// Whom a row's networks learn from.
enum class LearnsFrom : std::uint8_t {
  performers,  ///< Virtual performers, of whom everything is known.
  takes,       ///< People's takes, labelled by a phone.
  both,        ///< Half of each step's windows from each.
};

/// One way to leave something out, or to do it another way.
struct AblationRow {
  std::string name;                  ///< "five_sensors": as --rows and JSON have it.
  std::string group;                 ///< "sensors", "data", "networks", "windows".
  std::string title;                 ///< For people.
  std::vector<std::string> sensors;  ///< That the network reads, by name.
  /// One in so many of the virtual performers, 1 or more; as many seeds learn from others of them, further
  /// ones from the same again.
  std::size_t one_in = 1;
  LearnsFrom learns_from = LearnsFrom::performers;
  ShortNetwork network = ShortNetwork::recurrent;
  std::size_t window = 120;
  double difference_weight = 5;  ///< As ShortRecipe's.
  synthetic::WindowJoin join = synthetic::WindowJoin::overlap;
};

/// The row that all others are compared with.
inline constexpr std::string_view kAblationBase = "base";

/// All rows that a rig has sensors enough for, the base first. `stand_ins`: no takes of people are at hand,
/// so titles say that virtual ones stand in. Of the default rig: the paper's five sensors (two at the
/// eyebrows, one at the jaw, two at the cheeks), each region of muscles left out, one side; a third and a
/// tenth of the people; takes alone and with virtual performers; other networks; other windows.
[[nodiscard]] std::vector<AblationRow> ablation_rows(const sensor::Rig& rig, bool stand_ins);

/// The base and those of these names, in the table's order; all where no name is given. Errors: not_found,
/// with the nearest name.
[[nodiscard]] Result<std::vector<AblationRow>> chosen_rows(const sensor::Rig& rig, bool stand_ins,
                                                           std::span<const std::string> names);

}  // namespace mien::lab
