#include "mien/builtin_face/builtin_face.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "mien/builtin_face/albedo.h"
#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/expression.h"
#include "mien/builtin_face/haircut.h"
#include "mien/builtin_face/held.h"
#include "mien/builtin_face/identity.h"
#include "mien/builtin_face/mesh.h"
#include "mien/face/profile_map.h"

namespace mien::builtin_face {
namespace {

struct PieceInfo {
  const char* name;
  face::Material material;
};
constexpr PieceInfo kPieces[kPieceCount] = {
    {"skin", face::Material::skin},       {"ears", face::Material::skin},
    {"lips", face::Material::lips},       {"mouth", face::Material::mouth_inside},
    {"lids", face::Material::skin},       {"tears", face::Material::cornea},
    {"caruncles", face::Material::gums},  {"sclera_L", face::Material::sclera},
    {"iris_L", face::Material::iris},     {"pupil_L", face::Material::pupil},
    {"sclera_R", face::Material::sclera}, {"iris_R", face::Material::iris},
    {"pupil_R", face::Material::pupil},   {"teeth_upper", face::Material::teeth},
    {"gums_upper", face::Material::gums}, {"teeth_lower", face::Material::teeth},
    {"gums_lower", face::Material::gums}, {"tongue", face::Material::tongue},
    {"lashes", face::Material::strands},  {"brows", face::Material::strands},
    {"shirt", face::Material::cloth},
};

/// The vertices that a shape moves on the default head, and where to at weight 1, mm.
struct Moved {
  std::vector<std::uint32_t> vertex;
  std::vector<Vec3> to;
};

/// The default head, sculpted once.
struct DefaultHead {
  Sculpt sculpt;
  std::vector<Moved> moved;  // By shape; tongueOut last.
  std::array<std::uint32_t, 68> landmarks{};
  std::vector<face::Region> regions;
};

const DefaultHead& default_head() {
  static const DefaultHead head = [] {
    DefaultHead h;
    Sculpt half;
    add_skin(half);
    add_ear(half);
    add_mouth_parts(half);
    add_brows_and_lashes(half);
    add_shirt(half);
    h.sculpt = mirrored(half);
    add_eyeballs(h.sculpt);
    h.moved.resize(face::kShapeCount + 1);
    sculpt_shapes(h.sculpt, [&h](std::size_t shape, std::span<const Vec3> displacement) {
      Moved& moved = h.moved[shape];
      for (std::uint32_t i = 0; i < displacement.size(); ++i)
        if (displacement[i].squaredNorm() >= 2.5e-5) moved.vertex.push_back(i);  // 5 micrometres
      moved.to.reserve(moved.vertex.size());
      for (const std::uint32_t i : moved.vertex) moved.to.push_back(h.sculpt.vertices[i].p + displacement[i]);
    });
    h.landmarks = find_landmarks(h.sculpt);
    h.regions = find_regions(h.sculpt);
    return h;
  }();
  return head;
}

/// Hair comes last: all other vertices keep their numbers whatever the style.
void add_hair(face::Face& face, const Haircut& hair, const IdentityWarp& warp) {
  if (hair.triangles.empty()) return;
  const auto first = static_cast<std::uint32_t>(face.neutral_m.size());
  for (const Vec3& p : hair.p) face.neutral_m.push_back((warp(p) / 1000).cast<float>());
  face.uv.insert(face.uv.end(), hair.uv.begin(), hair.uv.end());
  face.parts.push_back({"hair", face::Material::strands, static_cast<std::uint32_t>(face.triangles.size()),
                        static_cast<std::uint32_t>(hair.triangles.size())});
  for (const auto& [a, b, c] : hair.triangles) face.triangles.push_back({first + a, first + b, first + c});
}

/// Colours of every vertex, hair last.
std::vector<Vec3f> colours_of(const BuiltinParameters& parameters, const Albedos& albedos) {
  std::vector<Vec3f> colours = paint(default_head().sculpt, leaning(parameters), albedos);
  for (const float shade : haircut(parameters.hair).shade)
    colours.push_back((albedos.hair * shade).cwiseMin(1.0F));
  return colours;
}

/// Lids at rest are a part of the way to closing: how much of it, and where that puts each vertex (mm).
struct RestingLids {
  double share = 0;
  std::vector<Vec3> shift;
};
RestingLids resting_lids(const DefaultHead& head, double lid_opening) {
  RestingLids lids{.share = std::clamp(-0.05 * lid_opening, -0.06, 0.15),
                   .shift = std::vector<Vec3>(head.sculpt.vertices.size(), Vec3::Zero())};
  for (const std::size_t shape : {face::shape("eyeBlink_L"), face::shape("eyeBlink_R")}) {
    const Moved& moved = head.moved[shape];
    for (std::size_t i = 0; i < moved.to.size(); ++i)
      lids.shift[moved.vertex[i]] += lids.share * (moved.to[i] - head.sculpt.vertices[moved.vertex[i]].p);
  }
  return lids;
}

/// Where fuller brows put a hair that grows at `anchor`, mm.
Vec3 brow_shift(const SculptVertex& v, double brow_fullness) {
  if (v.tissue != Tissue::brow) return Vec3::Zero();
  const double from_middle = v.anchor.y() - brow_y(std::abs(v.anchor.x()));
  return {0, (brow_spread(brow_fullness) - 1) * from_middle, 0};
}

}  // namespace

const Sculpt& default_sculpt() {
  return default_head().sculpt;
}

void paint_infrared(face::Face& face, const BuiltinParameters& parameters) {
  face.colour = colours_of(parameters, infrared_albedos(held(parameters)));
}

BuiltinParameters without_hair(BuiltinParameters parameters) {
  parameters.hair = HairStyle::none;
  return parameters;
}

face::Face make_builtin(const BuiltinParameters& parameters) {
  const DefaultHead& head = default_head();
  const Sculpt& sculpt = head.sculpt;
  const Haircut& hair = haircut(parameters.hair);
  face::Face face;
  face.name = "builtin";
  face.origin = face::Origin::builtin;
  const std::size_t n = sculpt.vertices.size();
  face.neutral_m.reserve(n + hair.p.size());
  face.uv.reserve(n + hair.p.size());
  const IdentityWarp warp(parameters);
  const RestingLids lids = resting_lids(head, warp.numbers().lid_opening);
  const auto shift = [&](std::size_t i) {
    return Vec3(lids.shift[i] + brow_shift(sculpt.vertices[i], warp.numbers().brow_fullness));
  };
  std::vector<Vec3> neutral_mm;
  neutral_mm.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    const SculptVertex& v = sculpt.vertices[i];
    neutral_mm.push_back(v.tissue == Tissue::ear ? warp.ear(v.p) : warp(v.p + shift(i)));
    face.neutral_m.push_back((neutral_mm.back() / 1000).cast<float>());
    face.uv.push_back(v.uv);
  }
  std::size_t triangles = hair.triangles.size();
  for (const auto& piece : sculpt.triangles) triangles += piece.size();
  face.triangles.reserve(triangles);
  for (std::size_t k = 0; k < kPieceCount; ++k) {
    face.parts.push_back({kPieces[k].name, kPieces[k].material,
                          static_cast<std::uint32_t>(face.triangles.size()),
                          static_cast<std::uint32_t>(sculpt.triangles[k].size())});
    face.triangles.insert(face.triangles.end(), sculpt.triangles[k].begin(), sculpt.triangles[k].end());
  }
  add_hair(face, hair, warp);
  face.colour = colours_of(parameters, visible_albedos(held(parameters)));
  for (std::size_t k = 0; k <= face::kShapeCount; ++k) {
    face::Shape shape;
    shape.name = face::inner_name(k);
    const Moved& moved = head.moved[k];
    shape.vertex = moved.vertex;
    shape.delta_m.reserve(moved.to.size());
    // What closes lids has less way to go from where they rest.
    const double done = shape.name.starts_with("eyeBlink") ? lids.share : 0;
    for (std::size_t i = 0; i < moved.to.size(); ++i) {
      const std::size_t v = moved.vertex[i];
      const Vec3 to = moved.to[i] + shift(v) - done * (moved.to[i] - sculpt.vertices[v].p);
      shape.delta_m.push_back(((warp(to) - neutral_mm[v]) / 1000).cast<float>());
    }
    face.shapes.push_back(std::move(shape));
  }
  face.landmarks = head.landmarks;
  face.has_landmarks = true;
  face.regions = head.regions;
  face.eyes = sculpt.eyes;
  for (face::Eyeball& eye : face.eyes)
    eye.centre_m = (warp(eye.centre_m.cast<double>()) / 1000).cast<float>();
  return face;
}

