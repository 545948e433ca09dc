#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"

namespace mien::sink {

/// What an avatar of VRChat takes: its OSC configuration, which VRChat writes beside its own files when the
/// avatar is worn for the first time (docs/reference/sinks.md says where).
struct VrchatAvatar {
  enum class Type { real, whole, truth };  ///< VRChat's Float, Int, Bool.
  struct Parameter {
    std::string address;  ///< Where to send it: "/avatar/parameters/FT/v2/JawOpen".
    Type type = Type::real;
    bool operator==(const Parameter&) const = default;
  };
  std::string id;                     ///< "avtr_..."
  std::string name;                   ///< For people.
  std::vector<Parameter> parameters;  ///< Those with an input, in the file's order.
};

/// Most parameters of an avatar that are read; VRChat itself stops at a few hundred.
inline constexpr std::size_t kMaxAvatarParameters = 4096;

/// Reads such a file. Parameters without an input are left out, members that are not known are ignored.
/// Errors: malformed (no JSON object, no list of parameters, an input without address or type, control
/// characters or blanks in an address); unsupported (another type); out_of_range (too many parameters, an
/// address longer than 512 bytes, depth of nesting over 64). `where` is what errors call the file.
[[nodiscard]] Result<VrchatAvatar> parse_vrchat_avatar(std::string_view json, std::string_view where);

}  // namespace mien::sink
