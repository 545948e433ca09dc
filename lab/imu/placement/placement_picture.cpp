#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "lab/imu/placement/placement_bound.h"
#include "lab/imu/placement/placement_study.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/render/camera.h"
#include "mien/render/error_colours.h"
#include "mien/render/lettering.h"
#include "mien/render/ray_scene.h"
#include "mien/render/renderer.h"
#include "mien/render/tone.h"

namespace mien::lab {
namespace {

constexpr render::Rgb kPlacementInk = {40, 42, 48};
constexpr render::Rgb kDotFill = {255, 255, 255};
constexpr float kPlacementCloseness = 1.3F;
constexpr float kLookLowerM = 0.024F;  // From the chin to the hairline; hair tells nothing.

/// Values of points on the skin, `spacing_m` apart, as values of the neutral face's vertices: the points' by
/// the fourth power of how near they are; skin farther than two spacings from every point keeps 0. Shape:
/// `values` beside `points_m`, at least one; the result beside the vertices.
std::vector<float> spread_on_skin(const face::Face& face, const std::vector<Vec3>& points_m,
                                  std::span<const double> values, double spacing_m) {
  const double reach_m = 2 * spacing_m;
  const double sharp_m = 0.4 * spacing_m;  // Nearer than this a point is all that counts.
  std::vector<float> out;
  out.reserve(face.neutral_m.size());
  for (const Vec3f& vertex : face.neutral_m) {
    double sum = 0, weights = 0, nearest_m = reach_m;
    for (std::size_t i = 0; i < points_m.size(); ++i) {
      const double square = (vertex.cast<double>() - points_m[i]).squaredNorm();
      const double near = square + sharp_m * sharp_m;
      const double weight = 1 / (near * near);
      sum += weight * values[i];
      weights += weight;
      nearest_m = std::min(nearest_m, std::sqrt(square));
    }
    const double fade = std::clamp((reach_m - nearest_m) / spacing_m, 0.0, 1.0);
    out.push_back(static_cast<float>(fade * sum / weights));
  }
  return out;
}

/// Where on the picture a point is, pixels.
Eigen::Vector2f project(const render::Camera& camera, const Vec3f& p_m) {
  const Vec3f forward = (camera.target_m - camera.position_m).normalized();
  const Vec3f right = forward.cross(camera.up).normalized();
  const Vec3f up = right.cross(forward);
  const Vec3f from = p_m - camera.position_m;
  const float scale = 0.5F * static_cast<float>(camera.height) / std::tan(0.5F * camera.field_of_view_rad) /
                      from.dot(forward);
  return {0.5F * static_cast<float>(camera.width) + scale * from.dot(right),
          0.5F * static_cast<float>(camera.height) - scale * from.dot(up)};
}

void draw_disc(render::Image& picture, const Eigen::Vector2f& centre, float radius, render::Rgb fill) {
  const int left = std::max(0, static_cast<int>(centre.x() - radius - 1));
  const int right = std::min(picture.width - 1, static_cast<int>(centre.x() + radius + 1));
  const int top = std::max(0, static_cast<int>(centre.y() - radius - 1));
  const int bottom = std::min(picture.height - 1, static_cast<int>(centre.y() + radius + 1));
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x) {
      const Eigen::Vector2f at(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
      const float cover = std::clamp(radius - (at - centre).norm() + 0.5F, 0.0F, 1.0F);
      for (std::size_t c = 0; c < 3; ++c) {
        std::uint8_t& value = picture.pixel(x, y)[c];
        value = static_cast<std::uint8_t>(static_cast<float>(value) +
                                          cover * (static_cast<float>(fill[c]) - static_cast<float>(value)) +
                                          0.5F);
      }
    }
}

/// The ramp of colours with shares below it.
void draw_share_legend(render::Image& picture, const render::Lettering& lettering, double full_scale) {
  const float size = std::max(11.0F, 0.026F * static_cast<float>(picture.height));
  const int width = picture.width * 5 / 10, left = (picture.width - width) / 2;
  const int bar = std::max(5, static_cast<int>(0.55F * size));
  const int top = picture.height - bar - static_cast<int>(2.1F * size);
  for (int x = 0; x < width; ++x) {
    const render::Rgb colour =
        render::to_srgb(render::error_colour(static_cast<float>(x) / static_cast<float>(width - 1)));
    for (int y = std::max(0, top); y < top + bar; ++y)
      std::copy(colour.begin(), colour.end(), picture.pixel(left + x, y));
  }
  const float baseline = static_cast<float>(top + bar) + 1.2F * size;
  lettering.draw(picture, "0", static_cast<float>(left), baseline, size, kPlacementInk,
                 render::Align::centre);
  lettering.draw(picture, fmt::format("{:.3g} % less", 100 * full_scale), static_cast<float>(left + width),
                 baseline, size, kPlacementInk, render::Align::centre);
}

/// The built-in face from one side.
class PlacementView {
 public:
  PlacementView(const face::Face& face, float view_rad, int size_px)
      : camera_(render::portrait_camera(face, view_rad, size_px, size_px, kPlacementCloseness)),
        renderer_(face),
        rays_(face.neutral_m, face.triangles) {
    camera_.target_m.y() -= kLookLowerM;
    camera_.position_m.y() -= kLookLowerM;
    renderer_.light(face.neutral_m, camera_, render::Look::light());
  }