std::array<BuiltinSite, 12> builtin_sites() {
  // Where the same muscles lie on this head, measured on it once.
  constexpr double kMm = 1e-3;
  const Vec3 frontalis(35.1, 71.7, 95.8), orbicularis(51.7, 23.4, 85.9), upper(41.6, 6.9, 94.2),
      lower(34.7, -19, 99.9), buccinator(39.3, -36.5, 94.1), mentalis(0, -68.6, 109.3),
      mastoid(62.9, -7, -18.1);
  return {{{"frontalis_R", flip(frontalis) * kMm},
           {"frontalis_L", frontalis * kMm},
           {"orbicularis_R", flip(orbicularis) * kMm},
           {"orbicularis_L", orbicularis * kMm},
           {"zygomaticus_upper_R", flip(upper) * kMm},
           {"zygomaticus_upper_L", upper * kMm},
           {"zygomaticus_lower_R", flip(lower) * kMm},
           {"zygomaticus_lower_L", lower * kMm},
           {"buccinator_R", flip(buccinator) * kMm},
           {"buccinator_L", buccinator * kMm},
           {"mentalis", mentalis * kMm},
           {"mastoid_L", mastoid * kMm}}};
}

const face::Face& default_builtin() {
  static const face::Face face = make_builtin();
  return face;
}

}  // namespace mien::builtin_face
