#include "mien/render/raster.h"

#include <cmath>
#include <cstdlib>

namespace mien::render {
namespace {

constexpr float kNearest_m = 1e-3F;
/// Subpixels; farther from the picture's corner nothing is drawn. Edge functions of such stay within 64 bits.
constexpr float kFarthest = 1 << 26;
/// A side of a triangle's box, subpixels, up to which edge functions stay within 32 bits.
constexpr std::int32_t kSmall = 1 << 13;

}  // namespace

Projection::Projection(const Camera& camera, int finer)
    : width(camera.width * finer),
      height(camera.height * finer),
      eye_m(camera.position_m),
      forward((camera.target_m - camera.position_m).normalized()),
      right(forward.cross(camera.up).normalized()),
      up(right.cross(forward)),
      pixel(2 * std::tan(0.5F * camera.field_of_view_rad) / static_cast<float>(height)),
      footprint_m(pixel * (camera.target_m - camera.position_m).norm()) {}

ScreenPoint Projection::project(const Vec3f& p_m) const {
  const Vec3f d = p_m - eye_m;
  const float depth_m = d.dot(forward);
  if (!(depth_m > kNearest_m)) return {};
  const float scale = kSubpixels / (pixel * depth_m);
  const float x = 0.5F * kSubpixels * static_cast<float>(width) + scale * d.dot(right);
  const float y = 0.5F * kSubpixels * static_cast<float>(height) - scale * d.dot(up);
  if (!(std::abs(x) < kFarthest && std::abs(y) < kFarthest)) return {};
  return {static_cast<std::int32_t>(std::lround(x)), static_cast<std::int32_t>(std::lround(y)), 1 / depth_m};
}

Vec3f Projection::ray(float x, float y) const {
  return (forward + pixel * ((x - 0.5F * static_cast<float>(width)) * right -
                             (y - 0.5F * static_cast<float>(height)) * up))
      .normalized();
}

ScreenTriangle::ScreenTriangle(const ScreenPoint& a, const ScreenPoint& b, const ScreenPoint& c)
    : x_{a.x, b.x, c.x},
      y_{a.y, b.y, c.y},
      inverse_depth_{a.inverse_depth, b.inverse_depth, c.inverse_depth} {
  if (!(a.inverse_depth > 0 && b.inverse_depth > 0 && c.inverse_depth > 0)) return;
  const std::int64_t area = (std::int64_t{b.x} - a.x) * (std::int64_t{c.y} - a.y) -
                            (std::int64_t{b.y} - a.y) * (std::int64_t{c.x} - a.x);
  if (area == 0) return;
  for (std::size_t k = 0; k < 3; ++k)
    corner_[k] = Eigen::Vector2f(static_cast<float>(x_[k]), static_cast<float>(y_[k])) / kSubpixels;
  inverse_area_ = static_cast<float>(kSubpixels * kSubpixels) / static_cast<float>(area);
  if (area < 0) {
    std::swap(x_[1], x_[2]);
    std::swap(y_[1], y_[2]);
  }
  const auto [left, right] = std::ranges::minmax(x_);
  const auto [top, bottom] = std::ranges::minmax(y_);
  large_ = right - left > kSmall || bottom - top > kSmall;
  // (Arithmetic shifts round down.)
  constexpr int kShift = 4;
  static_assert(1 << kShift == kSubpixels);
  box_ = {left >> kShift, top >> kShift, (right >> kShift) + 1, (bottom >> kShift) + 1};
}

std::array<float, 3> ScreenTriangle::flat_weights(float x, float y) const {
  const Eigen::Vector2f p(x, y);
  const auto twice_area = [&](const Eigen::Vector2f& from, const Eigen::Vector2f& to) {
    const Eigen::Vector2f u = from - p, v = to - p;
    return u.x() * v.y() - u.y() * v.x();
  };
  const float b = inverse_area_ * twice_area(corner_[2], corner_[0]);
  const float c = inverse_area_ * twice_area(corner_[0], corner_[1]);
  return {1 - b - c, b, c};
}

std::array<float, 3> ScreenTriangle::weights(float x, float y) const {
  std::array<float, 3> weight = flat_weights(x, y);
  float sum = 0;
  // The middle of some covered samples lies inside but for rounding.
  for (std::size_t k = 0; k < 3; ++k) sum += weight[k] = std::max(0.0F, weight[k]) * inverse_depth_[k];
  for (float& w : weight) w /= sum;
  return weight;
}

Eigen::Vector2f ScreenTriangle::gradient(const std::array<float, 3>& field) const {
  const Eigen::Vector2f b = corner_[1] - corner_[0], c = corner_[2] - corner_[0];
  const float fb = field[1] - field[0], fc = field[2] - field[0];
  return inverse_area_ * Eigen::Vector2f(fb * c.y() - fc * b.y(), fc * b.x() - fb * c.x());
}

Eigen::Vector2f middle_of(Coverage coverage) {
  static const std::array<Eigen::Vector2f, kWholePixel + 1> kMiddles = [] {
    std::array<Eigen::Vector2f, kWholePixel + 1> all;
    for (Coverage c = 0; c <= kWholePixel; ++c) {
      Eigen::Vector2f sum = Eigen::Vector2f::Zero();
      for (std::size_t s = 0; s < kSamples; ++s)
        if ((c >> s & 1U) != 0)
          sum += Eigen::Vector2f(static_cast<float>(kSampleAt[s][0]), static_cast<float>(kSampleAt[s][1]));
      all[c] = sum / static_cast<float>(kSubpixels * std::max(1, count_of(c)));
    }
    return all;
  }();
  return kMiddles[coverage];
}

void TileBins::sort(std::span<const std::uint32_t> listed,
                    std::span<const std::array<std::uint32_t, 3>> triangles,
                    std::span<const ScreenPoint> points, int width, int height) {
  const int across = tiles_in(width), down = tiles_in(height);
  start_.assign(static_cast<std::size_t>(across) * static_cast<std::size_t>(down) + 1, 0);
  tiles_.resize(listed.size());
  const auto each_tile = [&](const PixelBox& box, const auto& visit) {
    for (int y = box.top; y < box.bottom; ++y)
      for (int x = box.left; x < box.right; ++x) visit(static_cast<std::size_t>(y * across + x));
  };
  for (std::size_t i = 0; i < listed.size(); ++i) {
    const auto& [a, b, c] = triangles[listed[i]];
    const std::array<const ScreenPoint*, 3> corner = {&points[a], &points[b], &points[c]};
    PixelBox box{.left = width, .top = height, .right = 0, .bottom = 0};
    for (const ScreenPoint* p : corner) {
      if (!(p->inverse_depth > 0)) {
        box = {};
        break;
      }
      box.left = std::min(box.left, p->x >> 4);
      box.top = std::min(box.top, p->y >> 4);
      box.right = std::max(box.right, (p->x >> 4) + 1);
      box.bottom = std::max(box.bottom, (p->y >> 4) + 1);
    }
    box = {std::max(0, box.left), std::max(0, box.top), std::min(width, box.right),
           std::min(height, box.bottom)};
    PixelBox& tiles = tiles_[i];
    tiles = {};
    if (!box.empty())
      tiles = {box.left / kTile, box.top / kTile, (box.right - 1) / kTile + 1, (box.bottom - 1) / kTile + 1};
    each_tile(tiles, [&](std::size_t tile) { ++start_[tile + 1]; });
  }
  for (std::size_t t = 1; t < start_.size(); ++t) start_[t] += start_[t - 1];
  triangle_.resize(start_.back());
  std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
  for (std::size_t i = 0; i < listed.size(); ++i)
    each_tile(tiles_[i], [&](std::size_t tile) { triangle_[next[tile]++] = listed[i]; });
}

TileDepths::TileDepths()
    : inverse_depth_(static_cast<std::size_t>(kTilePixels) * kSamples),
      triangle_(static_cast<std::size_t>(kTilePixels) * kSamples) {}

void TileDepths::clear(int left, int top) {
  left_ = left;
  top_ = top;
  empty_ = true;
  std::ranges::fill(inverse_depth_, 0.0F);
  std::ranges::fill(triangle_, kNothing);
}

void TileDepths::draw(std::uint32_t triangle, const ScreenTriangle& on_screen, Coverage samples) {
  // 1 / depth is linear on the screen.
  const Eigen::Vector2f slope = on_screen.gradient(on_screen.inverse_depth());
  const auto [least, most] = std::ranges::minmax(on_screen.inverse_depth());
  on_screen.scan({left_, top_, left_ + kTile, top_ + kTile}, [&](int x, int y, Coverage coverage) {
    coverage &= samples;
    if (coverage == 0) return;
    empty_ = false;
    const Eigen::Vector2f from_corner =
        Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)) - on_screen.first_corner();
    for (int s = 0; s < kSamples; ++s) {
      if ((coverage >> s & 1U) == 0) continue;
      const auto& place = kSampleAt[static_cast<std::size_t>(s)];
      const Eigen::Vector2f to_sample =
          from_corner +
          Eigen::Vector2f(static_cast<float>(place[0]), static_cast<float>(place[1])) / kSubpixels;
      const float here = std::clamp(on_screen.inverse_depth()[0] + slope.dot(to_sample), least, most);
      float& nearest = inverse_depth_[at(x, y, s)];
      if (here <= nearest) continue;
      nearest = here;
      triangle_[at(x, y, s)] = triangle;
    }
  });
}

