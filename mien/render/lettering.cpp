#include "mien/render/lettering.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace mien::render {
namespace {

using Eigen::Vector2f;

/// Strokes of the characters from '!' to '~', parted by spaces. A stroke is pairs of digits x y on a grid
/// where y 2 is the baseline, 6 a small letter's height and 8 a capital's; '~' before it makes a curve
/// through its points, 'o' a closed one.
constexpr std::array<std::string_view, 94> kGlyphs = {
    "0804 0202", "0806 2826", "1218 3238 0444 0646", "~47280725432203 2921", "4802 o18271607 o34433223",
    "~4216283704123344", "0806", "~19070311", "~09171301", "2824 0745 0547", "2327 0545", "1201", "0535",
    "0202", "0148",
    // Digits.
    "o284644220406", "072822", "~0728473502 0242", "~07284725 ~2544432203", "32380444", "480805 ~0526442203",
    "~38170504 o26442204", "084812", "o284746250607 o254443220304", "o28462406 ~46453312", "0505 0202",
    "1515 1201", "470543", "0646 0444", "074503", "~0728472524 2222", "~42220406284644342536",
    // Capitals.
    "022842 1434", "0208 ~082837362505 ~052544432202", "~472806042243", "0208 ~082846442202", "48080242 0535",
    "480802 0535", "~472806042243 434525", "0802 4842 0545", "0802", "3834 ~34331203", "0802 4804 1542",
    "080242", "0208244842", "02084248", "o2838565432220406", "0208 ~082847462505", "o2838565432220406 3452",
    "0208 ~082847462505 2542", "~47280725432203", "0848 2822", "0804 ~04123244 4448", "082248", "0812263248",
    "0842 4802", "082548 2522", "08480242", "19090111", "0841", "09191101", "062846", "0141", "0817",
    // Small letters.
    "o162634221204 3632", "0802 o162634221204", "~35261604122233", "o162634221204 3832",
    "0434 ~3435261604122233", "~38281715 1512 0626", "o162634221204 3632 ~3231201001",
    "0802 ~0415263534 3432", "0602 0808", "161100 1818", "0802 3604 1532", "080312",
    "0602 ~04162524 2422 ~24364544 4442", "0602 ~0415263534 3432", "o162634221204", "0600 o162634221204",
    "o162634221204 3630", "0602 ~041626", "~35261605142433221203", "1813 ~132232 0626",
    "0604 ~0403122234 3632", "062246", "0612253246", "0632 3602", "0622 4610", "06360232", "29181605141221",
    "0901", "09181625141201", "~04153445"};
constexpr std::string_view kUnknown = "02084842 0242";
constexpr float kCapitals = 0.7F;  // Height of capitals over the size of the line.
constexpr float kSpace = 3.0F;     // Grid units.
constexpr float kBetween = 1.7F;   // Grid units.

struct Glyph {
  std::vector<std::array<Vector2f, 2>> pieces;  // Grid units, y upwards from the baseline.
  float width = 0;
};

std::string_view strokes_of(char c) {
  return c > ' ' && c <= '~' ? kGlyphs[static_cast<std::size_t>(c - '!')] : kUnknown;
}

Glyph glyph_of(char c) {
  Glyph glyph;
  if (c == ' ') return {{}, kSpace - kBetween};
  std::string_view rest = strokes_of(c);
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    std::string_view stroke = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    const bool closed = stroke.starts_with('o'), curved = closed || stroke.starts_with('~');
    if (curved) stroke.remove_prefix(1);
    std::vector<Vector2f> points;
    for (std::size_t i = 0; i + 1 < stroke.size(); i += 2) {
      points.emplace_back(static_cast<float>(stroke[i] - '0'), static_cast<float>(stroke[i + 1] - '0') - 2);
      glyph.width = std::max(glyph.width, points.back().x());
    }
    const auto n = static_cast<int>(points.size());
    const auto at = [&](int i) {
      return points[static_cast<std::size_t>(closed ? (i + n) % n : std::clamp(i, 0, n - 1))];
    };
    if (n == 1) glyph.pieces.push_back({points[0], points[0]});
    for (int i = 0; i < (closed ? n : n - 1); ++i) {
      const int cuts = curved ? 6 : 1;
      const auto on = [&](float t) -> Vector2f {
        const Vector2f p = at(i - 1), a = at(i), b = at(i + 1), q = at(i + 2);
        if (!curved) return a + t * (b - a);
        return 0.5F * (2 * a + t * (b - p) + t * t * (2 * p - 5 * a + 4 * b - q) +
                       t * t * t * (3 * a - p - 3 * b + q));
      };
      for (int k = 0; k < cuts; ++k)
        glyph.pieces.push_back({on(static_cast<float>(k) / static_cast<float>(cuts)),
                                on(static_cast<float>(k + 1) / static_cast<float>(cuts))});
    }
  }
  return glyph;
}

float distance_to(const std::array<Vector2f, 2>& piece, const Vector2f& p) {
  const Vector2f d = piece[1] - piece[0];
  const float length2 = d.squaredNorm();
  const float t = length2 > 0 ? std::clamp((p - piece[0]).dot(d) / length2, 0.0F, 1.0F) : 0.0F;
  return (p - piece[0] - t * d).norm();
}

}  // namespace

float text_width(std::string_view text, float size_px) {
  float units = 0;
  for (const char c : text) units += glyph_of(c).width + kBetween;
  return text.empty() ? 0 : (units - kBetween) * kCapitals * size_px / 6;
}

void draw_text(Image& picture, std::string_view text, float x, float baseline, float size_px, Rgb ink,
               Align align) {
  const float unit = kCapitals * size_px / 6;
  const float half_stroke = std::max(0.55F, 0.042F * size_px);
  if (align == Align::centre) x -= 0.5F * text_width(text, size_px);
  if (align == Align::right) x -= text_width(text, size_px);
  for (const char c : text) {
    const Glyph glyph = glyph_of(c);
    const auto reach = static_cast<int>(std::ceil(half_stroke)) + 1;
    const int left = std::max(0, static_cast<int>(x) - reach);
    const int right = std::min(picture.width, static_cast<int>(x + glyph.width * unit) + reach + 1);
    const int top = std::max(0, static_cast<int>(baseline - 7 * unit) - reach);
    const int bottom = std::min(picture.height, static_cast<int>(baseline + 2 * unit) + reach + 1);
    for (int py = top; py < bottom; ++py)
      for (int px = left; px < right; ++px) {
        const Vector2f p((static_cast<float>(px) + 0.5F - x) / unit,
                         (baseline - static_cast<float>(py) - 0.5F) / unit);
        float nearest = 1e9F;
        for (const auto& piece : glyph.pieces) nearest = std::min(nearest, distance_to(piece, p));
        const float cover = std::clamp(half_stroke + 0.5F - nearest * unit, 0.0F, 1.0F);
        if (cover <= 0) continue;
        std::uint8_t* out = picture.pixel(px, py);
        for (std::size_t k = 0; k < 3; ++k)
          out[k] = static_cast<std::uint8_t>(
              static_cast<float>(out[k]) + cover * (static_cast<float>(ink[k]) - static_cast<float>(out[k])) +
              0.5F);
      }
    x += (glyph.width + kBetween) * unit;
  }
}

}  // namespace mien::render
