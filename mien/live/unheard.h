#pragma once

#include <cstdint>
#include <string>

#include "mien/session/report.h"

namespace mien::live {

/// Why a session that has no frame has none: what became of what came in.
enum class Unheard : std::uint8_t {
  silence,       ///< Nothing came.
  elsewhere,     ///< Most came in by an interface or address that the session does not listen on.
  not_sealed,    ///< Not sealed with the session's key.
  not_opened,    ///< The session has no key, and they are sealed, or of a version that it does not know.
  unreadable,    ///< No packets of any device that is known.
  no_reference,  ///< Sound packets, but no frame of the rig's reference sensor.
};

struct Arrivals {
  std::uint64_t received = 0;   ///< Datagrams.
  std::uint64_t elsewhere = 0;  ///< Of these.
  bool sealed = false;          ///< The session has a key.
};

/// `report`: of a session without a frame.
[[nodiscard]] Unheard why_unheard(const Arrivals& arrivals, const session::Report& report);

/// What a session that ought to have heard something by then says of it: one line with the way out.
[[nodiscard]] std::string unheard_text(Unheard why);

}  // namespace mien::live
