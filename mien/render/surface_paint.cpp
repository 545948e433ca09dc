#include "mien/render/surface_paint.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mien/core/smoothstep.h"
#include "mien/face/surface_point.h"
#include "mien/render/skin_detail.h"
#include "mien/render/solid_noise.h"
#include "mien/render/tone.h"

namespace mien::render {
namespace {

using Eigen::Vector2f;
using face::Material;

// All paint was chosen by eye on rendered faces.
const Vec3f kSkin(0.60F, 0.365F, 0.265F);
const Vec3f kLips(0.47F, 0.165F, 0.145F);
const Vec3f kHair(0.055F, 0.035F, 0.025F);
const Vec3f kSclera(0.62F, 0.575F, 0.55F);

/// Lips' colour ends so far outside their outline.
constexpr float kLipEdge_m = 0.0012F;

/// A smooth curve through `points` (Catmull-Rom), eight pieces between two.
std::vector<Vector2f> smooth_curve(const std::vector<Vector2f>& points, bool closed) {
  constexpr int kPieces = 8;
  const auto n = static_cast<int>(points.size());
  const auto at = [&](int i) {
    return closed ? points[static_cast<std::size_t>((i + n) % n)]
                  : points[static_cast<std::size_t>(std::clamp(i, 0, n - 1))];
  };
  std::vector<Vector2f> curve;
  for (int i = 0; i < (closed ? n : n - 1); ++i)
    for (int j = 0; j < kPieces; ++j) {
      const float t = static_cast<float>(j) / kPieces;
      const Vector2f a = at(i - 1), b = at(i), c = at(i + 1), d = at(i + 2);
      curve.push_back(0.5F * (2 * b + t * (c - a) + t * t * (2 * a - 5 * b + 4 * c - d) +
                              t * t * t * (3 * b - a - 3 * c + d)));
    }
  if (!closed) curve.push_back(points.back());
  return curve;
}

struct Nearest {
  float distance = std::numeric_limits<float>::max();
  float along = 0;  // 0 at the curve's start, 1 at its end.
};

Nearest nearest_on(const std::vector<Vector2f>& curve, const Vector2f& p, bool closed) {
  Nearest best;
  float least = best.distance;  // Squared.
  const std::size_t n = curve.size();
  const std::size_t pieces = closed ? n : n - 1;
  for (std::size_t i = 0; i < pieces; ++i) {
    const Vector2f a = curve[i], d = curve[(i + 1) % n] - a;
    const float length2 = d.squaredNorm();
    const float t = length2 > 0 ? std::clamp((p - a).dot(d) / length2, 0.0F, 1.0F) : 0.0F;
    const float square = (p - a - t * d).squaredNorm();
    if (square >= least) continue;
    least = square;
    best.along = (static_cast<float>(i) + t) / static_cast<float>(pieces);
  }
  best.distance = std::sqrt(least);
  return best;
}

}  // namespace

std::vector<Material> material_of_triangles(const face::Face& face) {
  std::vector<Material> all(face.triangles.size(), Material::skin);
  for (const face::Part& part : face.parts)
    for (std::size_t t = part.first_triangle;
         t < std::min(all.size(), std::size_t{part.first_triangle} + part.triangle_count); ++t)
      all[t] = part.material;
  return all;
}

SurfacePaint::SurfacePaint(const face::Face& face, face::SkinMarks marks)
    : face_(face), marks_(std::move(marks)) {
  const auto has = [&](Material material) {
    return std::ranges::any_of(face.parts, [&](const face::Part& part) { return part.material == material; });
  };
  const bool own_colours = !face.colour.empty();
  outlines_lips_ = face.has_landmarks;
  paints_brows_ = face.has_landmarks && !own_colours && !has(Material::hair) && !has(Material::strands);

  if (face.has_landmarks) {
    const auto mark = [&](std::size_t i) { return face.neutral_m[face.landmarks[i]]; };
    const auto curve = [&](std::size_t first, std::size_t last, bool closed) {
      std::vector<Vector2f> points;
      for (std::size_t i = first; i <= last; ++i) points.emplace_back(mark(i).head<2>());
      return smooth_curve(points, closed);
    };
    lips_m_ = curve(48, 59, true);
    lips_back_m_ = std::min(mark(48).z(), mark(54).z()) - 0.012F;
    brows_m_[0] = curve(17, 21, false);
    std::ranges::reverse(brows_m_[0]);
    brows_m_[1] = curve(22, 26, false);
    const auto box = [](const std::vector<Vector2f>& points, float margin_m) {
      Eigen::AlignedBox2f all;
      for (const Vector2f& point : points) all.extend(point);
      const Vector2f margin = Vector2f::Constant(margin_m);
      return Eigen::AlignedBox2f(all.min() - margin, all.max() + margin);
    };
    lips_box_ = box(lips_m_, kLipEdge_m);
    for (std::size_t side = 0; side < 2; ++side) brows_box_[side] = box(brows_m_[side], 0.012F);
    brows_back_m_ = std::min(mark(17).z(), mark(26).z()) - 0.02F;

    const Vec3f forehead = mark(27) + Vec3f(0, 0.035F, 0);
    oily_ = {{mark(30), Vec3f(0.013F, 0.022F, 0.03F)}, {forehead, Vec3f(0.035F, 0.022F, 0.03F)}};

    if (!own_colours) {
      const Vec3f flush(1.03F, 0.90F, 0.89F), eye_shadow(0.91F, 0.85F, 0.86F);
      spots_.push_back({mark(30), 0.014F, flush});
      spots_.push_back({0.5F * (mark(31) + mark(2)), 0.026F, flush});
      spots_.push_back({0.5F * (mark(35) + mark(14)), 0.026F, flush});
      spots_.push_back({mark(8), 0.018F, Vec3f(1.01F, 0.95F, 0.94F)});
      for (const std::size_t first : {std::size_t{36}, std::size_t{42}})
        spots_.push_back({0.5F * (mark(first) + mark(first + 3)), 0.019F, eye_shadow});
    }
  }

  for (std::size_t e = 0; e < 2; ++e) {
    const face::Eyeball& ball = face.eyes[e];
    if (ball.vertex_count == 0) continue;
    // Where the face brings its own colours, the rim of its modelled iris tells the iris's size.
    // An eye that is modelled a little turned looks where the middle of its iris is.
    Vec3f middle = Vec3f::Zero();
    for (const face::Part& part : face.parts) {
      if (part.material != Material::iris && part.material != Material::pupil) continue;
      for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t)
        for (const std::uint32_t i : face.triangles[t])
          if (i >= ball.first_vertex && i < ball.first_vertex + ball.vertex_count)
            middle += (face.neutral_m[i] - ball.centre_m).normalized();
    }
    if (middle.norm() > 1e-3F && middle.normalized().z() > 0.9F) eye_axis_[e] = middle.normalized();
    float widest = 0, coloured = 0;
    Vec3f colour = Vec3f::Zero();
    for (const face::Part& part : face.parts) {
      if (part.material != Material::iris || !own_colours) continue;
      for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t)
        for (const std::uint32_t i : face.triangles[t]) {
          if (i < ball.first_vertex || i >= ball.first_vertex + ball.vertex_count) continue;
          colour += face.colour[i];
          ++coloured;
          const Vec3f d = face.neutral_m[i] - ball.centre_m;
          widest = std::max(widest, std::acos(std::clamp(d.normalized().dot(eye_axis_[e]), -1.0F, 1.0F)));
        }
    }
    if (coloured > 0) iris_colour_[e] = colour / coloured;
    if (widest > 0.2F && widest < 0.9F) {
      iris_angle_rad_[e] = widest;
    } else if (face.has_landmarks) {
      // An iris is 11.7 mm wide, an eye's opening some 29 mm; eyeballs of models are often too large.
      const std::size_t corner = e == 0 ? 42 : 36;
      const float opening_m =
          (face.neutral_m[face.landmarks[corner]] - face.neutral_m[face.landmarks[corner + 3]]).norm();
      float front_m = 0;
      for (std::uint32_t i = ball.first_vertex; i < ball.first_vertex + ball.vertex_count; ++i)
        front_m = std::max(front_m, face.neutral_m[i].z() - ball.centre_m.z());
      if (front_m > 0) iris_angle_rad_[e] = std::asin(std::clamp(0.2F * opening_m / front_m, 0.2F, 0.7F));
    }
  }
}

