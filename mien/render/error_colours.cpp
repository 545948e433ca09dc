#include "mien/render/error_colours.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mien/render/tone.h"

namespace mien::render {
namespace {

/// OKLab to linear sRGB. Source: Ottosson 2020, "A perceptual color space for image processing".
Vec3f linear_from_oklab(const Vec3f& lab) {
  const float l = lab[0] + 0.3963377774F * lab[1] + 0.2158037573F * lab[2];
  const float m = lab[0] - 0.1055613458F * lab[1] - 0.0638541728F * lab[2];
  const float s = lab[0] - 0.0894841775F * lab[1] - 1.2914855480F * lab[2];
  const Vec3f c(l * l * l, m * m * m, s * s * s);
  return Vec3f(4.0767416621F * c[0] - 3.3077115913F * c[1] + 0.2309699292F * c[2],
               -1.2684380046F * c[0] + 2.6097574011F * c[1] - 0.3413193965F * c[2],
               -0.0041960863F * c[0] - 0.7034186147F * c[1] + 1.7076147010F * c[2])
      .cwiseMax(0.0F)
      .cwiseMin(1.0F);
}

}  // namespace

Vec3f error_colour(float fraction) {
  // Lightness, chroma, hue in degrees; lightness is even, hue goes from sand over orange and red to violet.
  static constexpr std::array<std::array<float, 3>, 6> kStops = {{{0.90F, 0.02F, 95},
                                                                  {0.79F, 0.10F, 85},
                                                                  {0.68F, 0.15F, 55},
                                                                  {0.57F, 0.18F, 28},
                                                                  {0.46F, 0.17F, 0},
                                                                  {0.35F, 0.15F, -50}}};
  const float x = std::clamp(std::isfinite(fraction) ? fraction : 1.0F, 0.0F, 1.0F) * (kStops.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(x), kStops.size() - 2);
  const float t = x - static_cast<float>(i);
  std::array<float, 3> lch{};
  for (std::size_t c = 0; c < 3; ++c) lch[c] = kStops[i][c] + t * (kStops[i + 1][c] - kStops[i][c]);
  const float hue_rad = lch[2] * 0.017453293F;
  return linear_from_oklab({lch[0], lch[1] * std::cos(hue_rad), lch[1] * std::sin(hue_rad)});
}

void draw_error_legend(Image& picture, const Lettering& lettering, float full_scale_m, Rgb ink) {
  const float text = std::max(11.0F, 0.026F * static_cast<float>(picture.height));
  const int bar_height = std::max(5, static_cast<int>(0.55F * text));
  const int width = std::min(picture.width * 6 / 10, 420);
  const int left = (picture.width - width) / 2;
  const int top = picture.height - bar_height - static_cast<int>(2.3F * text);
  // A plate behind it, of the ink's opposite: a pale shoulder may stand there.
  const int margin = static_cast<int>(1.6F * text);
  for (int y = std::max(0, top - margin / 2); y < picture.height; ++y)
    for (int x = std::max(0, left - margin); x < std::min(picture.width, left + width + 2 * margin); ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        std::uint8_t& value = picture.pixel(x, y)[c];
        value = static_cast<std::uint8_t>((value + 3 * (ink[c] > 128 ? 18 : 242)) / 4);
      }
  for (int x = 0; x < width && width > 1; ++x) {
    const Rgb colour = to_srgb(error_colour(static_cast<float>(x) / static_cast<float>(width - 1)));
    for (int y = std::max(0, top); y < std::min(picture.height, top + bar_height); ++y)
      std::copy(colour.begin(), colour.end(), picture.pixel(left + x, y));
  }
  const float baseline = static_cast<float>(top + bar_height) + 1.35F * text;
  const float full_mm = 1000 * full_scale_m;
  const auto label = [&](float part, const std::string& words) {
    lettering.draw(picture, words, static_cast<float>(left) + part * static_cast<float>(width), baseline,
                   text, ink, Align::centre);
  };
  label(0, "0");
  label(0.5F, fmt::format("{:.3g}", 0.5F * full_mm));
  label(1, fmt::format("{:.3g} mm", full_mm));
}

}  // namespace mien::render
