#include <algorithm>
#include <array>
#include <cmath>

#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/builtin_face/held.h"

// How strangers are drawn: random_identity.
namespace mien::builtin_face {
namespace {

/// A trait's mean and standard deviation.
struct Spread {
  double mean, sigma;
};

// How the traits of five descents spread, in the units of BuiltinParameters. Directions after Farkas et al.
// 2005, "International anthropometric study of facial morphology in various ethnic groups/races", J.
// Craniofac. Surg. 16:615 (noses from about 31 to 44 mm wide, eyes' spacing and lips); of skin after Chardon
// et al. 1991, Int. J. Cosmet. Sci. 13:191; sizes chosen by eye. Within a descent people differ more than
// descents do.

/// European, East and South-East Asian, South Asian, African, Middle Eastern and North African.
template <class Value>
using ByDescent = std::array<Value, 5>;

/// Of people, about the world's (UN World Population Prospects 2022, by region).
constexpr ByDescent<double> kDescentShare = {0.22, 0.30, 0.23, 0.17, 0.08};
constexpr ByDescent<Spread> kAlarWidth = {{{-0.5, 0.7}, {0.4, 0.7}, {0.2, 0.7}, {1.9, 0.8}, {-0.1, 0.7}}};
constexpr ByDescent<Spread> kNoseRoot = {{{0.6, 0.8}, {-1.1, 0.7}, {0.3, 0.8}, {-0.8, 0.7}, {0.8, 0.8}}};
constexpr ByDescent<Spread> kLipProjection = {{{-0.4, 0.7}, {0.1, 0.7}, {0.2, 0.7}, {1.6, 0.8}, {0.0, 0.7}}};
constexpr ByDescent<Spread> kEyeSlant = {{{-0.2, 0.8}, {1.5, 0.8}, {0.3, 0.8}, {0.3, 0.8}, {-0.1, 0.8}}};
constexpr ByDescent<Spread> kEyeFold = {{{-0.7, 0.6}, {1.7, 0.8}, {-0.4, 0.6}, {0.1, 0.7}, {-0.5, 0.6}}};
constexpr ByDescent<Spread> kFaceFullness = {{{0.0, 1.0}, {0.3, 1.0}, {0.0, 1.0}, {0.2, 1.0}, {0.1, 1.0}}};
constexpr ByDescent<Spread> kSkinTone = {
    {{0.12, 0.07}, {0.26, 0.10}, {0.55, 0.13}, {0.84, 0.09}, {0.32, 0.10}}};
constexpr ByDescent<Spread> kHairTone = {
    {{0.48, 0.22}, {0.95, 0.04}, {0.95, 0.04}, {0.98, 0.02}, {0.88, 0.08}}};
/// Shares of those with blue to hazel eyes, red hair, and hair that curls.
constexpr ByDescent<double> kLightEyesShare = {0.62, 0.0, 0.03, 0.0, 0.12};
constexpr ByDescent<double> kRedHairShare = {0.05, 0.0, 0.0, 0.0, 0.005};
constexpr ByDescent<double> kCurlyShare = {0.15, 0.04, 0.12, 0.95, 0.3};
/// Age at which half of these people begin to grey: the mid-thirties, the late thirties and the mid-forties
/// (Panhard, Lozano and Loussouarn 2012, doi:10.1111/j.1365-2133.2012.11095.x).
constexpr ByDescent<double> kGreyFrom_years = {35, 39, 36, 44, 36};

std::size_t draw_descent(Random& random) {
  double left = random.uniform();
  for (std::size_t descent = 0; descent < kDescentShare.size(); ++descent)
    if ((left -= kDescentShare[descent]) < 0) return descent;
  return kDescentShare.size() - 1;
}

double draw(Random& random, const Spread& spread, double low = -2.5, double high = 2.5) {
  return std::clamp(random.normal(spread.mean, spread.sigma), low, high);
}

void draw_shape(BuiltinParameters& p, std::size_t descent, Random& random) {
  p.alar_width = draw(random, kAlarWidth[descent]);
  p.nose_root = draw(random, kNoseRoot[descent]);
  p.lip_projection = draw(random, kLipProjection[descent]);
  p.eye_slant = draw(random, kEyeSlant[descent]);
  p.eye_fold = draw(random, kEyeFold[descent]);
  p.face_fullness = draw(random, kFaceFullness[descent]);
  for (double* value : {&p.jaw_angle, &p.chin_width, &p.nose_tip, &p.philtrum_length, &p.lid_opening,
                        &p.ear_protrusion, &p.forehead_slope, &p.temple_width, &p.brow_fullness})
    *value = draw(random, {0, 1});
}

void draw_colours(BuiltinParameters& p, std::size_t descent, double fair_to_deep, Random& random) {
  // Evenly over two standard deviations to each side: the seed's own place among its people.
  p.skin_tone = std::clamp(
      kSkinTone[descent].mean + std::sqrt(3.0) * (2 * fair_to_deep - 1) * kSkinTone[descent].sigma, 0.0, 1.0);
  p.skin_undertone = draw(random, {0, 0.45}, -1, 1);
  p.hair_tone = draw(random, kHairTone[descent], 0.03, 1);
  p.hair_red = random.chance(kRedHairShare[descent]) ? random.uniform(0.6, 1.0) : 0.0;
  if (p.hair_red > 0) p.hair_tone = std::min(p.hair_tone, 0.35);
  p.eye_tone = random.chance(kLightEyesShare[descent]) ? random.uniform(0, 0.65) : random.uniform(0.75, 1.0);
  // At 45 to 65 years 74 % of people have grey hair, of these 27 % of all hairs (Panhard et al.).
  const double begins = random.normal(kGreyFrom_years[descent], 7);
  p.hair_grey = std::clamp(std::pow(std::max(0.0, p.age_years - begins) / 38, 1.5), 0.0, 1.0);
  const double shadow = random.uniform();
  p.beard = p.sex > 0 ? shadow * std::min(1.0, p.sex) : 0.0;
}

/// Which cut suits whom: most cuts are worn by all, long and tied hair more by women, short and none by men.
HairStyle draw_cut(const BuiltinParameters& p, std::size_t descent, Random& random) {
  const bool man = p.sex > 0;
  std::array<double, kHairStyleCount> weight = {man ? 0.16 + 0.3 * smoothstep(35, 75, p.age_years) : 0.03,
                                                man ? 0.45 : 0.12,
                                                man ? 0.30 : 0.14,
                                                man ? 0.04 : 0.36,
                                                0.0,
                                                man ? 0.05 : 0.30};
  const double curls = kCurlyShare[descent] * (man ? 0.5 : 0.7);
  for (double& w : weight) w *= 1 - curls;
  weight[static_cast<std::size_t>(HairStyle::curls)] = curls;
  if (kCurlyShare[descent] > 0.5)
    for (const HairStyle straight : {HairStyle::swept, HairStyle::bob})
      weight[static_cast<std::size_t>(straight)] = 0;
  double all = 0;
  for (const double w : weight) all += w;
  double left = all * random.uniform();
  for (std::size_t i = 0; i < weight.size(); ++i)
    if ((left -= weight[i]) < 0) return static_cast<HairStyle>(i);
  return HairStyle::crop;
}

}  // namespace

BuiltinParameters random_identity(Random& random) {
  BuiltinParameters p;
  for (double* value :
       {&p.head_width, &p.face_length, &p.jaw_width, &p.chin_size, &p.nose_length, &p.nose_width,
        &p.nose_bridge, &p.eye_spacing, &p.eye_size, &p.mouth_width, &p.lip_fullness, &p.cheekbones,
        &p.cheek_fullness, &p.brow_ridge, &p.brow_height, &p.forehead_height, &p.ear_size, &p.neck_width})
    *value = std::clamp(random.normal(), -2.5, 2.5);
  p.asymmetry = random.uniform(0.4, 1.6);
  p.asymmetry_seed = random.bits() | 1U;
  const double fair_to_deep = random.uniform();
  // Two draws that earlier versions took for hair: who draws on after this person gets what they got.
  random.uniform();
  random.chance(0.5);
  // The rest from streams of their own, so that a seed keeps its eighteen numbers and its asymmetry.
  Random own = Random(p.asymmetry_seed).fork("people");
  const std::size_t descent = draw_descent(own);
  // Adults, fewer the older: about the world's pyramid of ages.
  p.age_years = 18 + 66 * (1 - std::sqrt(own.uniform()));
  const double side = own.chance(0.5) ? 1 : -1;
  p.sex = side * std::clamp(own.normal(1, 0.3), 0.2, 2.0);
  draw_shape(p, descent, own);
  draw_colours(p, descent, fair_to_deep, own);
  Random cut = Random(p.asymmetry_seed).fork("hair");
  p.hair = draw_cut(p, descent, cut);
  return p;
}

}  // namespace mien::builtin_face
