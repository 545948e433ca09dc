#include <algorithm>
#include <bit>
#include <numbers>

#include "mien/render/infrared_scene.h"
#include "mien/render/infrared_state.h"
#include "mien/render/solid_noise.h"
#include "mien/render/strands.h"
#include "mien/render/tone.h"

namespace mien::render {
namespace {

constexpr float kInversePi = 1 / std::numbers::pi_v<float>;
/// How much what is no face varies, and over which angle (1 / rad).
constexpr float kUneven = 0.6F, kBumps = 3;
/// Skin scatters: light reaches a little beyond where it falls flat (cosine).
constexpr float kInfraredWrap = 0.25F;
/// A glass lets so much through.
constexpr float kGlassPasses = 0.92F, kGlassMirrors = 0.04F;
/// Hairs scatter what falls on them to all sides.
constexpr float kHairShare = 0.6F;

/// Mirror reflection straight on, and how sharp: the cosine's power is two to this.
struct Shine {
  float mirror;
  int doublings;
};
constexpr std::array<Shine, 6> kShines = {
    {{0.028F, 3}, {0.035F, 5}, {0.04F, 6}, {0.05F, 7}, {0.0F, 4}, {0, 0}}};

/// Blinn's lobe (1977, doi:10.1145/563858.563893), normalised, of the lamps' mean direction.
float lobe(const Shine& shine, float mirror, const Vec3f& normal, const Vec3f& view, const Vec3f& directed) {
  const float strength = directed.norm();
  if (strength <= 0 || mirror <= 0) return 0;
  const Vec3f half = (directed / strength - view).normalized();
  float sharp = std::max(0.0F, half.dot(normal));
  for (int i = 0; i < shine.doublings; ++i) sharp *= sharp;
  const auto power = static_cast<float>(1 << shine.doublings);
  const float flat = 1 + std::min(0.0F, half.dot(view)), flat2 = flat * flat;
  return (mirror + (1 - mirror) * flat2 * flat2 * flat) * strength * (power + 8) /
         (8 * std::numbers::pi_v<float>)*sharp;
}

/// Where samples of one time are seen.
struct Phase {
  Coverage samples = kWholePixel;
  float shift = 0;  // Of the row's time, share of the time between the first row and the last.
};

}  // namespace

struct InfraredScene::Canvas::State {
  std::vector<float> x, y, z;                      // Of a face that moves, when it is exposed, metres.
  std::array<std::vector<ScreenPoint>, 2> points;  // Of each phase, beside the kept vertices.
  std::array<std::vector<std::uint32_t>, 2> listed;
  std::array<std::vector<std::uint32_t>, 2> listed_strands;
  std::array<TileBins, 2> bins, strand_bins;
  TileDepths depths;
  std::vector<float> hair_light,
      hair_gap;  // Of each sample of a tile: what hairs send, what they leave open.
};

InfraredScene::Canvas::Canvas() : state_(std::make_unique<State>()) {}
InfraredScene::Canvas::~Canvas() = default;
InfraredScene::Canvas::Canvas(Canvas&&) noexcept = default;

float InfraredScene::State::shade(std::uint32_t which, const std::array<float, 3>& w, const Vec3f& from_m,
                                  float row_time, float spread_m) const {
  const auto& [a, b, c] = triangle[which];
  const Facet& one = facet[which];
  const auto between = [&](const std::vector<Vec3f>& field) {
    return Vec3f(w[0] * field[a] + w[1] * field[b] + w[2] * field[c]);
  };
  FallingLight falls{
      .directed = w[0] * light[a].directed + w[1] * light[b].directed + w[2] * light[c].directed,
      .ambient = w[0] * light[a].ambient + w[1] * light[b].ambient + w[2] * light[c].ambient};
  Vec3f p_m = between(first);
  if (moves) p_m = mix(p_m, between(last), row_time);
  const Vec3f view = (p_m - from_m).normalized();
  if (one.gloss == Gloss::eye) {
    SeenEye eye = first_eyes[one.index];
    if (moves) {
      eye.axis = mix(eye.axis, last_eyes[one.index].axis, row_time).normalized();
      eye.up = (eye.up - eye.up.dot(eye.axis) * eye.axis).normalized();
    }
    return eye_radiance(wearer.eyes[one.index], eye, from_m, view, p_m, falls, lamps, spread_m);
  }
  Vec3f n = between(normal).normalized();
  if (one.two_sided && n.dot(view) > 0) n = -n;
  const float wrap = one.gloss == Gloss::skin || one.gloss == Gloss::lips ? kInfraredWrap : 0.0F;
  const float lit =
      std::max(0.0F, n.dot(falls.directed) + wrap * falls.directed.norm()) / (1 + wrap) + falls.ambient;
  const Shine& shine = kShines[static_cast<std::size_t>(one.gloss)];
  const float mirror = one.gloss == Gloss::thing ? wearer.things[one.index].shine : shine.mirror;
  return albedo(one, w[1], w[2]) * kInversePi * lit + lobe(shine, mirror, n, view, falls.directed);
}

float InfraredScene::State::background(const Lens& lens, float x, float y) const {
  if (background_radiance <= 0) return 0;
  const float scale = kBumps * lens.pixel;
  const Vec3f place(scale * x, scale * y, 100 * (lens.k1 + lens.pixel));  // Another one for each camera.
  return background_radiance * std::max(0.0F, 1 + 2 * kUneven * solid_noise(place));
}

void InfraredScene::draw(const Lens& lens, float exposure, Canvas& canvas, std::span<float> out) const {
  const State& s = *state_;
  Canvas::State& at = *canvas.state_;
  // A face that moves is exposed at two times a row, two samples each.
  const std::array<Phase, 2> phases = {Phase{s.moves ? Coverage{0b0101} : kWholePixel, -0.25F * exposure},
                                       Phase{Coverage{0b1010}, 0.25F * exposure}};
  const std::size_t phase_count = s.moves ? 2 : 1;
  const auto row_time = [&](float y, float shift) {
    return s.moves ? y / static_cast<float>(lens.height) + shift : 0.0F;
  };
  if (s.moves)
    for (std::vector<float>* coordinate : {&at.x, &at.y, &at.z}) coordinate->resize(s.first.size());
  for (std::size_t f = 0; f < phase_count; ++f) {
    at.points[f].resize(s.first.size());
    lens.project(s.first_m.x, s.first_m.y, s.first_m.z, at.points[f]);
    if (s.moves) {
      // When the row is exposed on which a place is seen at first.
      for (std::size_t v = 0; v < s.first.size(); ++v) {
        const float time = row_time(static_cast<float>(at.points[f][v].y) / kSubpixels, phases[f].shift);
        const Vec3f now_m = mix(s.first[v], s.last[v], std::clamp(time, -0.5F, 1.5F));
        at.x[v] = now_m.x();
        at.y[v] = now_m.y();
        at.z[v] = now_m.z();
      }
      lens.project(at.x, at.y, at.z, at.points[f]);
    }
    const std::vector<ScreenPoint>& points = at.points[f];
    const int right = lens.width * kSubpixels, bottom = lens.height * kSubpixels;
    const auto list = [&](std::span<const std::array<std::uint32_t, 3>> triangles, const auto& is_turned,
                          std::vector<std::uint32_t>& listed) {
      listed.clear();
      for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        const ScreenPoint &a = points[triangles[t][0]], &b = points[triangles[t][1]],
                          &c = points[triangles[t][2]];
        if (!(a.inverse_depth > 0 && b.inverse_depth > 0 && c.inverse_depth > 0)) continue;
        if (std::max({a.x, b.x, c.x}) < 0 || std::min({a.x, b.x, c.x}) >= right ||
            std::max({a.y, b.y, c.y}) < 0 || std::min({a.y, b.y, c.y}) >= bottom)
          continue;
        if (is_turned(t) && faces_away(a, b, c)) continue;
        listed.push_back(t);
      }
    };
    list(
        s.triangle, [&](std::uint32_t t) { return !s.facet[t].two_sided; }, at.listed[f]);
    list(
        s.strand, [](std::uint32_t) { return false; }, at.listed_strands[f]);
    at.bins[f].sort(at.listed[f], s.triangle, points, lens.width, lens.height);
    at.strand_bins[f].sort(at.listed_strands[f], s.strand, points, lens.width, lens.height);
  }

