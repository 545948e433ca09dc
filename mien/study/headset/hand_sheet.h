#pragma once

#include <string>

#include "mien/core/error.h"
#include "mien/face/face.h"
#include "mien/render/image.h"
#include "mien/study/headset/hand_study.h"

namespace mien::study {

/// Moments before, under and after the hand, a column each: what the network sees of one mouth camera, the
/// face as it was, and as it was shown without a microphone and with one. `font`: a file to write headings
/// with; empty: no headings. Errors: bad_usage (no moments), the font's.
[[nodiscard]] Result<render::Image> hand_sheet(const HandPerson& person, double hand_s,
                                               const face::Face& face, const std::string& font);

}  // namespace mien::study
