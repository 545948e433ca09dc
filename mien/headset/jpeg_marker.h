#pragma once

#include <cstddef>

// The bytes behind FF that this room knows of a JPEG (ITU-T T.81, table B.1).
namespace mien::headset::jpeg {

inline constexpr std::byte kMark{0xFF};
inline constexpr std::byte kStuffed{0x00};  ///< In coded data: a byte FF of them, and no marker.
inline constexpr std::byte kStartOfPicture{0xD8};
inline constexpr std::byte kEndOfPicture{0xD9};
inline constexpr std::byte kStartOfScan{0xDA};
inline constexpr std::byte kBaseline{0xC0};
inline constexpr std::byte kExtended{0xC1};
inline constexpr std::byte kProgressive{0xC2};
inline constexpr std::byte kLossless{0xC3};
inline constexpr std::byte kLastOfFrames{0xCF};
inline constexpr std::byte kHuffmanTables{0xC4};
inline constexpr std::byte kReserved{0xC8};
inline constexpr std::byte kArithmeticFrames{0xC9};  ///< And all frames after it.
inline constexpr std::byte kArithmeticConditions{0xCC};
inline constexpr std::byte kQuantisation{0xDB};
inline constexpr std::byte kHierarchy{0xDE};

/// RST0 to RST7: they stand in coded data, and have no length.
[[nodiscard]] constexpr bool is_restart(std::byte code) {
  return (code & std::byte{0xF8}) == std::byte{0xD0};
}
/// Those that have a length and so many bytes behind them; less would be reserved.
[[nodiscard]] constexpr bool has_length(std::byte code) {
  return code >= kBaseline && code != kMark && code != kStartOfPicture && code != kEndOfPicture &&
         !is_restart(code);
}

}  // namespace mien::headset::jpeg