void TileDepths::find_farthest() {
  constexpr auto kRow = static_cast<std::size_t>(kBlock) * kSamples;
  for (int block = 0; block < kBlocks * kBlocks; ++block) {
    const int x = left_ + block % kBlocks * kBlock, y = top_ + block / kBlocks * kBlock;
    float least = std::numeric_limits<float>::max();
    for (int row = 0; row < kBlock; ++row)
      for (const float d : std::span(inverse_depth_).subspan(at(x, y + row, 0), kRow))
        least = std::min(least, d);
    farthest_[static_cast<std::size_t>(block)] = least;
  }
}

bool TileDepths::hides(const ScreenPoint& a, const ScreenPoint& b, const ScreenPoint& c) const {
  if (!(a.inverse_depth > 0 && b.inverse_depth > 0 && c.inverse_depth > 0)) return true;  // Not drawn.
  const float nearest = std::max({a.inverse_depth, b.inverse_depth, c.inverse_depth});
  const auto block = [](std::int32_t subpixel, int from) {
    return std::clamp((subpixel / kSubpixels - from) / kBlock, 0, kBlocks - 1);
  };
  const int left = block(std::min({a.x, b.x, c.x}), left_), right = block(std::max({a.x, b.x, c.x}), left_);
  const int top = block(std::min({a.y, b.y, c.y}), top_), bottom = block(std::max({a.y, b.y, c.y}), top_);
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x)
      if (nearest > farthest_[static_cast<std::size_t>(y * kBlocks + x)]) return false;
  return true;
}

}  // namespace mien::render
