#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "lab/imu/placement/placement_bound.h"
#include "lab/imu/placement/placement_study.h"
#include "lab/spread_on_skin.h"
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
constexpr int kPanelsInRow = 4;
/// Of shape groups, for the colour-blind too (Okabe and Ito 2008).
constexpr std::array<render::Rgb, kShapeGroups.size()> kGroupColours = {
    {{0, 114, 178}, {0, 158, 115}, {230, 159, 0}, {204, 60, 40}, {150, 80, 160}}};

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

/// Squares of colour with words along the bottom.
void draw_group_legend(render::Image& picture, const render::Lettering& lettering) {
  const float size = 0.026F * static_cast<float>(picture.height);
  const float baseline = static_cast<float>(picture.height) - 0.8F * size;
  float x = size;
  for (std::size_t g = 0; g < kShapeGroups.size(); ++g) {
    draw_disc(picture, {x + 0.4F * size, baseline - 0.35F * size}, 0.45F * size, kGroupColours[g]);
    lettering.draw(picture, kShapeGroups[g], x + 1.2F * size, baseline, size, kPlacementInk);
    x += 2.4F * size + lettering.width(kShapeGroups[g], size);
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

  [[nodiscard]] render::Image plain() { return renderer_.draw(); }

  [[nodiscard]] render::Image field(const std::vector<float>& told, double full_scale) {
    const render::ErrorColours colours{told, static_cast<float>(full_scale)};
    return renderer_.draw(&colours);
  }

  void draw_dots(render::Image& picture, const render::Lettering& lettering,
                 const std::vector<PlacementDot>& dots) const {
    const float radius = std::max(4.5F, 0.017F * static_cast<float>(camera_.height));
    for (const PlacementDot& dot : dots) {
      const Vec3f p = dot.position_m.cast<float>();
      const Vec3f to_eye = (camera_.position_m - p).normalized();
      if (rays_.blocked(p + 0.004F * to_eye, to_eye, 0, 1)) continue;  // Behind the nose, or the head.
      const Eigen::Vector2f at = project(camera_, p);
      draw_disc(picture, at, radius, kPlacementInk);
      draw_disc(picture, at, 0.84F * radius, kDotFill);
      const float size = 1.15F * radius;
      lettering.draw(picture, fmt::format("{}", dot.number), at.x(), at.y() + 0.36F * size, size,
                     kPlacementInk, render::Align::centre);
    }
  }

 private:
  render::Camera camera_;
  render::Renderer renderer_;
  render::RayScene rays_;
};

/// The face painted in the colours of groups.
face::Face painted_by_groups(const face::Face& face, const std::vector<Vec3>& places_m,
                             const PlacementGroups& groups, const SkinSpread& spread) {
  face::Face painted = face;
  const Vec3f pale = render::error_colour(0);
  // How much of each group is around a vertex; what is most there gives the colour, its share the strength.
  std::array<std::vector<float>, kShapeGroups.size()> share;
  for (std::size_t g = 0; g < share.size(); ++g) {
    std::vector<double> of_group;
    for (std::size_t i = 0; i < places_m.size(); ++i)
      of_group.push_back(groups.group[i] == g ? groups.strength[i] : 0);
    share[g] = spread_on_skin(face, places_m, of_group, spread);
  }
  for (std::size_t v = 0; v < painted.colour.size(); ++v) {
    std::size_t most = 0;
    for (std::size_t g = 1; g < share.size(); ++g)
      if (share[g][v] > share[most][v]) most = g;
    painted.colour[v] =
        render::mix(pale, render::from_srgb(kGroupColours[most]), std::clamp(share[most][v], 0.0F, 1.0F));
  }
  // Skin scatters red light and would tint what is painted on it.
  for (face::Part& part : painted.parts)
    if (part.material == face::Material::skin || part.material == face::Material::lips)
      part.material = face::Material::other;
  return painted;
}

double most_told(const PlacementField& field) {
  return std::max(1e-6, *std::ranges::max_element(field.told));
}

}  // namespace

render::Image PlacementPictures::together() const {
  render::Image all(std::max({alone.width, groups.width, sets.width}),
                    alone.height + groups.height + sets.height, {255, 255, 255});
  render::paste(all, alone, 0, 0);
  render::paste(all, groups, 0, alone.height);
  render::paste(all, sets, 0, alone.height + groups.height);
  return all;
}

Result<PlacementPictures> placement_pictures(const std::vector<Vec3>& places_m,
                                             const std::vector<PlacementField>& fields,
                                             const PlacementGroups& groups,
                                             const PlacementPictureRequest& request) {
  const face::Face face = builtin_face::make_builtin();
  MIEN_TRY_ASSIGN(const auto lettering, render::Lettering::load());
  const SkinSpread spread{
      .reach_m = 2 * request.spacing_m, .fade_m = request.spacing_m, .sharp_m = 0.4 * request.spacing_m};
  const int height = request.height_px;
  const float size = 0.035F * static_cast<float>(height);
  const std::array<float, 2> views = {render::kFrontView_rad, render::kThreeQuarterView_rad};
  PlacementPictures pictures;
  pictures.alone = render::Image(2 * height, height);
  pictures.groups = render::Image(2 * height, height);
  const PlacementField& first = fields.front();
  const std::vector<float> told = spread_on_skin(face, places_m, first.told, spread);
  const face::Face painted = painted_by_groups(face, places_m, groups, spread);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const int left = static_cast<int>(v) * height;
    PlacementView view(face, views[v], height);
    render::Image one = view.field(told, most_told(first));
    view.draw_dots(one, lettering, first.dots);
    draw_share_legend(one, lettering, most_told(first));
    lettering.draw(one, v == 0 ? first.title : "", 0.6F * size, 1.4F * size, size, kPlacementInk);
    render::paste(pictures.alone, one, left, 0);
    PlacementView of_groups(painted, views[v], height);
    one = of_groups.plain();
    of_groups.draw_dots(one, lettering, first.dots);
    draw_group_legend(one, lettering);
    lettering.draw(one, v == 0 ? "What a sensor there tells most of" : "", 0.6F * size, 1.4F * size, size,
                   kPlacementInk);
    render::paste(pictures.groups, one, left, 0);
  }

  const int panel = 2 * height / kPanelsInRow;
  const int rows = (static_cast<int>(fields.size()) - 1 + kPanelsInRow - 1) / kPanelsInRow;
  pictures.sets = render::Image(2 * height, rows * panel, {255, 255, 255});
  PlacementView small(face, render::kFrontView_rad, panel);
  for (std::size_t i = 1; i < fields.size(); ++i) {
    render::Image one =
        small.field(spread_on_skin(face, places_m, fields[i].told, spread), most_told(fields[i]));
    small.draw_dots(one, lettering, fields[i].dots);
    const float text = 0.05F * static_cast<float>(panel);
    lettering.draw(one, fields[i].title, 0.5F * text, 1.3F * text, text, kPlacementInk);
    const int at = static_cast<int>(i) - 1;
    render::paste(pictures.sets, one, at % kPanelsInRow * panel, at / kPanelsInRow * panel);
  }
  return pictures;
}

}  // namespace mien::lab
