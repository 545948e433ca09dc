#pragma once

#include <cstddef>
#include <span>

#include "mien/core/error.h"
#include "mien/phone/told_face.h"

namespace mien::phone {

/// Longest frame that is read, bytes: twice what phones send.
inline constexpr std::size_t kMostIFacialMocapBytes = 2048;

/// What iFacialMocap, or who speaks as it does, says of one moment. Layout: docs/reference/phones.md.
struct IFacialMocapFrame {
  bool tracked = true;  ///< False: the phone says that it sees no face.
  ToldFace face;        ///< In ARKit's 52; sound; what was not told is kUntold.
};

/// Whether the bytes begin like a frame: a name, then `&` or `-` and a number, or `=head#`; checks no more.
[[nodiscard]] bool is_ifacialmocap(std::span<const std::byte> bytes);

/// Either version: `-` before a number is the first's, `&` the second's, and both may have decimals. Weights
/// are percent and held to 0 to 1; what names none of ARKit's is passed over, of one that stands there
/// twice the last counts. The head's turn is of degrees about X, Y, Z as sink::encode_ifacialmocap sends it,
/// its position m; where that is 0, 0, 0 it is not known. Eyes are told by the eyeLook shapes. Errors:
/// out_of_range (longer than kMostIFacialMocapBytes; a number that is not finite or beyond its range);
/// malformed (a head of other than six numbers; nothing told). No allocation but in errors. Thread-safe.
[[nodiscard]] Result<IFacialMocapFrame> parse_ifacialmocap(std::span<const std::byte> bytes);

}  // namespace mien::phone
