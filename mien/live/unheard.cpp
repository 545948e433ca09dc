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

std::string unheard_text(Unheard why) {
  switch (why) {
    case Unheard::silence:
      return "nothing is received yet: are the devices on, and do they send here?";
    case Unheard::elsewhere:
      return "packets come, but by an interface or address that is excluded: listen on every interface, or "
             "on the one that the devices send to";
    case Unheard::not_sealed:
      return "packets come that are not sealed with this session's key: pair the devices, or leave --key out";
    case Unheard::not_opened:
      return "packets come that are sealed with a key which this session was not given, or newer than this "
             "program: give the key with --key, or update the program";
    case Unheard::unreadable:
      return "packets come, but none that can be read: see that what sends here is a device that "
             "docs/guide/devices.md names";
    case Unheard::no_reference:
      break;
  }
  return "packets come, but no frame of the rig's reference sensor yet; the page's sensors and "
         "docs/reference/links.md say why";
}

}  // namespace mien::live
