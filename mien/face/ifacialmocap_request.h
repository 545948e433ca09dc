#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace mien::face {

/// Where phones with iFacialMocap listen for requests, and to which port of who asks they send their frames.
inline constexpr std::uint16_t kIFacialMocapPort = 49983;

/// A request is these in this order: in version 2 all, in version 1 the first two.
inline constexpr std::string_view kIFacialMocapAsks = "iFacialMocap_";
inline constexpr std::string_view kIFacialMocapSecret = "sahuasouryya9218sauhuiayeta91555dy3719";
inline constexpr std::string_view kIFacialMocapAsksV2 = "|sendDataVersion=v2";

/// What asks a phone to send frames of version 2 from then on.
[[nodiscard]] inline std::string ifacialmocap_request() {
  return std::string(kIFacialMocapAsks).append(kIFacialMocapSecret).append(kIFacialMocapAsksV2);
}

}  // namespace mien::face
