#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/face.h"
#include "mien/render/image.h"

namespace mien::lab {

/// One who says how the face was: the truth, or an answer.
struct MomentRow {
  std::string name;  ///< Printable ASCII, as all that is written on pictures.
  std::vector<std::optional<face::BlendshapeWeights>>
      weights;  ///< Beside the captions. None, or not finite: not seen.
};

/// Moments beside each other, a column each beneath its caption, a row for each who says how the face was,
/// seen from the front; where one did not see it, a pale cell says so. `cell_px`: a cell's width and height,
/// 64 to 640. Words that are too long are written smaller. Errors: bad_usage (no row, no moment, a row of
/// another number of moments, a cell or a picture of another size than PNG files of ours have); those of
/// render::Lettering::load(). Cost: a still a cell (render::Renderer).
[[nodiscard]] Result<render::Image> moments_strip(const face::Face& face, std::span<const MomentRow> rows,
                                                  std::span<const std::string> captions, int cell_px);

}  // namespace mien::lab
