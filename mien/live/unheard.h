#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "mien/core/time.h"
#include "mien/sensor/rig.h"
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

/// A microphone on the network that a session wants to hear and never hears, in words for a person, once. A
/// pure function of its calls.
class UnheardMicrophone {
 public:
  /// One that is on has been heard by then.
  static constexpr Duration kPatience = std::chrono::seconds(10);

  /// `name`: in the rig; empty: there is none.
  explicit UnheardMicrophone(std::string name) : name_(std::move(name)) {}

  /// What is to be said now, or nothing: while the session has no frame unheard_text() says why. From time to
  /// time, `now` never runs back. `report`: of a session of this rig.
  [[nodiscard]] std::optional<std::string> tell(HostTime now, const sensor::Rig& rig,
                                                const session::Report& report);

 private:
  std::string name_;
  std::optional<HostTime> wanted_since_;
  bool over_ = false;  // It was heard, or told of.
};

}  // namespace mien::live
