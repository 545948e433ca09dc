#include "mien/render/renderer.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

#include "mien/render/parallel.h"
#include "mien/render/renderer_state.h"

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

/// Where a camera's picture lies, frame H.
struct PictureAxes {
  explicit PictureAxes(const Camera& camera)
      : forward((camera.target_m - camera.position_m).normalized()),
        right(forward.cross(camera.up).normalized()),
        up(right.cross(forward)) {}
  Vec3f forward, right, up;
};

}  // namespace

/// `count` directions spread evenly over the sphere (Fibonacci lattice).
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

Renderer::Renderer(const face::Face& face, Quality quality, int threads)
    : state_(std::make_unique<State>(face, quality, threads)) {}
Renderer::~Renderer() = default;

Image Renderer::still(std::span<const Vec3f> vertices_m, const Camera& camera, const Look& look,
                      const ErrorColours* errors) {
  light(vertices_m, camera, look);
  return draw(errors);
}

void Renderer::light(std::span<const Vec3f> vertices_m, const Camera& camera, const Look& look) {
  State& s = *state_;
  assert(vertices_m.size() == s.face.neutral_m.size());
  assert(camera.width > 0 && camera.height > 0);
  s.setting.camera = camera;
  s.setting.background_top = from_srgb(look.background_top);
  s.setting.background_bottom = from_srgb(look.background_bottom);
  s.setting.infrared = look.infrared;

  const PictureAxes axes(camera);
  Studio& studio = s.setting.studio;
  studio.light = {look.key, look.fill, look.rim};
  for (std::size_t l = 0; l < kLights; ++l) {
    const Vec3f d = studio.light[l].direction;
    studio.light[l].direction = (d.x() * axes.right + d.y() * axes.up - d.z() * axes.forward).normalized();
    studio.light_samples[l] = disc_directions(studio.light[l].direction, studio.light[l].radius_rad,
                                              s.quality == Quality::still ? 16 : 6);
  }
  studio.sky = look.sky;
  studio.ground = look.ground;

  s.find_normals(vertices_m);
  s.solid.move(vertices_m);
  s.clear.move(vertices_m);
  s.fringe.move(vertices_m);
  s.hair.move(vertices_m);
  s.light_vertices(studio);
  s.scatter_light();
}

Image Renderer::draw(const ErrorColours* errors) const {
  const State& s = *state_;
  const Camera& camera = s.setting.camera;
  assert(errors == nullptr || errors->error_m.size() == s.position.size());
  const PictureAxes axes(camera);
  Image picture(camera.width, camera.height);
  const float half_height = std::tan(0.5F * camera.field_of_view_rad);
  const float pixel = 2 * half_height / static_cast<float>(camera.height);
  const float footprint_m = pixel * (camera.target_m - camera.position_m).norm();
  const int grid = s.quality == Quality::still ? 3 : 2;
  const int edge_grid = s.quality == Quality::still ? grid + 2 : grid + 1;

  const auto background = [&](float x, float y) {
    const float u = x / static_cast<float>(camera.width) - 0.5F, v = y / static_cast<float>(camera.height);
    return Vec3f(mix(s.setting.background_top, s.setting.background_bottom, smoothstep(0, 1, v)) *
                 (1 - 0.5F * u * u));
  };
  // What a pixel shows is averaged after the tone curve, so that bright edges stay smooth.
  const auto sample = [&](float x, float y) {
    const Vec3f direction = (axes.forward + ((x - 0.5F * static_cast<float>(camera.width)) * axes.right -
                                             (y - 0.5F * static_cast<float>(camera.height)) * axes.up) *
                                                pixel)
                                .normalized();
    float cover = 0;
    Vec3f light = s.shade(s.setting.studio, camera.position_m, direction, errors, footprint_m, &cover);
    if (s.setting.infrared) light.setConstant(light.x());
    const Vec3f behind = background(x, y);
    return cover > 0 ? mix(behind, tone_map(light), cover) : behind;
  };
  const auto average = [&](int px, int py, int n, float* contrast) {
    Vec3f sum = Vec3f::Zero(), low = Vec3f::Constant(1e9F), high = Vec3f::Constant(-1e9F);
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        // A slanted grid meets near-vertical and near-horizontal edges at different places.
        const float slant = 0.35F / static_cast<float>(n);
        const float x = (static_cast<float>(i) + 0.5F + slant * (static_cast<float>(2 * j + 1 - n))) /
                        static_cast<float>(n);
        const float y = (static_cast<float>(j) + 0.5F - slant * (static_cast<float>(2 * i + 1 - n))) /
                        static_cast<float>(n);
        const Vec3f value = sample(static_cast<float>(px) + x, static_cast<float>(py) + y);
        sum += value;
        low = low.cwiseMin(value);
        high = high.cwiseMax(value);
      }
    *contrast = (high - low).maxCoeff();
    return Vec3f(sum / static_cast<float>(n * n));
  };
  parallel(s.threads, static_cast<std::size_t>(camera.height), 4, [&](std::size_t first, std::size_t last) {
    for (auto y = static_cast<int>(first); y < static_cast<int>(last); ++y)
      for (int x = 0; x < camera.width; ++x) {
        float contrast = 0;
        Vec3f value = average(x, y, grid, &contrast);
        if (contrast > 0.06F) value = average(x, y, edge_grid, &contrast);
        const Rgb colour = to_srgb(value);
        std::ranges::copy(colour, picture.pixel(x, y));
      }
  });
  if (errors != nullptr) {
    const float brightness = s.setting.background_bottom.mean();
    draw_error_legend(picture, errors->full_scale_m,
                      brightness > 0.3F ? Rgb{40, 42, 48} : Rgb{214, 217, 224});
  }
  return picture;
}

}  // namespace mien::render
