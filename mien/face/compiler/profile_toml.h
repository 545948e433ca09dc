#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/profile_map.h"

namespace mien::face {

/// What one shape of a profile is of ours.
struct ProfileRow {
  std::vector<ProfileTerm>
      gains;                    ///< Of inner shapes, ascending; finite and above 0. Its weight is their mean.
  std::optional<double> share;  ///< Of its inner shape on the way back, 0 to 1; unless told, an equal part.
  std::string reason;           ///< Why it has no counterpart; empty where it has one.
};

/// A file of profiles/, read and held against the names that there are on both sides.
struct ProfileTable {
  const NamedShapes* names = nullptr;
  std::string title;
  std::string source;
  std::vector<ProfileRow> rows;                ///< In the profile's order.
  std::array<std::string, kInnerCount> lacks;  ///< Why an inner shape is not told; empty where it is.
};

/// Reads a table (docs/reference/profiles.md). Each shape of the profile has a row or a reason, each inner
/// one is told or has a reason, none both. `earlier` are the tables that it may extend. Errors: malformed (a
/// name that there is not, with the nearest; twice; a missing gain, row or reason; an unknown key),
/// out_of_range (a gain that is not finite or not above 0, shares that do not sum to 1). All with the line,
/// where it is one line's; `where` names the source.
[[nodiscard]] Result<ProfileTable> parse_profile(std::string_view toml, const std::string& where,
                                                 std::span<const ProfileTable> earlier = {});

/// A matrix by rows, as SparseRows has it.
struct SparseRowsData {
  std::vector<std::uint16_t> first = {0};
  std::vector<ProfileTerm> terms;
};
/// A row a shape of the profile: the mean of its gains times inner shapes.
[[nodiscard]] SparseRowsData outward_rows(const ProfileTable& table);
/// A row an inner shape: of each shape of the profile that it became, its share over its gain.
[[nodiscard]] SparseRowsData inward_rows(const ProfileTable& table);

}  // namespace mien::face
