#pragma once

namespace mien::lab {

/// Makes these members of a set of faults so many times as large: for tables of what is worsened.
template <int kTimes, auto... kMembers>
inline constexpr auto worsened = [](auto& faults) { ((faults.*kMembers *= kTimes), ...); };

}  // namespace mien::lab
