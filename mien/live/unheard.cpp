#include "mien/live/unheard.h"

#include <fmt/format.h>

#include <algorithm>

namespace mien::live {

Unheard why_unheard(const Arrivals& arrivals, const session::Report& report) {
  if (arrivals.received == 0) return Unheard::silence;
  if (2 * arrivals.elsewhere > arrivals.received) return Unheard::elsewhere;
  // What is refused and unreadable is the reason only where nothing sound came beside it.
  const bool sound = !report.unbound.empty() || std::ranges::any_of(report.links, [](const auto& link) {
    return link.health.age.has_value();
  });
  std::uint64_t of_others = 0;
  for (const session::Report::UnknownVersion& packets : report.unknown_versions) of_others += packets.count;
  if (!sound && of_others > 0 && 2 * of_others >= report.refused + report.malformed)
    return Unheard::other_version;
  if (!sound && report.refused > 0) return arrivals.sealed ? Unheard::not_sealed : Unheard::not_opened;
  if (!sound && report.malformed > 0) return Unheard::unreadable;
  return Unheard::no_reference;
}

std::string unknown_version_text(const session::Report::UnknownVersion& packets) {
  return fmt::format(
      "{} sends {} packets of version {}, which this program does not know: update this program, or what "
      "sends there",
      packets.source.empty() ? "somebody" : packets.source, packets.protocol, packets.version);
}

std::string unheard_text(Unheard why, const session::Report& report) {
  switch (why) {
    case Unheard::silence:
      return "nothing is received yet: are the devices on, and do they send here?";
    case Unheard::elsewhere:
      return "packets come, but by an interface or address that is excluded: listen on every interface, or "
             "on the one that the devices send to";
    case Unheard::not_sealed:
      return "packets come that are not sealed with this session's key: pair the devices, or leave --key out";
    case Unheard::other_version: {
      // Of those that came most.
      const auto most =
          std::ranges::max_element(report.unknown_versions, {}, &session::Report::UnknownVersion::count);
      if (most != report.unknown_versions.end()) return unknown_version_text(*most);
      break;
    }
    case Unheard::not_opened:
      return "packets come that are sealed with a key which this session was not given: give the key with "
             "--key";
    case Unheard::unreadable:
      return "packets come, but none that can be read: see that what sends here is a device that "
             "docs/guide/devices.md names";
    case Unheard::no_reference:
      break;
  }
  return "packets come, but no frame of the rig's reference sensor yet; the page's sensors and "
         "docs/reference/links.md say why";
}

std::optional<std::string> UnheardMicrophone::tell(HostTime now, const sensor::Rig& rig,
                                                   const session::Report& report) {
  const auto sensor = rig.find(name_);
  if (over_ || !sensor || *sensor >= report.links.size()) return std::nullopt;
  const session::Report::Link& link = report.links[*sensor];
  over_ = link.health.age.has_value();
  const bool wanted = report.frames > 0 && report.hearing && report.hearing->on && !link.device.empty();
  if (over_ || !wanted) {
    wanted_since_.reset();
    return std::nullopt;
  }
  if (!wanted_since_) wanted_since_ = now;
  if (now - *wanted_since_ < kPatience) return std::nullopt;
  over_ = true;
  return fmt::format(
      "nothing comes from the microphone '{}' yet: is it on, and does it send here as {}, "
      "the device that it is bound to?",
      name_, link.device);
}

}  // namespace mien::live
