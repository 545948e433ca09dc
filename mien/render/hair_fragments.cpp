#include "mien/render/hair_fragments.h"

#include <algorithm>
#include <array>

namespace mien::render {

void TileHair::clear() {
  fragment_.clear();
  start_.clear();
  is_sorted_ = false;
}

void TileHair::sort() {
  is_sorted_ = true;
  if (fragment_.empty()) return;
  // Those of one depth stay as they were added, so that the order does not depend on the library.
  std::ranges::stable_sort(fragment_, [](const HairFragment& a, const HairFragment& b) {
    return a.pixel != b.pixel ? a.pixel < b.pixel : a.inverse_depth > b.inverse_depth;
  });
  start_.assign(kTilePixels + 1, 0);
  std::size_t kept = 0, at = 0;
  for (std::size_t pixel = 0; pixel < kTilePixels; ++pixel) {
    start_[pixel] = static_cast<std::uint32_t>(kept);
    std::array<float, kSamples> through;
    through.fill(1);
    for (; at < fragment_.size() && fragment_[at].pixel == pixel; ++at) {
      const HairFragment fragment = fragment_[at];
      float most = 0;
      for (std::size_t s = 0; s < kSamples; ++s) {
        if ((fragment.samples >> s & 1U) == 0) continue;
        most = std::max(most, through[s]);
        through[s] *= 1 - fragment.cover;
      }
      if (most >= kOpaque) fragment_[kept++] = fragment;
    }
  }
  start_[kTilePixels] = static_cast<std::uint32_t>(kept);
  fragment_.resize(kept);
}

}  // namespace mien::render
