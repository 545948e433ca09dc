#include "mien/headset/view_maker.h"

#include <algorithm>
#include <utility>

#include "mien/headset/picture_statistics.h"

namespace mien::headset {

Result<ViewMaker> ViewMaker::create() {
  MIEN_TRY_ASSIGN(PictureDecoder decoder, PictureDecoder::create());
  return ViewMaker(std::move(decoder));
}

bool ViewMaker::make(std::span<const std::byte> jpeg, const NetworkViewSettings& settings,
                     std::span<std::uint8_t> pixels) {
  if (!view_ || view_->settings() != settings) {
    auto view = NetworkView::create(settings);
    if (!view) return false;
    view_ = *std::move(view);
  }
  // At the size at which FeatureReducer has it, so that the two see the same.
  const auto [width, height] = least_size(settings);
  const auto picture = decoder_.decode(jpeg, std::max(kMeasuredSide, width), std::max(kMeasuredSide, height));
  if (!picture) return false;
  view_->make(*picture, pixels);
  return true;
}

}  // namespace mien::headset
