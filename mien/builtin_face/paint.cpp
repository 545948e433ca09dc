#include <algorithm>
#include <cmath>

#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/haircut.h"
#include "mien/builtin_face/mesh.h"

namespace mien::builtin_face {
namespace {

Vec3f blend(const Vec3f& a, const Vec3f& b, double t) {
  return a + static_cast<float>(std::clamp(t, 0.0, 1.0)) * (b - a);
}

double spot(const Vec3& p, double x, double y, double rx, double ry) {
  return gauss(std::hypot((std::abs(p.x()) - x) / rx, (p.y() - y) / ry));
}

}  // namespace

Vec3f hair_colour(double hair_tone) {
  return blend(Vec3f(0.47F, 0.28F, 0.14F), Vec3f(0.013F, 0.0085F, 0.007F),
               std::sqrt(std::clamp(hair_tone, 0.0, 1.0)));
}

void paint(Sculpt& whole, const BuiltinParameters& parameters) {
  const double skin_tone = parameters.skin_tone, hair_tone = parameters.hair_tone;
  // Linear albedo. Tones chosen by eye between very fair and deep skin, flaxen and black hair.
  const Vec3f fair(0.72F, 0.46F, 0.35F), middle(0.42F, 0.22F, 0.135F), deep(0.115F, 0.055F, 0.034F);
  const Vec3f skin =
      skin_tone < 0.5 ? blend(fair, middle, 2 * skin_tone) : blend(middle, deep, 2 * skin_tone - 1);
  const Vec3f hair = hair_colour(hair_tone);
  // Of hair that is shaved off, roots are seen.
  const double roots = parameters.hair == HairStyle::none ? 0.10 : 0.80;
  const Vec3f red(skin.x() * 0.84F, skin.y() * 0.53F, skin.z() * 0.54F);
  const Vec3f wet(0.45F, 0.13F, 0.11F);
  const Vec3f iris = blend(Vec3f(0.10F, 0.19F, 0.24F), Vec3f(0.12F, 0.055F, 0.022F), 1.5 * hair_tone);
  for (SculptVertex& v : whole.vertices) {
    const Vec3& p = v.p;
    switch (v.tissue) {
      case Tissue::skin: {
        Vec3f c = skin;
        const bool front = p.z() > 40;
        if (front) {
          const Vec3f flush(skin.x() * 0.98F, skin.y() * 0.68F, skin.z() * 0.66F);
          c = blend(
              c, flush,
              0.32 * spot(p, 44, -4, 26, 24) + 0.5 * spot(p, 0, 2, 14, 12) + 0.25 * spot(p, 0, -66, 16, 10));
          c = blend(c, skin * 0.72F,
                    0.45 * spot(p, 30, 45, 18, 7) + 0.35 * spot(p, 30, 25, 16, 5));  // about the eyes
          c = blend(c, flush * 0.8F, smoothstep(0.75, 1.0, std::abs(v.lid)) * 0.5);
          c = blend(c, Vec3f(0.10F, 0.03F, 0.02F),
                    1.25 * spot(p, 7.2, -7.8, 2.8, 2.6) * smoothstep(100, 104, p.z()));
          const double x = std::abs(p.x());
          // The border of the lips' red is soft.
          if (x < kMouthCornerX + 3 && std::abs(p.y() - kMouthCornerY) < 20) {
            const double from_lip =
                p.y() > lip_line_y(x) ? p.y() - upper_lip_border_y(x) : lower_lip_border_y(x) - p.y();
            c = blend(c, red,
                      0.55 * gauss(std::max(from_lip, 0.0) / 1.3) *
                          smoothstep(kMouthCornerX + 3, kMouthCornerX - 2, x));
          }
          c = blend(c, hair,
                    0.45 * gauss((p.y() - brow_y(x)) / 4.2) * smoothstep(9, 15, x) * smoothstep(56, 44, x));
        }
        v.colour = blend(c, hair * 0.7F, roots * smoothstep(-4, 9, within_hairline(p)));
        break;
      }
      case Tissue::ear:
        v.colour = blend(skin, Vec3f(skin.x(), skin.y() * 0.7F, skin.z() * 0.66F), 0.6);
        break;
      case Tissue::lip:
        v.colour = red;
        break;
      case Tissue::mouth:
        v.colour = blend(red, Vec3f(0.22F, 0.045F, 0.04F), smoothstep(112, 100, p.z()));
        break;
      case Tissue::lid_inside:
        v.colour =
            blend(blend(skin, wet, 0.55), hair * 0.5F, v.lid > 0 ? 0.75 * smoothstep(0.3, 0.9, v.lid) : 0.15);
        break;
      case Tissue::tear:
        v.colour = Vec3f::Ones();
        break;
      case Tissue::caruncle:
        v.colour = Vec3f(0.58F, 0.25F, 0.22F);
        break;
      case Tissue::eyeball: {
        const int band = static_cast<int>(v.lid);
        const double t = v.lid - band;
        if (band == 0) {
          v.colour = Vec3f::Constant(0.006F);
        } else if (band == 1) {
          v.colour = blend(iris * 1.5F, iris * 0.35F, smoothstep(0.45, 1.0, t));
        } else {
          const Vec3 centre(p.x() > 0 ? kEyeCentre.x() : -kEyeCentre.x(), kEyeCentre.y(), kEyeCentre.z());
          v.colour = blend(Vec3f(0.80F, 0.79F, 0.76F), Vec3f(0.62F, 0.36F, 0.32F),
                           smoothstep(9.5, 13.0, std::abs(p.x() - centre.x())));
        }
        break;
      }
      case Tissue::teeth_upper:
      case Tissue::teeth_lower:
        v.colour = Vec3f(0.78F, 0.74F, 0.64F);
        break;
      case Tissue::gums_upper:
      case Tissue::gums_lower:
        v.colour = Vec3f(0.50F, 0.16F, 0.15F);
        break;
      case Tissue::tongue:
        v.colour = Vec3f(0.52F, 0.17F, 0.16F);
        break;
      case Tissue::lash:
        v.colour = hair * 0.3F;
        break;
      case Tissue::brow:
        v.colour = hair.cwiseProduct(v.colour) * 0.8F;
        break;
      case Tissue::cloth:
        v.colour = Vec3f(0.045F, 0.055F, 0.075F);
        break;
    }
  }
}

}  // namespace mien::builtin_face
