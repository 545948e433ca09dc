#include "mien/render/wrinkles.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "mien/core/smoothstep.h"
#include "mien/render/solid_noise.h"

namespace mien::render {
namespace {

using Eigen::Vector2f;

/// What a region's lines are like, chosen by eye.
struct Style {
  float spacing_m;  // Between lines, about.
  float wander;     // How far noise moves a line, of the spacing.
  float width;      // Of a fold, of the spacing.
  float depth;      // Beside the other regions.
  float slack;      // Added to the face's: some folds come sooner than others.
};
constexpr std::array<Style, Wrinkles::region_count> kStyle = {{
    {0.0075F, 0.50F, 0.30F, 1.0F, 0.0F},      // forehead
    {0.0085F, 0.22F, 0.28F, 1.0F, -0.01F},    // frown
    {0.0045F, 0.55F, 0.34F, 0.85F, -0.005F},  // crows_feet
    {0.0032F, 0.50F, 0.42F, 0.55F, -0.02F},   // under_eye
    {0.0038F, 0.45F, 0.40F, 0.8F, -0.03F},    // nose_root
    {0.0150F, 0.10F, 0.22F, 0.9F, 0.01F},     // nasolabial
    {0.0026F, 0.55F, 0.45F, 0.6F, -0.03F},    // pucker
    {0.0042F, 0.0F, 0.5F, 0.8F, -0.02F},      // chin
}};
constexpr float kSteepest = 0.7F;

/// 0 to 1 from a to b, and back from c to d.
float plateau(float a, float b, float c, float d, float x) {
  return smoothstep(a, b, x) * (1 - smoothstep(c, d, x));
}

float chance(int line, int region) {
  auto h = static_cast<std::uint32_t>(line) * 0x8DA6B343U ^ static_cast<std::uint32_t>(region) * 0xD8163841U;
  h = (h ^ (h >> 15U)) * 0x2C1B3C6DU;
  h ^= h >> 13U;
  return static_cast<float>(h & 1023U) / 1023.0F;
}

/// A fold narrow and rounded, the skin between two of them broad: depth 1 at whole numbers, 0 midway.
struct Fold {
  float depth, slope;  // `slope` of the height, at most 1.
};
Fold fold_at(float phase, float width) {
  const float t = static_cast<float>(M_PI) * phase;
  const float s = std::sin(t), c = std::cos(t), w2 = width * width;
  const float v = w2 / (w2 + s * s), bottom = w2 / (w2 + 1);
  // Of v: -2 w^2 s c / (w^2 + s^2)^2, at most about 0.65 / w.
  return {.depth = (v - bottom) / (1 - bottom),
          .slope = 2 * w2 * s * c / ((w2 + s * s) * (w2 + s * s)) * width / 0.65F};
}

}  // namespace

Wrinkles::Wrinkles(const face::Face& face, const face::SkinFolds& folds) : folds_(folds) {
  if (!face.has_landmarks || folds_.depth <= 0) return;
  const auto mark = [&](std::size_t i) -> const Vec3f& { return face.neutral_m[face.landmarks[i]]; };
  brow_y_ = 0.5F * (mark(19).y() + mark(24).y());
  glabella_y_ = 0.5F * (mark(21).y() + mark(22).y());
  front_z_ = std::min(mark(36).z(), mark(45).z()) - 0.022F;
  outer_canthus_ = {mark(36), mark(45)};
  inner_canthus_ = {mark(39), mark(42)};
  nose_root_ = mark(27);
  nose_middle_ = mark(29);
  mouth_ = 0.5F * (mark(48) + mark(54));
  mouth_half_m_ = 0.5F * (mark(54) - mark(48)).norm();
  chin_y_ = 0.45F * mark(57).y() + 0.55F * mark(8).y();
  for (std::size_t side = 0; side < 2; ++side) {
    const float out = side == 0 ? -1 : 1;
    const Vector2f wing = mark(side == 0 ? 31 : 35).head<2>(), corner = mark(side == 0 ? 48 : 54).head<2>();
    const Vector2f from = wing + Vector2f(out * 0.0085F, 0.006F),
                   to = corner + Vector2f(out * 0.0085F, -0.008F),
                   bend = 0.5F * (from + to) + Vector2f(out * 0.006F, 0.004F);
    for (int i = 0; i <= 12; ++i) {
      const float t = static_cast<float>(i) / 12;
      nasolabial_[side].push_back((1 - t) * (1 - t) * from + 2 * t * (1 - t) * bend + t * t * to);
    }
  }

  const std::size_t n = face.neutral_m.size();
  std::vector<std::vector<std::uint32_t>> ring(n);
  std::vector<Vec3f> normal(n, Vec3f::Zero());
  for (const face::Part& part : face.parts) {
    if (part.material != face::Material::skin && part.material != face::Material::lips) continue;
    for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
      const auto& [a, b, c] = face.triangles[t];
      const Vec3f across =
          (face.neutral_m[b] - face.neutral_m[a]).cross(face.neutral_m[c] - face.neutral_m[a]);
      for (const std::uint32_t i : {a, b, c}) {
        normal[i] += across;
        ring[i].insert(ring[i].end(), {a, b, c});
      }
    }
  }
  const auto tidy = [](std::vector<std::uint32_t>& list, std::uint32_t self) {
    std::ranges::sort(list);
    list.erase(std::ranges::unique(list).begin(), list.end());
    std::erase(list, self);
  };
  for (std::uint32_t i = 0; i < n; ++i) tidy(ring[i], i);
  for (std::uint32_t i = 0; i < n; ++i) {
    if (ring[i].size() < 3) continue;
    const Vec3f& p = face.neutral_m[i];
    const Vec3f up = normal[i].normalized();
    std::vector<std::uint32_t> near;
    for (int r = 0; r < region_count; ++r) {
      const auto region = static_cast<Region>(r);
      const float amount = weight(region, p);
      if (amount <= 0) continue;
      if (near.empty()) {
        // Two rings: one alone has the noise of the mesh's own layout.
        near = ring[i];
        for (const std::uint32_t j : ring[i]) near.insert(near.end(), ring[j].begin(), ring[j].end());
        tidy(near, i);
      }
      Vec3f across = Vec3f::Zero();
      if (region == chin) {
        const std::size_t rows = row_.size();
        across = up.unitOrthogonal();
        add_row(region, i, across, amount, 0.5F, face.neutral_m, near);
        add_row(region, i, up.cross(across), amount, 0.5F, face.neutral_m, near);
        // fold() takes both halves or none.
        if (row_.size() == rows + 1) row_.pop_back();
        continue;
      }
      constexpr float kStep_m = 2e-4F;
      for (Eigen::Index axis = 0; axis < 3; ++axis)
        across[axis] = phase(region, p + kStep_m * Vec3f::Unit(axis)) - phase(region, p);
      across -= across.dot(up) * up;
      if (across.norm() > 1e-9F) add_row(region, i, across.normalized(), amount, 1, face.neutral_m, near);
    }
  }
}

