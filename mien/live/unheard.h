#pragma once

#include <cstdint>
#include <string>

#include "mien/session/report.h"

namespace mien::live {

/// Why a session that has no frame has none: what became of what came in.
enum class Unheard : std::uint8_t {
  silence,        ///< Nothing came.
  elsewhere,      ///< Most came in by an interface or address that the session does not listen on.
  not_sealed,     ///< Not sealed with the session's key.
  other_version,  ///< Half or more of what could not be read is of versions that are not known.
  not_opened,     ///< The session has no key, and they are sealed.
  unreadable,     ///< No packets of any device that is known.
  no_reference,   ///< Sound packets, but no frame of the rig's reference sensor.
};

struct Arrivals {
  std::uint64_t received = 0;   ///< Datagrams.
  std::uint64_t elsewhere = 0;  ///< Of these.
  bool sealed = false;          ///< The session has a key.
};

/// `report`: of a session without a frame.
[[nodiscard]] Unheard why_unheard(const Arrivals& arrivals, const session::Report& report);

/// What a session that ought to have heard something by then says of it: one line with the way out. `report`:
/// as above.
[[nodiscard]] std::string unheard_text(Unheard why, const session::Report& report);

/// What a session says of the first packets of a version that is unknown: one line.
[[nodiscard]] std::string unknown_version_text(const session::Report::UnknownVersion& packets);

}  // namespace mien::live
