#pragma once

#include <array>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>

#include "mien/core/error.h"

namespace mien::virt {

/// Between what a magnitude is held.
struct FaultLimit {
  std::string_view key;
  double value = 0, least = 0, most = 0;
};
/// Errors: out_of_range, of the first that is beyond its limits. `where` names the source.
[[nodiscard]] Result<void> check_limits(std::initializer_list<FaultLimit> limits, const std::string& where);

/// Where the magnitudes of a rig file's [faults] table go, by their keys: numbers, pairs of a least and a
/// most, and switches. A key that the table lacks keeps its value.
struct FaultTable {
  std::map<std::string_view, double*> numbers;
  std::map<std::string_view, std::array<double, 2>*> ranges;
  std::map<std::string_view, bool*> switches;

  /// Errors: malformed (TOML, unknown keys, values of another type); out_of_range (a number that is not
  /// finite, negative or above 1e6, a range whose most is less than its least). `where` names the source.
  [[nodiscard]] Result<void> read(std::string_view toml, const std::string& where) const;
};

}  // namespace mien::virt
