#pragma once

#include <span>
#include <string>
#include <vector>

#include "lab/eyewear/marker_errors.h"
#include "mien/builtin_face/markers.h"
#include "mien/core/error.h"
#include "mien/render/image.h"

namespace mien::lab {

/// Markers' errors as colour on the built-in face, a face each method beside the other: between markers what
/// lies between, pale where no marker is near. The ramp ends at `full_scale_mm`. Errors: mismatch (a method
/// of other markers); those of render::Lettering::load(). Cost: some seconds.
[[nodiscard]] Result<render::Image> error_picture(const builtin_face::MarkerSet& markers,
                                                  std::span<const SensorsMethod* const> methods,
                                                  double full_scale_mm, int height = 480);

}  // namespace mien::lab
