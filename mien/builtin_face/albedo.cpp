#include "mien/builtin_face/albedo.h"

#include <cmath>

#include "mien/builtin_face/anatomy.h"

namespace mien::builtin_face {
namespace {

// Visible tones were chosen by eye between very fair and deep skin, flaxen and black hair.
const Vec3f kFairSkin(0.72F, 0.46F, 0.35F), kMiddleSkin(0.42F, 0.22F, 0.135F),
    kDeepSkin(0.115F, 0.055F, 0.034F);
const Vec3f kFlaxen(0.47F, 0.28F, 0.14F), kBlack(0.013F, 0.0085F, 0.007F), kRedHair(0.30F, 0.085F, 0.028F);
/// Hair without pigment.
const Vec3f kWhiteHair(0.62F, 0.61F, 0.59F);
const Vec3f kBlueIris(0.095F, 0.165F, 0.235F), kHazelIris(0.125F, 0.115F, 0.05F),
    kBrownIris(0.075F, 0.034F, 0.014F);

Vec3f grey(double reflectance) {
  return Vec3f::Constant(static_cast<float>(reflectance));
}

Vec3f skin_colour(const BuiltinParameters& q) {
  Vec3f skin = q.skin_tone < 0.5 ? blend(kFairSkin, kMiddleSkin, 2 * q.skin_tone)
                                 : blend(kMiddleSkin, kDeepSkin, 2 * q.skin_tone - 1);
  const auto rosy = static_cast<float>(std::clamp(q.skin_undertone, -1.0, 1.0));
  skin = skin.cwiseProduct(Vec3f(1 + 0.02F * rosy, 1 - 0.05F * rosy, 1 + 0.05F * rosy));
  return skin.cwiseMin(1.0F);
}

Vec3f hair_colour(const BuiltinParameters& q, double grey_share) {
  Vec3f hair = blend(kFlaxen, kBlack, std::sqrt(std::clamp(q.hair_tone, 0.0, 1.0)));
  hair = blend(hair, kRedHair, q.hair_red * (1 - 0.7 * q.hair_tone));
  return blend(hair, kWhiteHair, grey_share);
}

Vec3f iris_colour(double tone) {
  return tone < 0.5 ? blend(kBlueIris, kHazelIris, 2 * tone) : blend(kHazelIris, kBrownIris, 2 * tone - 1);
}

}  // namespace

Albedos visible_albedos(const BuiltinParameters& q) {
  Albedos a;
  a.skin = skin_colour(q);
  a.flush = a.skin.cwiseProduct(Vec3f(0.98F, 0.68F, 0.66F));
  // Lips pale with age.
  const double pale = 0.35 * smoothstep(40, 85, q.age_years);
  a.lips = blend(a.skin.cwiseProduct(Vec3f(0.84F, 0.53F, 0.54F)), a.skin, pale);
  a.mouth = Vec3f(0.22F, 0.045F, 0.04F);
  a.wet = Vec3f(0.45F, 0.13F, 0.11F);
  a.nostril = Vec3f(0.10F, 0.03F, 0.02F);
  a.hair = hair_colour(q, q.hair_grey);
  // Brows keep their pigment longer than the scalp, lashes nearly for good.
  a.brow = 0.8F * hair_colour(q, 0.45 * q.hair_grey);
  a.lash = 0.3F * hair_colour(q, 0.1 * q.hair_grey);
  a.iris = iris_colour(q.eye_tone);
  a.pupil = Vec3f::Constant(0.006F);
  a.sclera = Vec3f(0.80F, 0.79F, 0.76F);
  a.sclera_corner = Vec3f(0.62F, 0.36F, 0.32F);
  a.caruncle = Vec3f(0.58F, 0.25F, 0.22F);
  a.teeth = Vec3f(0.78F, 0.74F, 0.64F);
  a.gums = Vec3f(0.50F, 0.16F, 0.15F);
  a.tongue = Vec3f(0.52F, 0.17F, 0.16F);
  a.cloth = Vec3f(0.045F, 0.055F, 0.075F);
  return a;
}

Albedos infrared_albedos(const BuiltinParameters& q) {
  Albedos a;
  // Of 100 volunteers of all tones, skin reflects 0.5 to 0.7 at 850 nm (Cooksey, Allen and Tsai 2017,
  // "Reference data set of human skin reflectance", doi:10.6028/jres.122.026).
  const double skin = mix(0.68, 0.50, std::clamp(q.skin_tone, 0.0, 1.0));
  a.skin = grey(skin);
  a.flush = grey(0.97 * skin);
  a.lips = grey(0.90 * skin);
  a.mouth = grey(0.30);
  a.wet = grey(0.55);
  a.nostril = grey(0.16);
  // Eumelanin still absorbs: black hair is dark grey, fair hair bright; pheomelanin is all but clear.
  const double tone = std::sqrt(std::clamp(q.hair_tone, 0.0, 1.0));
  const double pigmented = mix(mix(0.56, 0.085, tone), 0.40, q.hair_red * (1 - 0.7 * q.hair_tone));
  const double hair = mix(pigmented, 0.62, q.hair_grey);
  a.hair = grey(hair);
  a.brow = grey(0.55 * mix(pigmented, hair, 0.45));
  a.lash = grey(0.22 * pigmented);
  // In near infrared blue and brown irises look alike: the stroma scatters and its melanin hardly absorbs.
  a.iris = grey(mix(0.20, 0.15, q.eye_tone));
  a.pupil = grey(0.004);  // The light stands beside the lens: no red-eye.
  a.sclera = grey(0.62);
  a.sclera_corner = grey(0.58);
  a.caruncle = grey(0.53);
  a.teeth = grey(0.62);
  a.gums = grey(0.50);
  a.tongue = grey(0.48);
  a.cloth = grey(0.22);  // Many dark dyes are clear in infrared.
  a.eye_shadow = 0.93F;
  return a;
}

}  // namespace mien::builtin_face
