#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "mien/core/error.h"
#include "mien/headset/network_view.h"
#include "mien/headset/picture_decoder.h"

namespace mien::headset {

/// Makes of a camera's picture the view that a network has of it, for people to look at. Thread: one at a
/// time.
class ViewMaker {
 public:
  /// Errors: PictureDecoder::create's.
  [[nodiscard]] static Result<ViewMaker> create();

  /// `pixels`: side x side grey levels. False, and they may be anything: the picture does not decode, or
  /// there is no such view.
  [[nodiscard]] bool make(std::span<const std::byte> jpeg, const NetworkViewSettings& settings,
                          std::span<std::uint8_t> pixels);

 private:
  explicit ViewMaker(PictureDecoder decoder) : decoder_(std::move(decoder)) {}

  PictureDecoder decoder_;
  std::optional<NetworkView> view_;  // The last that was wanted.
};

}  // namespace mien::headset
