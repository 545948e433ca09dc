#include <algorithm>
#include <cmath>
#include <vector>

#include "mien/builtin_face/albedo.h"
#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/haircut.h"
#include "mien/builtin_face/mesh.h"

namespace mien::builtin_face {
namespace {

double spot(const Vec3& p, double x, double y, double rx, double ry) {
  return gauss(std::hypot((std::abs(p.x()) - x) / rx, (p.y() - y) / ry));
}

}  // namespace

double beard_amount(const Vec3& p) {
  const double x = std::abs(p.x());
  // Its upper edge: below the nose in the middle, then down past the mouth's corner and up to the ear.
  const double edge = x < 30 ? mix(-15, -31, smoothstep(10, 30, x)) : mix(-31, 16, smoothstep(30, 72, x));
  const double face = smoothstep(edge + 3, edge - 5, p.y()) * smoothstep(6, 26, p.z());
  return face * smoothstep(-112, -88, p.y());
}

std::vector<Vec3f> paint(const Sculpt& whole, const BuiltinParameters& parameters, const Albedos& a) {
  // Of hair that is shaved off, roots are seen.
  const double roots = parameters.hair == HairStyle::none ? 0.10 : 0.80;
  const double beard = std::clamp(parameters.beard, 0.0, 1.0);
  const double brow_height = 4.2 * brow_spread(parameters.brow_fullness);
  std::vector<Vec3f> colours(whole.vertices.size());
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const SculptVertex& v = whole.vertices[i];
    Vec3f& colour = colours[i];
    const Vec3& p = v.p;
    switch (v.tissue) {
      case Tissue::skin: {
        Vec3f c = a.skin;
        const bool front = p.z() > 40;
        if (front) {
          c = blend(
              c, a.flush,
              0.32 * spot(p, 44, -4, 26, 24) + 0.5 * spot(p, 0, 2, 14, 12) + 0.25 * spot(p, 0, -66, 16, 10));
          c = blend(c, a.skin * a.eye_shadow,
                    0.45 * spot(p, 30, 45, 18, 7) + 0.35 * spot(p, 30, 25, 16, 5));  // about the eyes
          c = blend(c, a.flush * (0.08F + a.eye_shadow), smoothstep(0.75, 1.0, std::abs(v.lid)) * 0.5);
          c = blend(c, a.nostril, 1.25 * spot(p, 7.2, -7.8, 2.8, 2.6) * smoothstep(100, 104, p.z()));
          const double x = std::abs(p.x());
          // The border of the lips' red is soft.
          if (x < kMouthCornerX + 3 && std::abs(p.y() - kMouthCornerY) < 20) {
            const double from_lip =
                p.y() > lip_line_y(x) ? p.y() - upper_lip_border_y(x) : lower_lip_border_y(x) - p.y();
            c = blend(c, a.lips,
                      0.55 * gauss(std::max(from_lip, 0.0) / 1.3) *
                          smoothstep(kMouthCornerX + 3, kMouthCornerX - 2, x));
          }
          c = blend(
              c, a.brow,
              0.55 * gauss((p.y() - brow_y(x)) / brow_height) * smoothstep(9, 15, x) * smoothstep(56, 44, x));
        }
        // Roots under the skin are darker than it, grey ones too.
        if (beard > 0) c = blend(c, (0.6F * a.hair).cwiseMin(0.5F * a.skin), 0.4 * beard * beard_amount(p));
        colour = blend(c, a.hair * 0.7F, roots * smoothstep(0, 14, within_hairline(p)));
        break;
      }
      case Tissue::ear:
        colour = blend(a.skin, a.flush, 0.6);
        break;
      case Tissue::lip:
        colour = a.lips;
        break;
      case Tissue::mouth:
        colour = blend(a.lips, a.mouth, smoothstep(115, 104, p.z()));
        break;
      case Tissue::lid_inside:
        colour = blend(blend(a.skin, a.wet, 0.55), a.lash * 1.7F,
                       v.lid > 0 ? 0.5 * smoothstep(0.3, 0.9, v.lid) : 0.0);
        break;
      case Tissue::tear:
        colour = Vec3f::Ones();  // Clear.
        break;
      case Tissue::caruncle:
        colour = a.caruncle;
        break;
      case Tissue::eyeball: {
        const int band = static_cast<int>(v.lid);
        const double t = v.lid - band;
        if (band == 0) {
          colour = a.pupil;
        } else if (band == 1) {
          colour = blend(a.iris * 1.5F, a.iris * 0.35F, smoothstep(0.45, 1.0, t));
        } else {
          const double centre_x = p.x() > 0 ? kEyeCentre.x() : -kEyeCentre.x();
          colour = blend(a.sclera, a.sclera_corner, smoothstep(9.5, 13.0, std::abs(p.x() - centre_x)));
        }
        break;
      }
      case Tissue::teeth_upper:
      case Tissue::teeth_lower:
        // Less light finds its way to the back ones than rays at single vertices say.
        colour = a.teeth * static_cast<float>(mix(0.10, 1.0, smoothstep(82, 100, p.z())));
        break;
      case Tissue::gums_upper:
      case Tissue::gums_lower:
        colour = a.gums;
        break;
      case Tissue::tongue:
        colour = a.tongue;
        break;
      case Tissue::lash:
        colour = a.lash;
        break;
      case Tissue::brow:
        colour = a.brow.cwiseProduct(v.colour);
        break;
      case Tissue::cloth:
        colour = a.cloth;
        break;
    }
  }
  return colours;
}

}  // namespace mien::builtin_face