float SurfacePaint::lip_amount(const Vec3f& p) const {
  const Vector2f q = p.head<2>();
  if (p.z() < lips_back_m_ || !lips_box_.contains(q)) return 0;
  const float distance = nearest_on(lips_m_, q, true).distance;
  const float signed_m = face::inside_polygon(lips_m_, q) ? distance : -distance;
  return smoothstep(-kLipEdge_m, 0.0016F, signed_m);
}

float SurfacePaint::brow_amount(const Vec3f& p) const {
  const Vector2f q = p.head<2>();
  const std::size_t side = p.x() > 0 ? 1 : 0;
  if (!paints_brows_ || p.z() < brows_back_m_ || !brows_box_[side].contains(q)) return 0;
  const auto& brow = brows_m_[side];
  const Nearest near = nearest_on(brow, q, false);
  const float half_m = 0.0048F * (1 - 0.72F * smoothstep(0.35F, 1.05F, near.along));
  if (near.distance > 2 * half_m) return 0;
  // Hairs run outwards and up: stretched noise, finer across than along.
  const float outward = p.x() > 0 ? 1.0F : -1.0F;
  const float lean = 1.1F - 1.3F * near.along;
  const Vector2f along = Vector2f(outward, lean).normalized();
  const Vector2f across(-along.y(), along.x());
  const float hairs = 0.80F + 0.60F * solid_noise(Vec3f(q.dot(along) * 260, q.dot(across) * 1500, 7.0F));
  const float ragged =
      near.distance + 0.0009F * solid_noise(Vec3f(q.dot(across) * 900, q.dot(along) * 120, 3.0F));
  return std::clamp(hairs, 0.0F, 1.0F) * (1 - smoothstep(0.35F * half_m, 1.15F * half_m, ragged)) * 0.92F *
         smoothstep(-0.02F, 0.10F, near.along + 0.06F);
}