  [[nodiscard]] render::Image field(const std::vector<float>& told, double full_scale) {
    const render::ErrorColours colours{told, static_cast<float>(full_scale)};
    return renderer_.draw(&colours);
  }

  void draw_dots(render::Image& picture, const render::Lettering& lettering,
                 const std::vector<Vec3>& places_m) const {
    const float radius = std::max(4.5F, 0.017F * static_cast<float>(camera_.height));
    for (std::size_t i = 0; i < places_m.size(); ++i) {
      const Vec3f p = places_m[i].cast<float>();
      const Vec3f to_eye = (camera_.position_m - p).normalized();
      if (rays_.blocked(p + 0.004F * to_eye, to_eye, 0, 1)) continue;  // Behind the nose, or the head.
      const Eigen::Vector2f at = project(camera_, p);
      draw_disc(picture, at, radius, kPlacementInk);
      draw_disc(picture, at, 0.84F * radius, kDotFill);
      const float size = 1.15F * radius;
      lettering.draw(picture, fmt::format("{}", i + 1), at.x(), at.y() + 0.36F * size, size, kPlacementInk,
                     render::Align::centre);
    }
  }

 private:
  render::Camera camera_;
  render::Renderer renderer_;
  render::RayScene rays_;
};

}  // namespace

Result<render::Image> placement_picture(const std::vector<Vec3>& places_m, std::span<const double> told,
                                        const std::vector<Vec3>& chosen_m, double spacing_m, int height_px) {
  const face::Face face = builtin_face::make_builtin();
  MIEN_TRY_ASSIGN(const auto lettering, render::Lettering::load());
  const std::vector<float> on_skin = spread_on_skin(face, places_m, told, spacing_m);
  const double most = std::max(1e-6, *std::ranges::max_element(told));
  const float size = 0.035F * static_cast<float>(height_px);
  render::Image picture(2 * height_px, height_px);
  int left = 0;
  for (const float view_rad : {render::kFrontView_rad, render::kThreeQuarterView_rad}) {
    PlacementView view(face, view_rad, height_px);
    render::Image one = view.field(on_skin, most);
    view.draw_dots(one, lettering, chosen_m);
    draw_share_legend(one, lettering, most);
    if (left == 0)
      lettering.draw(one, "What one sensor there tells", 0.6F * size, 1.4F * size, size, kPlacementInk);
    render::paste(picture, one, left, 0);
    left += height_px;
  }
  return picture;
}

}  // namespace mien::lab
