#include "mien/live/unheard.h"

#include <algorithm>

namespace mien::live {

Unheard why_unheard(const Arrivals& arrivals, const session::Report& report) {
  if (arrivals.received == 0) return Unheard::silence;
  if (2 * arrivals.elsewhere > arrivals.received) return Unheard::elsewhere;
  // What is refused and unreadable is the reason only where nothing sound came beside it.
  const bool sound = !report.unbound.empty() || std::ranges::any_of(report.links, [](const auto& link) {
    return link.health.age.has_value();
  });
  if (!sound && report.refused > 0) return arrivals.sealed ? Unheard::not_sealed : Unheard::not_opened;
  if (!sound && report.malformed > 0) return Unheard::unreadable;
  return Unheard::no_reference;
}

}  // namespace mien::live