Surface SurfacePaint::eye(const Vec3f& p, int index) const {
  const Vec3f d = p - face_.eyes[static_cast<std::size_t>(index)].centre_m;
  const float angle = std::acos(std::clamp(d.normalized().dot(eye_axis(index)), -1.0F, 1.0F));
  const float turn = std::atan2(d.y(), d.x());
  const float radius = angle / iris_angle_rad(index);  // 1 at the limbus.

  // White, with a little blood towards the corners.
  const float far_out = smoothstep(1.3F, 2.6F, radius);
  const float veins = std::max(0.0F, solid_noise(d * 700.0F)) * far_out;
  Vec3f colour = mix(kSclera, Vec3f(0.66F, 0.44F, 0.40F), 0.45F * far_out + 0.35F * veins);

  // The iris: dark rim, fibres, lighter ring about the pupil.
  const float fibres = 0.6F * solid_noise(Vec3f(11 * std::cos(turn), 11 * std::sin(turn), 1.6F * radius)) +
                       0.4F * solid_noise(Vec3f(26 * std::cos(turn), 26 * std::sin(turn), 3 * radius));
  const Vec3f& outer = iris_colour_[static_cast<std::size_t>(index)];
  // A dark iris has less of the golden ring.
  const Vec3f ring = std::min(1.0F, 9.0F * outer.mean()) * Vec3f(0.26F, 0.20F, 0.105F);
  const Vec3f inner = mix(Vec3f(2.2F * outer), ring, 0.45F).cwiseMin(0.5F);
  Vec3f iris = mix(inner, outer, smoothstep(0.36F, 0.70F, radius + 0.10F * fibres)) * (1 + 0.75F * fibres);
  iris *= 1 - 0.78F * smoothstep(0.80F, 1.0F, radius);
  iris *= smoothstep(0.30F, 0.37F, radius);
  colour = mix(iris, colour, smoothstep(0.94F, 1.09F, radius));
  return {
      .albedo = colour.cwiseMax(0.004F), .roughness = 0.08F, .reflectance = 0.03F, .scatter = 0, .bump = 0};
}

