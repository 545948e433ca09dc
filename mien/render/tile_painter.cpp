#include "mien/render/tile_painter.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace mien::render {
namespace {

/// Normals of neighbours on one surface differ by less (cosine), ...
constexpr float kSameNormal = 0.75F;
/// ... and so do their depths (share).
constexpr float kSameDepth = 0.01F;

/// Of 0 to 1, linear, the sRGB byte: from a table finer than the curve's darkest steps.
std::uint8_t byte_of(float linear) {
  constexpr int kLevels = 1 << 14;
  static const std::vector<std::uint8_t> kBytes = [] {
    std::vector<std::uint8_t> all;
    for (int i = 0; i <= kLevels; ++i)
      all.push_back(to_srgb(Vec3f::Constant(static_cast<float>(i) / kLevels))[0]);
    return all;
  }();
  return kBytes[static_cast<std::size_t>(std::clamp(linear, 0.0F, 1.0F) * kLevels + 0.5F)];
}

}  // namespace

void Renderer::State::TilePainter::begin(std::size_t tile) {
  tile_ = tile;
  const auto across = static_cast<std::size_t>(tiles_in(s_.view.width));
  left_ = static_cast<int>(tile % across) * kTile;
  top_ = static_cast<int>(tile / across) * kTile;
  rests_ = s_.tile_rests(tile);
  is_seen_ = false;
}

void Renderer::State::TilePainter::see() {
  if (std::exchange(is_seen_, true)) return;
  const bool known = s_.rest_is_lit && s_.is_seen[tile_] != 0;
  if (!known) s_.see(tile_, &own_solid_);
  solid_ = known ? &s_.tile_depths[tile_] : &own_solid_;
  clear_.clear(left_, top_);
  for (const std::uint32_t t : s_.clear_bins.of(tile_)) {
    const auto& [a, b, c] = s_.face.triangles[t];
    clear_.draw(t, ScreenTriangle(s_.on_screen[a], s_.on_screen[b], s_.on_screen[c]));
  }
}

bool Renderer::State::TilePainter::has_no_error(const ErrorColours& errors) const {
  return std::ranges::all_of(s_.solid_bins.of(tile_), [&](std::uint32_t t) {
    return std::ranges::all_of(s_.face.triangles[t], [&](std::uint32_t i) { return errors.error_m[i] == 0; });
  });
}

bool Renderer::State::TilePainter::same(const Surface& surface, std::uint32_t triangle,
                                        float inverse_depth) const {
  if (triangle == surface.triangle) return true;
  if (triangle == TileDepths::kNothing || surface.triangle == TileDepths::kNothing) return false;
  return s_.material[triangle] == s_.material[surface.triangle] &&
         std::abs(inverse_depth - surface.inverse_depth) < kSameDepth * inverse_depth &&
         s_.normal[s_.face.triangles[triangle][0]].dot(s_.normal[s_.face.triangles[surface.triangle][0]]) >
             kSameNormal;
}

std::size_t Renderer::State::TilePainter::find_surfaces(int x, int y, Surfaces* surfaces) const {
  std::size_t count = 0;
  for (int sample = 0; sample < kSamples; ++sample) {
    const std::uint32_t triangle = solid_->triangle(x, y, sample);
    const float inverse_depth = solid_->inverse_depth(x, y, sample);
    const Coverage bit = 1U << sample;
    const auto known = std::find_if(surfaces->begin(), surfaces->begin() + static_cast<std::ptrdiff_t>(count),
                                    [&](const Surface& s) { return same(s, triangle, inverse_depth); });
    if (known == surfaces->begin() + static_cast<std::ptrdiff_t>(count)) {
      (*surfaces)[count++] = {triangle, bit, bit, inverse_depth};
      continue;
    }
    known->samples |= bit;
    if (known->triangle == triangle) known->of_triangle |= bit;
  }
  return count;
}

Renderer::State::SeenPlace Renderer::State::TilePainter::place(std::uint32_t triangle, Coverage samples,
                                                               int x, int y) const {
  const auto& [a, b, c] = s_.face.triangles[triangle];
  const Eigen::Vector2f at =
      middle_of(samples) + Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y));
  return {.triangle = triangle,
          .weight = ScreenTriangle(s_.on_screen[a], s_.on_screen[b], s_.on_screen[c]).weights(at.x(), at.y()),
          .to_camera = -s_.view.ray(at.x(), at.y())};
}

Vec3f Renderer::State::TilePainter::hair_before(const Surface& surface, int pixel, float* through) const {
  const std::span<const HairFragment> still = still_->of(pixel), moving = moving_.of(pixel);
  const auto all = static_cast<float>(count_of(surface.samples));
  Vec3f sent = Vec3f::Zero();
  std::size_t a = 0, b = 0;
  while (*through >= kOpaque && (a < still.size() || b < moving.size())) {
    const bool from_still =
        b == moving.size() || (a < still.size() && still[a].inverse_depth >= moving[b].inverse_depth);
    const HairFragment& fragment = from_still ? still[a++] : moving[b++];
    if (fragment.inverse_depth < surface.inverse_depth) break;
    const int covered = count_of(fragment.samples & surface.samples);
    if (covered == 0) continue;
    const float cover = fragment.cover * static_cast<float>(covered) / all;
    sent += *through * cover * fragment.light;
    *through *= 1 - cover;
  }
  if (*through < kOpaque) {
    sent /= 1 - *through;
    *through = 0;
  }
  return sent;
}

