#include "mien/render/renderer.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

#include "mien/render/parallel.h"
#include "mien/render/tile_painter.h"

namespace mien::render {
namespace {

/// `count` directions evenly over a disc of `radius_rad` about `axis`.
std::vector<Vec3f> disc_directions(const Vec3f& axis, float radius_rad, int count) {
  const Vec3f side = axis.unitOrthogonal(), other = axis.cross(side);
  std::vector<Vec3f> directions;
  for (int i = 0; i < count; ++i) {
    const float r =
        std::tan(radius_rad) * std::sqrt((static_cast<float>(i) + 0.5F) / static_cast<float>(count));
    const float turn = static_cast<float>(i) * kPi * (3 - std::sqrt(5.0F));
    directions.push_back((axis + r * (std::cos(turn) * side + std::sin(turn) * other)).normalized());
  }
  return directions;
}

}  // namespace

std::vector<Vec3f> sphere_directions(int count) {
  std::vector<Vec3f> directions;
  for (int i = 0; i < count; ++i) {
    const float y = 1 - (2 * static_cast<float>(i) + 1) / static_cast<float>(count);
    const float r = std::sqrt(1 - y * y);
    const float turn = static_cast<float>(i) * kPi * (3 - std::sqrt(5.0F));
    directions.emplace_back(r * std::cos(turn), y, r * std::sin(turn));
  }
  return directions;
}

Look Look::dark() {
  Look look;
  look.key = {Vec3f(-0.55F, 0.62F, 0.72F).normalized(), Vec3f(2.65F, 2.42F, 2.2F), 0.26F};
  look.fill = {Vec3f(0.85F, 0.10F, 0.55F).normalized(), Vec3f(0.30F, 0.36F, 0.46F), 0.40F};
  look.rim = {Vec3f(0.75F, 0.45F, -0.62F).normalized(), Vec3f(1.5F, 1.65F, 1.9F), 0.22F};
  look.sky = Vec3f(0.30F, 0.32F, 0.36F);
  look.ground = Vec3f(0.10F, 0.075F, 0.065F);
  look.background_top = {38, 42, 50};
  look.background_bottom = {16, 18, 22};
  return look;
}

Look Look::light() {
  Look look = dark();
  look.key.radiance = Vec3f(2.3F, 2.15F, 2.0F);
  look.fill.radiance = Vec3f(0.45F, 0.48F, 0.52F);
  look.rim.radiance = Vec3f(0.9F, 0.95F, 1.0F);
  look.sky = Vec3f(0.52F, 0.54F, 0.57F);
  look.ground = Vec3f(0.24F, 0.21F, 0.195F);
  look.background_top = {244, 245, 247};
  look.background_bottom = {222, 225, 230};
  return look;
}

Renderer::Renderer(const face::Face& face, Quality quality, int threads, const face::SkinFolds& folds,
                   const face::SkinMarks& marks)
    : state_(std::make_unique<State>(face, quality, threads, folds, marks)) {}
Renderer::~Renderer() = default;

Image Renderer::still(std::span<const Vec3f> vertices_m, const Camera& camera, const Look& look,
                      const ErrorColours* errors) {
  light(vertices_m, camera, look);
  return draw(errors);
}

void Renderer::State::set_studio(const Camera& new_camera, const Look& new_look) {
  if (is_set && new_camera == camera && new_look == look) return;
  camera = new_camera;
  look = new_look;
  is_set = true;
  rest_is_lit = false;
  view = Projection(camera, fineness());
  studio.background_top = from_srgb(look.background_top);
  studio.background_bottom = from_srgb(look.background_bottom);
  studio.light = {look.key, look.fill, look.rim};
  for (std::size_t l = 0; l < kLights; ++l) {
    const Vec3f d = studio.light[l].direction;
    studio.light[l].direction = (d.x() * view.right + d.y() * view.up - d.z() * view.forward).normalized();
    studio.light_samples[l] =
        disc_directions(studio.light[l].direction, studio.light[l].radius_rad,
                        quality == Quality::still ? static_cast<int>(kMostLightSamples) : 5);
  }
  studio.sky = look.sky;
  studio.ground = look.ground;
  around_direction.clear();
  for (const Vec3f& d : ambient_directions) around_direction.push_back(studio.around(d));
}

void Renderer::light(std::span<const Vec3f> vertices_m, const Camera& camera, const Look& look) {
  State& s = *state_;
  assert(vertices_m.size() == s.face.neutral_m.size());
  assert(camera.width > 0 && camera.height > 0);
  s.set_studio(camera, look);
  // A film of a head that keeps still lights the neutral once; then each pose changes only what is near to
  // what moves and is seen. (Light on hair is the neutral's whatever the face does.)
  if (s.quality == Quality::video && s.hair_rests(vertices_m)) {
    if (!s.rest_is_lit) s.light_rest();
    s.rest_is_lit = true;
    s.pose(vertices_m, false);
    s.see_what_moves();
    s.unscattered = s.rest.unscattered;
    s.light_surfaces(s.places_to_light());
  } else {
    s.rest_is_lit = false;
    s.pose(vertices_m, true);
    s.shade_by_hair();
    s.light_hair(s.still_hair_vertex);
    s.light_hair(s.moving_hair_vertex);
    s.light_surfaces(s.every_place);
  }
  s.copy_light(!s.rest_is_lit);
  if (s.rest_is_lit) s.find_what_rests();
}

Image Renderer::draw(const ErrorColours* errors) {
  std::array<Image, 1> picture;
  const std::array<const ErrorColours*, 1> one = {errors};
  state_->draw(one, picture);
  return std::move(picture[0]);
}

Renderer::Pictures Renderer::draw_with_errors(const ErrorColours& errors) {
  std::array<Image, 2> pictures;
  const std::array<const ErrorColours*, 2> both = {nullptr, &errors};
  state_->draw(both, pictures);
  return {.plain = std::move(pictures[0]), .errors = std::move(pictures[1])};
}

Vec3f Renderer::State::background(float x, float y) const {
  const float u = x / static_cast<float>(camera.width) - 0.5F, v = y / static_cast<float>(camera.height);
  return mix(studio.background_top, studio.background_bottom, smoothstep(0, 1, v)) * (1 - 0.5F * u * u);
}

Vec3f Renderer::State::developed(const Vec3f& arriving) const {
  return tone_map(look.infrared ? Vec3f(Vec3f::Constant(arriving.x())) : arriving);
}

void Renderer::State::draw(std::span<const ErrorColours* const> errors, std::span<Image> pictures) {
  const int tiles_across = tiles_in(view.width), tiles_down = tiles_in(view.height);
  const auto tiles = static_cast<std::size_t>(tiles_across) * static_cast<std::size_t>(tiles_down);
  for (std::size_t k = 0; k < errors.size(); ++k) {
    assert(errors[k] == nullptr || errors[k]->error_m.size() == position.size());
    shade_hair(errors[k] != nullptr);
    pictures[k] = Image(camera.width, camera.height);
  }
  for (HairLight& colours : hair_light)
    if (rest_is_lit && colours.still.empty()) {
      colours.still.resize(tiles);
      colours.tile.assign(tiles, {});
    }

  parallel(workers, tiles, 4, [&](std::size_t first, std::size_t last) {
    TilePainter painter(*this);
    for (std::size_t tile = first; tile < last; ++tile) {
      painter.begin(tile);
      for (std::size_t k = 0; k < errors.size(); ++k) painter.paint(errors[k], &pictures[k]);
    }
  });
}

}  // namespace mien::render
