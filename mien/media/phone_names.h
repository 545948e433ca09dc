#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace mien::media {

/// How makers of voices name phones.
enum class PhoneSet : std::uint8_t {
  english,      ///< ARPAbet in lower case, of flite and festival: "ae".
  continental,  ///< Of festival's Italian (SAMPA), Czech and Finnish voices: "tS", "s~", "a:"; "a1" is
                ///< stressed.
  russian,      ///< Of festival's Russian voice: "pp" is a soft p.
};

/// The phone in IPA; empty for pauses and names that are none.
[[nodiscard]] std::string ipa_of(PhoneSet set, std::string_view phone);

}  // namespace mien::media
