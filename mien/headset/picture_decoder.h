#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>
#include <span>

#include "mien/core/error.h"
#include "mien/headset/grey_picture.h"
#include "mien/headset/jpeg_gate.h"

namespace mien::headset {

/// Decodes pictures of cameras (libjpeg-turbo) in grey, made smaller while they are decoded. What its gate
/// (jpeg_gate.h) lets through and does not decode without a complaint of libjpeg is refused as damaged. The
/// same picture gives the same bits, whichever came before. No allocation after construction but libjpeg's
/// own. Thread: one at a time.
class PictureDecoder {
 public:
  /// Errors: internal (libjpeg gives no decoder).
  [[nodiscard]] static Result<PictureDecoder> create();

  /// The picture at an eighth, a quarter or half of its size, rounded up, or its own: at the smallest that is
  /// at least so wide and so high; where none is, at its own. Valid until the next call.
  [[nodiscard]] std::expected<GreyPicture, PictureFault> decode(std::span<const std::byte> jpeg,
                                                                int least_width, int least_height);

 private:
  struct Close {
    void operator()(void* decoder) const;
  };
  explicit PictureDecoder(void* decoder);

  std::unique_ptr<void, Close> decoder_;
  std::unique_ptr<std::uint8_t[]> pixels_;  // Of the largest picture; touched as far as one needs.
};

}  // namespace mien::headset
