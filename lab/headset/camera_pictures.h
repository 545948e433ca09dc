#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/virtual/headset/headset_simulator.h"

namespace mien::lab {

/// Room for one grey picture of each camera of a simulator, which it shoots into.
struct CameraPictures {
  explicit CameraPictures(const virt::HeadsetSimulator& simulator) {
    for (std::size_t c = 0; c < simulator.cameras(); ++c)
      pixels.emplace_back(static_cast<std::size_t>(simulator.size(c).width) *
                          static_cast<std::size_t>(simulator.size(c).height));
    for (auto& picture : pixels) out.emplace_back(picture);
  }
  std::vector<std::vector<std::uint8_t>> pixels;
  std::vector<std::span<std::uint8_t>> out;  ///< Of `pixels`.
};

}  // namespace mien::lab
