#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

#include "mien/core/error.h"

namespace mien::virt {

/// Between what a magnitude is held, of a pair both ends.
struct FaultLimit {
  std::string_view key;
  double least = 0, most = 0;
};

/// Reads a rig file's [faults] table onto magnitudes by their keys: numbers, pairs of a least and a most, and
/// switches. A key that the table lacks keeps its value. Errors: malformed (TOML, unknown keys, values of
/// another type); out_of_range (a number that is not finite, negative, above 1e6 or beyond its limits, a
/// range whose most is less than its least). `where` names the source.
[[nodiscard]] Result<void> read_fault_table(nlohmann::json& magnitudes, std::string_view toml,
                                            const std::string& where, std::span<const FaultLimit> limits);

/// The same onto the defaults of a struct that NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE lists: members of the types
/// double, std::array<double, 2> and bool.
template <class Faults>
[[nodiscard]] Result<Faults> parse_fault_table(std::string_view toml, const std::string& where,
                                               std::span<const FaultLimit> limits) {
  nlohmann::json magnitudes = Faults();
  MIEN_TRY(read_fault_table(magnitudes, toml, where, limits));
  return magnitudes.get<Faults>();
}

}  // namespace mien::virt
