#pragma once

#include <span>
#include <string>

#include "mien/render/lettering.h"
#include "mien/render/renderer.h"

namespace mien::render {

/// Distance between the same vertices of two poses, metres. Shape: all three equal.
void vertex_errors(std::span<const Vec3f> truth_m, std::span<const Vec3f> capture_m,
                   std::span<float> error_m);

/// Words on a comparison; printable ASCII.
struct ComparisonCaptions {
  std::string truth = "Truth";
  std::string capture = "Capture";
  std::string error = "Error";
  std::string footer;  ///< One line at the top right, such as the time; may be empty.
};

/// One picture of three: the truth, the capture, and the capture painted with its error in millimetres.
/// `camera` is that of each; the result is three times as wide. Cost: less than three stills, since the last
/// two show one pose.
[[nodiscard]] Image comparison(Renderer& renderer, const Lettering& lettering, std::span<const Vec3f> truth_m,
                               std::span<const Vec3f> capture_m, const Camera& camera, const Look& look,
                               const ComparisonCaptions& captions, float full_scale_m = 5e-3F);

}  // namespace mien::render
