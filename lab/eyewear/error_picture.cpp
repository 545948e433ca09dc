#include "lab/eyewear/error_picture.h"

#include "lab/spread_on_skin.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/core/units.h"
#include "mien/render/camera.h"
#include "mien/render/error_colours.h"
#include "mien/render/lettering.h"
#include "mien/render/renderer.h"

namespace mien::lab {
namespace {

constexpr render::Rgb kInk = {40, 42, 48};

/// Error of each vertex, metres.
std::vector<float> vertex_errors_m(const face::Face& face, const std::vector<Vec3>& markers_m,
                                   const std::vector<MarkerError>& errors) {
  std::vector<double> error_m;
  for (const MarkerError& error : errors) error_m.push_back(error.mean_mm / kMmPerM);
  return spread_on_skin(face, markers_m, error_m);
}

}  // namespace

Result<render::Image> error_picture(const builtin_face::MarkerSet& markers,
                                    std::span<const SensorsMethod* const> methods, double full_scale_mm,
                                    int height) {
  const face::Face face = builtin_face::make_builtin();
  MIEN_TRY_ASSIGN(const builtin_face::PlacedMarkers placed,
                  builtin_face::PlacedMarkers::place(face, markers));
  const render::Look look = render::Look::light();
  const render::Camera camera =
      render::portrait_camera(face, render::kThreeQuarterView_rad, height, height, 1.3F);
  MIEN_TRY_ASSIGN(const auto lettering, render::Lettering::load());
  render::Renderer renderer(face);
  render::Image picture(static_cast<int>(methods.size()) * height, height);
  const float size = 0.04F * static_cast<float>(height);
  for (std::size_t i = 0; i < methods.size(); ++i) {
    if (methods[i]->markers.size() != placed.count())
      return fail(ErrorCode::mismatch, "a method has errors of other markers", methods[i]->name);
    const std::vector<float> error_m = vertex_errors_m(face, placed.neutral_m(), methods[i]->markers);
    const render::ErrorColours colours{error_m, static_cast<float>(full_scale_mm / kMmPerM)};
    render::Image one = renderer.still(face.neutral_m, camera, look, &colours);
    render::draw_error_legend(one, lettering, colours.full_scale_m, kInk);
    lettering.draw(one, methods[i]->name, 0.6F * size, 1.5F * size, size, kInk);
    render::paste(picture, one, static_cast<int>(i) * height, 0);
  }
  return picture;
}

}  // namespace mien::lab