void Wrinkles::add_row(Region region, std::uint32_t vertex, const Vec3f& across, float weight, float share,
                       std::span<const Vec3f> neutral_m, std::span<const std::uint32_t> near) {
  // The map from edges at rest to posed ones by least squares is sum d_j e_j^T (sum e_j e_j^T)^-1, in the
  // plane of the edges; what it makes of `across` is a sum over the posed edges d_j.
  Eigen::Matrix3f moments = Eigen::Matrix3f::Zero();
  for (const std::uint32_t j : near) {
    const Vec3f e = neutral_m[j] - neutral_m[vertex];
    moments += e * e.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes(moments);
  if (axes.eigenvalues()[1] <= 0) return;
  Vec3f solved = Vec3f::Zero();
  for (Eigen::Index k = 1; k < 3; ++k) {
    const Vec3f axis = axes.eigenvectors().col(k);
    solved += axis * (axis.dot(across) / axes.eigenvalues()[k]);
  }
  const Vec3f flat = across - axes.eigenvectors().col(0) * axes.eigenvectors().col(0).dot(across);
  if (flat.norm() < 0.3F) return;
  solved /= flat.norm();
  const auto first = static_cast<std::uint32_t>(term_.size());
  for (const std::uint32_t j : near) term_.push_back({j, solved.dot(neutral_m[j] - neutral_m[vertex])});
  row_.push_back({vertex, first, static_cast<std::uint32_t>(term_.size()), region, weight, share});
}

float Wrinkles::row_strain(const Row& row, std::span<const Vec3f> vertices_m) const {
  Vec3f stretched = Vec3f::Zero();
  for (std::uint32_t k = row.first_term; k < row.end_term; ++k)
    stretched += term_[k].coefficient * (vertices_m[term_[k].vertex] - vertices_m[row.vertex]);
  return stretched.norm() - 1;
}

void Wrinkles::fold(std::span<const Vec3f> vertices_m, std::span<Slopes> slopes) const {
  for (std::size_t k = 0; k < row_.size(); ++k) {
    const Row& row = row_[k];
    float strain = row.share * row_strain(row, vertices_m);
    if (row.share < 1) {  // The other half follows.
      ++k;
      strain += row_[k].share * row_strain(row_[k], vertices_m);
    }
    const Style& style = kStyle[row.region];
    const float surplus = std::max(0.0F, folds_.slack + style.slack - strain);
    slopes[row.vertex][row.region] =
        std::min(kSteepest, row.weight * style.depth * folds_.depth * 2 * std::sqrt(surplus));
  }
}

float Wrinkles::strain(Region region, std::uint32_t vertex, std::span<const Vec3f> vertices_m) const {
  float sum = 0;
  for (const Row& row : row_)
    if (row.vertex == vertex && row.region == region) sum += row.share * row_strain(row, vertices_m);
  return sum;
}

float Wrinkles::weight(Region region, const Vec3f& p) const {
  if (p.z() < front_z_) return 0;
  const auto side = static_cast<std::size_t>(p.x() > 0);
  const float x = std::abs(p.x()), out = side == 0 ? -1 : 1;
  switch (region) {
    case forehead:
      return plateau(0.005F, 0.012F, 0.040F, 0.056F, p.y() - brow_y_) * (1 - smoothstep(0.030F, 0.052F, x));
    case frown:
      return plateau(-0.010F, -0.002F, 0.012F, 0.020F, p.y() - glabella_y_) *
             (1 - smoothstep(0.007F, 0.013F, x));
    case crows_feet: {
      const Vector2f d = (p - outer_canthus_[side]).head<2>();
      const float along = out * d.x() + 0.006F, r = std::hypot(along, d.y());
      if (along <= 0) return 0;
      const float turn = std::atan2(d.y(), along);
      return plateau(0.009F, 0.014F, 0.022F, 0.034F, r) * plateau(-0.95F, -0.6F, 0.45F, 0.75F, turn);
    }
    case under_eye: {
      const Vector2f d = (p - 0.5F * (outer_canthus_[side] + inner_canthus_[side])).head<2>();
      const float r = std::hypot(d.x() * 0.75F, d.y());
      return d.y() >= 0 ? 0 : plateau(0.007F, 0.010F, 0.015F, 0.022F, r) * smoothstep(0.1F, 0.5F, -d.y() / r);
    }
    case nose_root:
      return plateau(0, 0.3F, 0.8F, 1.25F,
                     (nose_root_.y() + 0.004F - p.y()) / (nose_root_.y() - nose_middle_.y() + 1e-4F)) *
             (1 - smoothstep(0.010F, 0.017F, x));
    case nasolabial: {
      const float d = std::abs(phase(region, p));
      if (d > 0.5F) return 0;
      const auto& line = nasolabial_[side];
      return plateau(line.back().y() - 0.006F, line.back().y() + 0.010F, line.front().y() - 0.006F,
                     line.front().y() + 0.004F, p.y());
    }
    case pucker: {
      const float far = std::hypot(p.x() / (mouth_half_m_ + 0.004F), (p.y() - mouth_.y()) / 0.020F);
      return 1 - smoothstep(0.72F, 1.0F, far);
    }
    case chin:
      return 1 - smoothstep(0.5F, 1.0F, std::hypot(p.x() / 0.018F, (p.y() - chin_y_) / 0.014F));
    case region_count:
      break;
  }
  return 0;
}

float Wrinkles::phase(Region region, const Vec3f& p) const {
  const float spacing = kStyle[region].spacing_m;
  const auto side = static_cast<std::size_t>(p.x() > 0);
  const float x = std::abs(p.x()), out = side == 0 ? -1 : 1;
  switch (region) {
    case forehead:
      // Lines sink towards the temples.
      return (p.y() - brow_y_ + 2.2F * p.x() * p.x()) / spacing;
    case frown:
      // Two main ones, nearer to each other at the nose.
      return p.x() / (spacing * (1 + 14 * (p.y() - glabella_y_))) + 0.5F;
    case crows_feet: {
      const Vector2f d = (p - outer_canthus_[side]).head<2>();
      return std::atan2(d.y(), std::max(1e-4F, out * d.x() + 0.006F)) / (spacing / 0.016F);
    }
    case under_eye: {
      const Vector2f d = (p - 0.5F * (outer_canthus_[side] + inner_canthus_[side])).head<2>();
      return std::hypot(d.x() * 0.75F, d.y()) / spacing;
    }
    case nose_root:
      return (0.85F * (p.y() - nose_root_.y()) + 0.5F * x) / spacing;
    case nasolabial: {
      float nearest = std::numeric_limits<float>::max();
      const auto& line = nasolabial_[side];
      const Vector2f q = p.head<2>();
      for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        const Vector2f d = line[i + 1] - line[i];
        const float t = std::clamp((q - line[i]).dot(d) / d.squaredNorm(), 0.0F, 1.0F);
        const Vector2f off = q - line[i] - t * d;
        const float inside = off.x() * d.y() - off.y() * d.x() > 0 ? 1.0F : -1.0F;
        if (off.norm() < std::abs(nearest)) nearest = inside * off.norm();
      }
      return nearest / spacing;
    }
    case pucker: {
      // A fan from well behind the other lip.
      const float up = std::abs(p.y() - mouth_.y()) + 0.025F;
      return std::atan2(p.x(), up) * 0.034F / spacing;
    }
    case chin:
    case region_count:
      break;
  }
  return 0;
}

