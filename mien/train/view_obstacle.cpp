#include "mien/train/view_obstacle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace mien::train {
namespace {

constexpr double kGlare = 0.3;
/// Shares of the donning: when it comes, and for how long.
constexpr double kLatestBegin = 0.7, kShortest = 0.15, kLongest = 0.6;
constexpr double kLeastAxis = 0.3, kMostAxis = 1.0, kMostEdge = 0.15;
/// So often it is so wide that its edge is all but straight, as a mask's or a sleeve's.
constexpr double kWide = 0.3, kWideAxis = 3;
constexpr double kMostWay = 0.01;  ///< One sigma, a frame.
constexpr double kMostContrast = 90;
/// So often its texture is a shade, which rises so much over the view's side at most, and little else.
constexpr double kShaded = 0.5, kMostRise = 120, kShadedContrast = 0.15;
/// From this level on glare shows nothing of what it falls on.
constexpr std::uint8_t kSaturated = 250;

/// Between the texture's knots; u and v in [0, 1].
float texture_at(const ViewObstacle& obstacle, float u, float v) {
  constexpr auto kLast = static_cast<float>(ViewObstacle::kGrid - 1);
  const float x = u * kLast, y = v * kLast;
  const auto x0 = std::min(static_cast<std::size_t>(x), ViewObstacle::kGrid - 2),
             y0 = std::min(static_cast<std::size_t>(y), ViewObstacle::kGrid - 2);
  const float a = x - static_cast<float>(x0), b = y - static_cast<float>(y0);
  const auto& t = obstacle.texture;
  return std::lerp(std::lerp(t[y0][x0], t[y0][x0 + 1], a), std::lerp(t[y0 + 1][x0], t[y0 + 1][x0 + 1], a), b);
}

}  // namespace

ViewObstacle draw_obstacle(std::size_t frames, Random& random) {
  ViewObstacle obstacle;
  const auto all = static_cast<double>(frames);
  obstacle.begin = static_cast<std::size_t>(random.uniform(0, kLatestBegin) * all);
  obstacle.end = obstacle.begin + 1 + static_cast<std::size_t>(random.uniform(kShortest, kLongest) * all);
  obstacle.is_glare = random.chance(kGlare);
  obstacle.x = random.uniform(0, 1);
  obstacle.y = random.uniform(0, 1);
  obstacle.dx = random.normal(0, kMostWay);
  obstacle.dy = random.normal(0, kMostWay);
  obstacle.long_axis = random.uniform(kLeastAxis, kMostAxis);
  obstacle.short_axis = random.uniform(kLeastAxis, obstacle.long_axis);
  obstacle.turn_rad = random.uniform(0, std::numbers::pi);
  if (random.chance(kWide)) {
    const double away_rad = random.uniform(0, 2 * std::numbers::pi);
    obstacle.x += kWideAxis * std::cos(away_rad);
    obstacle.y += kWideAxis * std::sin(away_rad);
    obstacle.long_axis = obstacle.short_axis = kWideAxis;
  }
  obstacle.edge = random.uniform(0.01, kMostEdge);
  obstacle.gain = random.uniform(1, 4);
  // As many as half are darker than a quarter of the range, where what is not lit is too; and so much glare
  // is a veil rather than white.
  const double bright = random.uniform(), level = 255 * bright * bright,
               most = random.uniform(0, kMostContrast);
  const bool shaded = random.chance(kShaded);
  const double contrast = shaded ? kShadedContrast * most : most;
  const double rise = shaded ? random.uniform(0, kMostRise) : 0.0,
               rises_rad = random.uniform(0, 2 * std::numbers::pi);
  constexpr double kMiddle = 0.5 * (ViewObstacle::kGrid - 1);
  for (std::size_t y = 0; y < ViewObstacle::kGrid; ++y)
    for (std::size_t x = 0; x < ViewObstacle::kGrid; ++x) {
      const double along = (std::cos(rises_rad) * (static_cast<double>(x) - kMiddle) +
                            std::sin(rises_rad) * (static_cast<double>(y) - kMiddle)) /
                           (ViewObstacle::kGrid - 1);
      obstacle.texture[y][x] =
          static_cast<float>(std::clamp(level + rise * along + random.normal(0, contrast), 0.0, 255.0));
    }
  return obstacle;
}

double show_obstacle(const ViewObstacle& obstacle, std::size_t frame, std::span<std::uint8_t> view,
                     int side) {
  if (frame < obstacle.begin || frame >= obstacle.end) return 0;
  const auto since = static_cast<double>(frame - obstacle.begin);
  const auto middle_x = static_cast<float>(obstacle.x + since * obstacle.dx),
             middle_y = static_cast<float>(obstacle.y + since * obstacle.dy);
  const auto c = static_cast<float>(std::cos(obstacle.turn_rad)),
             s = static_cast<float>(std::sin(obstacle.turn_rad));
  const auto along = static_cast<float>(obstacle.long_axis), across = static_cast<float>(obstacle.short_axis);
  const auto sharpness = static_cast<float>(obstacle.short_axis / obstacle.edge);
  const auto gain = static_cast<float>(obstacle.gain);
  double hidden = 0;
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) {
      const float u = (static_cast<float>(column) + 0.5F) / static_cast<float>(side),
                  v = (static_cast<float>(row) + 0.5F) / static_cast<float>(side);
      const float x = u - middle_x, y = v - middle_y;
      const float inside = 1 - std::hypot((c * x + s * y) / along, (c * y - s * x) / across);
      const float cover = std::clamp(0.5F + inside * sharpness, 0.0F, 1.0F);
      if (cover <= 0) continue;
      std::uint8_t& pixel = view[static_cast<std::size_t>(row * side + column)];
      const float shown = texture_at(obstacle, u, v), was = pixel;
      const float is =
          obstacle.is_glare ? was * (1 + cover * (gain - 1)) + cover * shown : std::lerp(was, shown, cover);
      pixel = static_cast<std::uint8_t>(std::clamp(is + 0.5F, 0.0F, 255.0F));
      if (!obstacle.is_glare || pixel >= kSaturated) hidden += double{cover};
    }
  return hidden / (side * side);
}

}  // namespace mien::train
