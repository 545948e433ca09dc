#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "mien/sink/arkit_frame.h"
#include "mien/sink/datagrams.h"

namespace mien::sink {

/// How name and value are set apart: `-` in version 1, `&` in version 2.
enum class IFacialMocapVersion { v1, v2 };

/// What a receiver asks of a phone.
enum class IFacialMocapRequest {
  v1,        ///< Send version 1 by UDP.
  v2,        ///< Send version 2 by UDP.
  tcp,       ///< Send by TCP: not done here.
  tcp_stop,  ///< No more by TCP.
};

/// Reads a request; a line end or NULs behind it are survived. None for anything else, of any length.
/// No allocation.
[[nodiscard]] std::optional<IFacialMocapRequest> parse_ifacialmocap_request(std::span<const std::byte> bytes);

/// One frame as text in one datagram: the 52 shapes in whole percent under their names with _L and _R, then
/// head, right eye and left eye in degrees: turns about X, Y, Z of axes with +X to the performer's left, +Y
/// up and +Z forward (so X is positive down, Y positive to the performer's left), taken apart as Y X Z. For
/// the eyes these signs are those of the vendor's sample line, whose angles agree with its eyeLook weights;
/// for the head they are UNVERIFIED. The head's position is in m, by the same axes (UNVERIFIED), and 0 where
/// it is not known. Version 2 begins with `trackingStatus&1`, as phones do. Allocates only while `out` grows.
/// Layout: docs/reference/sinks.md.
void encode_ifacialmocap(const ArkitFrame& frame, IFacialMocapVersion version, Datagrams& out);

}  // namespace mien::sink