Vec3f SurfacePaint::marked(const Vec3f& albedo, const Vec3f& p, const Place& place) const {
  Vec3f out = albedo * pore_shade(p, place.footprint_m);
  if (place.marks.x() > 0) {
    const float cover = freckle_cover(p, marks_.person, place.marks.x(), place.footprint_m);
    out = out.cwiseProduct(mix(Vec3f::Ones(), Vec3f(0.66F, 0.50F, 0.38F), cover));
  }
  if (place.marks.y() > 0) {
    const float cover = stubble_cover(p, marks_.person, place.marks.y(), place.footprint_m);
    out = mix(out, marks_.stubble, cover);
  }
  for (const face::Mole& mole : marks_.moles) {
    const float square = (p - mole.centre_m).squaredNorm(), reach = 1.5F * mole.radius_m;
    if (square > reach * reach) continue;
    const float ragged = std::sqrt(square) * (1 + 0.25F * solid_noise(p * 1500.0F));
    const float cover = mole.darkness * (1 - smoothstep(0.6F, 1.15F, ragged / mole.radius_m));
    out = out.cwiseProduct(mix(Vec3f::Ones(), Vec3f(0.24F, 0.15F, 0.11F), cover));
  }
  return out;
}

Surface SurfacePaint::at(const Vec3f& p, Material material, const Vec3f* own, const Place& place) const {
  Surface s;
  switch (material) {
    case Material::skin:
    case Material::lips: {
      const float mottle = solid_noises(p * 160.0F).x() + 0.5F * solid_noises(p * 420.0F).y();
      s = {.albedo = own != nullptr ? *own : kSkin,
           .roughness = 0.50F,
           .reflectance = 0.026F,
           .scatter = 1,
           .bump = 1};
      if (own == nullptr)
        for (const Spot& spot : spots_) {
          const float amount =
              std::exp(-(p - spot.centre_m).squaredNorm() / (2 * spot.radius_m * spot.radius_m));
          s.albedo = s.albedo.cwiseProduct(mix(Vec3f::Ones(), spot.tint, amount));
        }
      s.albedo = s.albedo.cwiseProduct(Vec3f::Ones() + mottle * Vec3f(0.045F, 0.08F, 0.085F) +
                                       solid_noises(p * 55.0F).z() * Vec3f(0.03F, 0.085F, 0.085F));
      s.albedo = marked(s.albedo, p, place);
      for (const Oily& oily : oily_)
        s.roughness -= 0.09F * std::exp(-(p - oily.centre_m).cwiseQuotient(oily.radius_m).squaredNorm());
      const float lip = outlines_lips_ ? lip_amount(p) : material == Material::lips ? 1.0F : 0.0F;
      if (lip > 0) {
        if (own == nullptr) {
          const float lines = 1 + 0.13F * solid_noise(Vec3f(p.x() * 1300, p.y() * 160, p.z() * 160));
          s.albedo = mix(s.albedo, kLips * lines, 0.88F * lip);
        }
        s.roughness += lip * (0.37F - s.roughness);
        s.bump *= 1 - 0.7F * lip;
      }
      const float brow = brow_amount(p);
      s.albedo = mix(s.albedo, kHair, brow);
      s.roughness += 0.2F * brow;
      return s;
    }
    case Material::sclera:
    case Material::iris:
    case Material::pupil: {
      int nearest = -1;
      float best = 0.03F;
      for (int e = 0; e < 2; ++e)
        if (face_.eyes[static_cast<std::size_t>(e)].vertex_count > 0) {
          const float d = (p - face_.eyes[static_cast<std::size_t>(e)].centre_m).norm();
          if (d < best) {
            best = d;
            nearest = e;
          }
        }
      if (nearest >= 0) return eye(p, nearest);
      s = {.albedo = material == Material::sclera ? kSclera
                     : material == Material::iris ? Vec3f(0.12F, 0.10F, 0.07F)
                                                  : Vec3f(0.004F, 0.004F, 0.004F),
           .roughness = 0.08F,
           .reflectance = 0.03F};
      break;
    }
    case Material::cornea:
      return {.albedo = Vec3f::Zero(), .roughness = 0.06F, .reflectance = 0.025F};
    case Material::teeth:
      s = {.albedo = {0.80F, 0.72F, 0.59F}, .roughness = 0.22F, .reflectance = 0.045F, .scatter = 0.3F};
      break;
    case Material::gums:
      s = {.albedo = {0.50F, 0.19F, 0.18F}, .roughness = 0.3F, .reflectance = 0.03F, .scatter = 0.6F};
      break;
    case Material::tongue:
      s = {.albedo = {0.52F, 0.20F, 0.19F},
           .roughness = 0.36F,
           .reflectance = 0.03F,
           .scatter = 0.8F,
           .bump = 1};
      break;
    case Material::mouth_inside:
      s = {.albedo = {0.30F, 0.085F, 0.075F}, .roughness = 0.35F, .reflectance = 0.03F, .scatter = 0.6F};
      break;
    case Material::hair:
    case Material::strands:
      s = {.albedo = kHair, .roughness = 0.5F, .reflectance = 0.03F};
      break;
    case Material::lash:
      s = {.albedo = {0.012F, 0.009F, 0.008F}, .roughness = 0.6F, .reflectance = 0.02F};
      break;
    case Material::cloth:
      s = {.albedo = {0.045F, 0.055F, 0.075F}, .roughness = 0.95F, .reflectance = 0.015F};
      break;
    case Material::other:
      s = {.albedo = {0.35F, 0.35F, 0.36F}, .roughness = 0.5F, .reflectance = 0.03F};
      break;
  }
  if (own != nullptr) s.albedo = *own;
  return s;
}

float SurfacePaint::lash_cover(const Vec3f& p, float length_m) const {
  const bool left = p.x() > 0;
  const face::Eyeball& ball = face_.eyes[left ? 0 : 1];
  if (ball.vertex_count == 0) return 0.5F;
  const Vec3f d = p - ball.centre_m;
  const float turn = std::atan2(d.y(), left ? d.x() : -d.x());
  const bool lower = d.y() < 0;
  // Hairs stand side by side along the lid, of unequal length, each thinning to its tip.
  const float longest_m =
      (lower ? 0.0045F : 0.0085F) * (0.8F + 0.35F * solid_noise(Vec3f(turn * 23, 2, lower ? 9 : 1)));
  const float along = length_m / longest_m;
  const float hair = 0.5F + solid_noise(Vec3f(turn * (lower ? 34.0F : 46.0F), along * 0.8F, lower ? 5 : 3));
  const float thick = (lower ? 0.52F : 0.66F) * (1 - along);
  return (lower ? 0.6F : 0.9F) * (1 - smoothstep(thick - 0.12F, thick + 0.12F, hair)) *
         (1 - smoothstep(0.8F, 1.0F, along));
}

}  // namespace mien::render
