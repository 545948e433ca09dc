#include "mien/render/comparison.h"

#include <cassert>
#include <vector>

#include "mien/render/error_colours.h"

namespace mien::render {

void vertex_errors(std::span<const Vec3f> truth_m, std::span<const Vec3f> capture_m,
                   std::span<float> error_m) {
  assert(truth_m.size() == capture_m.size() && truth_m.size() == error_m.size());
  for (std::size_t i = 0; i < error_m.size(); ++i) error_m[i] = (truth_m[i] - capture_m[i]).norm();
}

Image comparison(Renderer& renderer, const Lettering& lettering, std::span<const Vec3f> truth_m,
                 std::span<const Vec3f> capture_m, const Camera& camera, const Look& look,
                 const ComparisonCaptions& captions, float full_scale_m) {
  std::vector<float> error_m(truth_m.size());
  vertex_errors(truth_m, capture_m, error_m);
  const ErrorColours colours{error_m, full_scale_m};

  Image picture(3 * camera.width, camera.height);
  paste(picture, renderer.still(truth_m, camera, look), 0, 0);
  renderer.light(capture_m, camera, look);
  Renderer::Pictures captured = renderer.draw_with_errors(colours);
  paste(picture, captured.plain, camera.width, 0);
  const Rgb ink = look.background_top[0] > 128 ? Rgb{40, 42, 48} : Rgb{226, 229, 236};
  draw_error_legend(captured.errors, lettering, full_scale_m, ink);
  paste(picture, captured.errors, 2 * camera.width, 0);

  const float size = std::max(12.0F, 0.042F * static_cast<float>(camera.height));
  const auto left = [&](int column) {
    return static_cast<float>(column) * static_cast<float>(camera.width) + 0.6F * size;
  };
  lettering.draw(picture, captions.truth, left(0), 1.3F * size, size, ink);
  lettering.draw(picture, captions.capture, left(1), 1.3F * size, size, ink);
  lettering.draw(picture, captions.error, left(2), 1.3F * size, size, ink);
  lettering.draw(picture, captions.footer, static_cast<float>(picture.width) - 0.6F * size, 1.3F * size,
                 0.7F * size, ink, Align::right);
  return picture;
}

}  // namespace mien::render