Vec3f Renderer::State::TilePainter::colour_of(const Surface& surface, int x, int y,
                                              const ErrorColours* errors) const {
  float through = 1;
  const Vec3f before = hair_before(surface, (y - top_) * kTile + x - left_, &through);
  const auto finer = static_cast<float>(s_.fineness());
  const auto behind = [&] {
    const Eigen::Vector2f at = middle_of(surface.samples);
    return s_.background((static_cast<float>(x) + at.x()) / finer, (static_cast<float>(y) + at.y()) / finer);
  };
  if (surface.triangle == TileDepths::kNothing || through == 0)
    return through == 1   ? behind()
           : through == 0 ? s_.developed(before)
                          : mix(behind(), s_.developed(before / (1 - through)), 1 - through);
  const SeenPlace seen = place(surface.triangle, surface.of_triangle, x, y);
  SeenPlace glass;
  bool glazed = false;
  if (!clear_.empty())
    for (int sample = 0; sample < kSamples && !glazed; ++sample) {
      if ((surface.samples >> sample & 1U) == 0 ||
          clear_.inverse_depth(x, y, sample) <= solid_->inverse_depth(x, y, sample))
        continue;
      glass = place(clear_.triangle(x, y, sample), 1U << sample, x, y);
      glazed = true;
    }
  const Vec3f arriving = before + through * s_.shade(seen, glazed ? &glass : nullptr, errors);
  const float cover = s_.cover_at(seen);
  return cover < 1 ? mix(behind(), s_.developed(arriving), cover) : s_.developed(arriving);
}

Vec3f Renderer::State::TilePainter::pixel_colour(int x, int y, const ErrorColours* errors) const {
  Surfaces surfaces;
  const std::size_t count = find_surfaces(x, y, &surfaces);
  // What a pixel shows is averaged after the tone curve, so that bright edges stay smooth.
  Vec3f sum = Vec3f::Zero();
  for (std::size_t k = 0; k < count; ++k)
    sum += static_cast<float>(count_of(surfaces[k].samples)) * colour_of(surfaces[k], x, y, errors);
  return sum / kSamples;
}

void Renderer::State::TilePainter::paint(const ErrorColours* errors, Image* picture) {
  HairLight& colours = s_.hair_light[errors != nullptr ? 1 : 0];
  const int finer = s_.fineness();
  const int right = std::min(left_ + kTile, s_.view.width), bottom = std::min(top_ + kTile, s_.view.height);
  const int width = (right - left_) / finer, height = (bottom - top_) / finer;
  const auto row_bytes = static_cast<std::size_t>(3 * width);
  const auto row_of = [&](int row) { return picture->pixel(left_ / finer, top_ / finer + row); };

  const bool keeps = rests_ && (errors == nullptr || has_no_error(*errors));
  std::vector<std::uint8_t>* kept = keeps ? &colours.tile[tile_] : nullptr;
  if (kept != nullptr && !kept->empty()) {
    for (int row = 0; row < height; ++row)
      std::copy_n(kept->data() + row_bytes * static_cast<std::size_t>(row), row_bytes, row_of(row));
    return;
  }
  see();
  gather_hair(&colours);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      Vec3f sum = Vec3f::Zero();
      for (int dy = 0; dy < finer; ++dy)
        for (int dx = 0; dx < finer; ++dx)
          sum += pixel_colour(left_ + x * finer + dx, top_ + y * finer + dy, errors);
      sum /= static_cast<float>(finer * finer);
      for (Eigen::Index c = 0; c < 3; ++c) row_of(y)[3 * x + c] = byte_of(sum[c]);
    }
  if (kept != nullptr)
    for (int row = 0; row < height; ++row) kept->insert(kept->end(), row_of(row), row_of(row) + row_bytes);
}

void Renderer::State::TilePainter::gather_hair(HairLight* colours) {
  // A film keeps the hair that rests from picture to picture; a still would need room for all of it at once.
  TileHair& still = s_.rest_is_lit ? colours->still[tile_] : not_kept_;
  if (!s_.rest_is_lit) still.clear();
  if (!still.is_sorted()) {
    s_.gather_hair(s_.still_hair_bins.of(tile_), *colours, left_, top_, &still);
    still.sort();
  }
  still_ = &still;
  moving_.clear();
  s_.gather_hair(s_.moving_hair_bins.of(tile_), *colours, left_, top_, &moving_);
  moving_.sort();
}

}  // namespace mien::render