  const auto triangle_on_screen = [&](std::size_t f, const std::array<std::uint32_t, 3>& corners) {
    const std::vector<ScreenPoint>& points = at.points[f];
    return ScreenTriangle(points[corners[0]], points[corners[1]], points[corners[2]]);
  };
  const int across = tiles_in(lens.width);
  constexpr std::size_t kTileSamples = static_cast<std::size_t>(kTilePixels) * kSamples;
  for (std::size_t tile = 0; tile < at.bins[0].count(); ++tile) {
    const int left = static_cast<int>(tile) % across * kTile, top = static_cast<int>(tile) / across * kTile;
    const PixelBox box = {left, top, std::min(left + kTile, lens.width), std::min(top + kTile, lens.height)};
    at.depths.clear(left, top);
    for (std::size_t f = 0; f < phase_count; ++f)
      for (const std::uint32_t t : at.bins[f].of(tile))
        at.depths.draw(t, triangle_on_screen(f, s.triangle[t]), phases[f].samples);

    bool has_hair = false;
    for (std::size_t f = 0; f < phase_count; ++f) {
      for (const std::uint32_t t : at.strand_bins[f].of(tile)) {
        if (!has_hair) {
          at.hair_light.assign(kTileSamples, 0.0F);
          at.hair_gap.assign(kTileSamples, 1.0F);
          has_hair = true;
        }
        const auto& corners = s.strand[t];
        const ScreenTriangle on_screen = triangle_on_screen(f, corners);
        const auto& [a, b, c] = corners;
        // How many hairs a pixel is wide, roughly.
        const float hairs =
            face::kStrandsPerUv * on_screen.gradient({s.uv[a].x(), s.uv[b].x(), s.uv[c].x()}).norm();
        on_screen.scan(box, [&](int x, int y, Coverage coverage) {
          coverage &= phases[f].samples;
          if (coverage == 0) return;
          const auto w = on_screen.weights(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
          const Eigen::Vector2f uv = w[0] * s.uv[a] + w[1] * s.uv[b] + w[2] * s.uv[c];
          const Strand hair = strand_at(uv, hairs);
          const float cover = std::min(1.0F, hair.cover * s.wearer.lash_cover);
          if (cover <= 0) return;
          const float falls = w[0] * (kHairShare * s.light[a].directed.norm() + s.light[a].ambient) +
                              w[1] * (kHairShare * s.light[b].directed.norm() + s.light[b].ambient) +
                              w[2] * (kHairShare * s.light[c].directed.norm() + s.light[c].ambient);
          const float sends = hair.brightness * s.strand_albedo[a] * kInversePi * falls;
          const float depth = w[0] * on_screen.inverse_depth()[0] + w[1] * on_screen.inverse_depth()[1] +
                              w[2] * on_screen.inverse_depth()[2];
          for (int k = 0; k < kSamples; ++k) {
            if ((coverage >> k & 1U) == 0 || at.depths.inverse_depth(x, y, k) > depth) continue;
            const auto i = static_cast<std::size_t>(((y - top) * kTile + x - left) * kSamples + k);
            at.hair_light[i] += at.hair_gap[i] * cover * sends;
            at.hair_gap[i] *= 1 - cover;
          }
        });
      }
    }

    for (int y = box.top; y < box.bottom; ++y)
      for (int x = box.left; x < box.right; ++x) {
        float sum = 0;
        Coverage left_over = kWholePixel;
        while (left_over != 0) {
          const int k = std::countr_zero(left_over);
          const std::uint32_t t = at.depths.triangle(x, y, k);
          const std::size_t f = (phases[0].samples >> k & 1U) != 0 ? 0 : 1;
          Coverage same = 0;
          for (int j = k; j < kSamples; ++j)
            if ((left_over & phases[f].samples & 1U << j) != 0 && at.depths.triangle(x, y, j) == t)
              same |= 1U << j;
          left_over &= ~same;
          float radiance = 0;
          if (t == TileDepths::kNothing) {
            radiance = s.background(lens, static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
          } else {
            const Eigen::Vector2f middle = middle_of(same);
            const auto w =
                triangle_on_screen(f, s.triangle[t])
                    .weights(static_cast<float>(x) + middle.x(), static_cast<float>(y) + middle.y());
            const float spread_m = 0.5F * lens.pixel / at.depths.inverse_depth(x, y, k);
            radiance =
                s.shade(t, w, lens.position_m, row_time(static_cast<float>(y), phases[f].shift), spread_m);
          }
          if (!has_hair) {
            sum += radiance * static_cast<float>(count_of(same));
          } else {
            for (int j = 0; j < kSamples; ++j) {
              if ((same >> j & 1U) == 0) continue;
              const auto i = static_cast<std::size_t>(((y - top) * kTile + x - left) * kSamples + j);
              sum += at.hair_light[i] + at.hair_gap[i] * radiance;
            }
          }
        }
        out[static_cast<std::size_t>(y) * static_cast<std::size_t>(lens.width) +
            static_cast<std::size_t>(x)] = sum / kSamples;
      }
  }

  for (const InfraredWearer::Glass& glass : s.wearer.glasses) {
    const ScreenPoint middle = lens.project(glass.centre_m);
    if (!(middle.inverse_depth > 0)) continue;
    // A disc seen at any angle stays within its own radius, a little more where the lens stretches.
    const auto reach = static_cast<int>(1.6F * glass.radius_m * middle.inverse_depth / lens.pixel) + 1;
    const int column = middle.x / kSubpixels, row = middle.y / kSubpixels;
    for (int y = std::max(0, row - reach); y < std::min(lens.height, row + reach); ++y)
      for (int x = std::max(0, column - reach); x < std::min(lens.width, column + reach); ++x) {
        const Vec3f view = lens.ray(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
        const float towards = -view.dot(glass.forward);
        if (towards < 0.1F) continue;
        const float way = (lens.position_m - glass.centre_m).dot(glass.forward) / towards;
        if (way <= 0) continue;
        const Vec3f met_m = lens.position_m + way * view, off_m = met_m - glass.centre_m;
        if (off_m.squaredNorm() > glass.radius_m * glass.radius_m) continue;
        float& pixel = out[static_cast<std::size_t>(y) * static_cast<std::size_t>(lens.width) +
                           static_cast<std::size_t>(x)];
        const Vec3f normal = (glass.forward + off_m / glass.curve_m).normalized();
        pixel =
            kGlassPasses * pixel + mirrored_lamps(s.lamps, met_m, normal, view, kGlassMirrors, lens.pixel);
      }
  }
}

void InfraredScene::draw_by_rays(const Lens& lens, std::span<float> out) const {
  const State& s = *state_;
  for (int y = 0; y < lens.height; ++y)
    for (int x = 0; x < lens.width; ++x) {
      float sum = 0;
      for (const auto& place : kSampleAt) {
        const Vec3f view = lens.ray(static_cast<float>(x) + static_cast<float>(place[0]) / kSubpixels,
                                    static_cast<float>(y) + static_cast<float>(place[1]) / kSubpixels);
        const RayScene::Hit hit = s.solid.first_hit(lens.position_m, view);
        if (!hit.any()) {
          sum += s.background(lens, static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
          continue;
        }
        const float spread_m = 0.5F * lens.pixel * hit.distance;
        sum += s.shade(hit.triangle, {1 - hit.u - hit.v, hit.u, hit.v}, lens.position_m, 0, spread_m);
      }
      out[static_cast<std::size_t>(y) * static_cast<std::size_t>(lens.width) + static_cast<std::size_t>(x)] =
          sum / kSamples;
    }
}

}  // namespace mien::render