Wrinkles::Relief Wrinkles::at(const Vec3f& p, const Vec3f& normal, const Slopes& slopes,
                              float footprint_m) const {
  Relief relief;
  const Vec3f u = normal.unitOrthogonal(), v = normal.cross(u);
  for (int r = 0; r < region_count; ++r) {
    const auto region = static_cast<Region>(r);
    const Style& style = kStyle[region];
    const float fold_m = style.spacing_m * style.width;
    const float slope = slopes[r] * (1 - smoothstep(0.5F * fold_m, 1.5F * fold_m, footprint_m));
    if (slope < 0.004F) continue;
    if (region == chin) {
      const Vec3f bumps = solid_noises(p / style.spacing_m);
      relief.slope += slope * (bumps - bumps.dot(normal) * normal);
      relief.crease += slope * std::max(0.0F, bumps.x());
      continue;
    }
    const float bend = 0.28F / style.spacing_m;
    const auto wandering = [&](const Vec3f& q, const Vec3f& noise) {
      return phase(region, q) + style.wander * (noise.x() + 0.35F * noise.y());
    };
    const Vec3f noise = solid_noises(p * bend);
    const float here = wandering(p, noise);
    if (region == nasolabial && std::abs(here) > 0.5F) continue;
    constexpr float kStep_m = 2e-4F;
    const Vec3f pu = p + kStep_m * u, pv = p + kStep_m * v;
    const Vec3f uphill = ((wandering(pu, solid_noises(pu * bend)) - here) * u +
                          (wandering(pv, solid_noises(pv * bend)) - here) * v)
                             .normalized();
    // Lines differ, and none goes on for ever.
    const float line = std::round(here);
    const float strength = region == nasolabial ? 1.0F
                                                : (0.45F + 0.55F * chance(static_cast<int>(line), r)) *
                                                      smoothstep(-0.45F, 0.25F, noise.z());
    const Fold fold = fold_at(here - line, style.width);
    relief.slope += slope * strength * fold.slope * uphill;
    relief.crease += slope * strength * fold.depth;
  }
  return relief;
}

}  // namespace mien::render
