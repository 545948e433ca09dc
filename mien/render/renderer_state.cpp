#include "mien/render/renderer_state.h"

#include <cmath>
#include <utility>

#include "mien/render/parallel.h"

namespace mien::render {
namespace {

using face::Material;

/// How far light spreads in skin, red, green, blue: mean free paths of some millimetres and less
/// (Jensen et al. 2001, doi:10.1145/383259.383319, table 1), as the deviation of a Gaussian.
const Vec3f kScatter_m(3.4e-3F, 1.5e-3F, 0.9e-3F);

/// Without texture coordinates nobody knows where on a ribbon hairs are: then it is hair as one piece.
std::vector<Material> drawn_materials(const face::Face& face) {
  std::vector<Material> all = material_of_triangles(face);
  if (face.uv.empty()) std::ranges::replace(all, Material::strands, Material::hair);
  return all;
}

template <class Wanted>
std::vector<std::uint32_t> pick(const std::vector<Material>& material, const Wanted& wanted) {
  std::vector<std::uint32_t> picked;
  for (std::uint32_t t = 0; t < material.size(); ++t)
    if (wanted(material[t])) picked.push_back(t);
  return picked;
}

bool is_hair(Material m) {
  return m == Material::lash || m == Material::strands;
}

}  // namespace

Renderer::State::State(const face::Face& f, Quality q, int thread_count, const face::SkinFolds& skin_folds,
                       const face::SkinMarks& marks)
    : face(f),
      quality(q),
      workers(thread_count > 0 ? thread_count
                               : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))),
      paint(f, marks),
      wrinkles(f, skin_folds),
      middle_m(middle_of_head_m(f)),
      material(drawn_materials(f)),
      solid_triangle(pick(material, [](Material m) { return !is_hair(m) && m != Material::cornea; })),
      clear_triangle(pick(material, [](Material m) { return m == Material::cornea; })),
      hair_triangle(pick(material, is_hair)),
      is_strand(f.vertices_of(Material::strands)),
      in_mouth(f.neutral_m.size(), false),
      solid(f.neutral_m, triangles_of(solid_triangle)),
      hair(f.neutral_m, triangles_of(pick(material, [](Material m) { return m == Material::strands; }))),
      rests(f.neutral_m.size(), 0),
      position(f.neutral_m),
      normal(f.neutral_m.size()),
      folds(wrinkles.empty() ? 0 : f.neutral_m.size(), Wrinkles::Slopes::Zero()),
      on_screen(f.neutral_m.size()),
      light(f.neutral_m.size(), VertexLight::Zero()),
      hair_shade(f.neutral_m.size()) {
  for (const Material inside : {Material::teeth, Material::gums, Material::tongue}) {
    const std::vector<bool> of_it = f.vertices_of(inside);
    for (std::size_t i = 0; i < of_it.size(); ++i) in_mouth[i] = in_mouth[i] || of_it[i];
  }
  find_still_hair();
  find_twins();
  find_neighbours();
  if (q == Quality::video) find_vertices_between();
  find_vertices_near_motion();
  measure_lashes();
  lowest_m = std::numeric_limits<float>::max();
  for (const Vec3f& p : f.neutral_m) lowest_m = std::min(lowest_m, p.y());
  ambient_directions = sphere_directions(q == Quality::still ? kMostDirections : 28);
  eye_directions = sphere_directions(q == Quality::still ? 48 : 24);
  for (HairLight& colours : hair_light) {
    colours.tint.assign(f.neutral_m.size(), Vec3f::Zero());
    colours.gloss = colours.tint;
  }
}

std::vector<Renderer::State::Triangle> Renderer::State::triangles_of(
    std::span<const std::uint32_t> which) const {
  std::vector<Triangle> all;
  for (const std::uint32_t t : which) all.push_back(face.triangles[t]);
  return all;
}

void Renderer::State::find_still_hair() {
  const std::size_t n = face.neutral_m.size();
  std::vector<bool> moves(n, false);
  for (const face::Shape& shape : face.shapes)
    for (const std::uint32_t i : shape.vertex) moves[i] = true;
  const auto any = [&](std::uint32_t t, const std::vector<bool>& which) {
    const auto& [a, b, c] = face.triangles[t];
    return which[a] || which[b] || which[c];
  };
  // A ribbon of which a part moves is a moving one.
  for (bool grew = true; std::exchange(grew, false);)
    for (const std::uint32_t t : hair_triangle) {
      if (!any(t, moves)) continue;
      for (const std::uint32_t i : face.triangles[t]) {
        grew = grew || !moves[i];
        moves[i] = true;
      }
    }
  std::vector<bool> others(n, false);
  for (const std::vector<std::uint32_t>* list : {&solid_triangle, &clear_triangle})
    for (const std::uint32_t t : *list)
      for (const std::uint32_t i : face.triangles[t]) others[i] = true;
  is_still.assign(n, false);
  for (const std::uint32_t t : hair_triangle) {
    const bool still = material[t] == Material::strands && !any(t, moves) && !any(t, others);
    (still ? still_hair_triangle : moving_hair_triangle).push_back(t);
    if (!still) continue;
    for (const std::uint32_t i : face.triangles[t]) is_still[i] = true;
  }
  for (std::uint32_t i = 0; i < n; ++i)
    if (is_still[i]) still_vertex.push_back(i);
}

void Renderer::State::find_twins() {
  // Importers split vertices where texture coordinates break; skin does not break there.
  const std::size_t n = face.neutral_m.size();
  face::vertex_normals(face, position, normal);
  std::vector<std::uint32_t> order(n);
  for (std::size_t i = 0; i < n; ++i) order[i] = static_cast<std::uint32_t>(i);
  const auto key = [&](std::uint32_t i) {
    const Vec3f& p = face.neutral_m[i];
    const float kind = is_still[i] ? 2 : is_strand[i] ? 1 : 0;
    return std::array<float, 4>{p.x(), p.y(), p.z(), kind};
  };
  std::ranges::sort(
      order, [&](std::uint32_t a, std::uint32_t b) { return std::pair(key(a), a) < std::pair(key(b), b); });
  twin.resize(n);
  for (std::size_t i = 0, first = 0; i < n; ++i) {
    if (key(order[i]) != key(order[first])) first = i;
    twin[order[i]] = order[i];
    for (std::size_t j = first; j < i; ++j)
      if (twin[order[j]] == order[j] && normal[order[i]].dot(normal[order[j]]) > 0.3F) {
        twin[order[i]] = order[j];
        break;
      }
  }
  for (std::uint32_t i = 0; i < n; ++i)
    if (twin[i] != i && !is_still[i]) copied_vertex.push_back(i);
}

void Renderer::State::find_neighbours() {
  const std::size_t n = face.neutral_m.size();
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  std::vector<bool> scatters(n, false), is_lit(n, false);
  for (const std::uint32_t t : solid_triangle) {
    if (material[t] == Material::skin || material[t] == Material::lips)
      for (const std::uint32_t i : face.triangles[t]) scatters[twin[i]] = true;
    if (is_eye(material[t])) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = twin[face.triangles[t][c]], b = twin[face.triangles[t][(c + 1) % 3]];
      is_lit[a] = true;
      if (a == b) continue;
      edges.emplace_back(a, b);
      edges.emplace_back(b, a);
    }
  }
  std::vector<std::uint32_t> place(n, 0);
  for (std::uint32_t i = 0; i < n; ++i)
    if (is_lit[i]) {
      place[i] = static_cast<std::uint32_t>(lit_vertex.size());
      lit_vertex.push_back(i);
    } else if (is_strand[i] && twin[i] == i) {
      (is_still[i] ? still_hair_vertex : moving_hair_vertex).push_back(i);
    }
  std::ranges::sort(edges);
  edges.erase(std::ranges::unique(edges).begin(), edges.end());
  neighbour_start.assign(lit_vertex.size() + 1, 0);
  std::vector<float> edge_m(lit_vertex.size(), 0);  // Their mean.
  for (const auto& [a, b] : edges) {
    ++neighbour_start[place[a] + 1];
    neighbour.push_back(place[b]);
    edge_m[place[a]] += (face.neutral_m[a] - face.neutral_m[b]).norm();
  }
  spread_share.assign(lit_vertex.size(), VertexLight::Zero());
  for (std::size_t k = 0; k < lit_vertex.size(); ++k) {
    const std::uint32_t count = neighbour_start[k + 1];
    neighbour_start[k + 1] += neighbour_start[k];
    if (count == 0) continue;
    edge_m[k] /= static_cast<float>(count);
    // Diffusion over the mesh: each step moves a vertex towards its neighbours' mean and adds share * edge^2
    // to the variance of the blur.
    const float variance = std::max(1e-12F, kScatterSteps * edge_m[k] * edge_m[k]);
    // Teeth and gums are not translucent as skin is: what spreads there has no colour.
    const Vec3f spread_m = scatters[lit_vertex[k]] ? kScatter_m : Vec3f(Vec3f::Constant(kScatter_m.z()));
    const Vec3f share = spread_m.cwiseProduct(spread_m) / variance;
    spread_share[k].head<3>() = (0.49F * share).cwiseMin(0.6F);
    for (Eigen::Index l = 1; l <= Eigen::Index{kLights}; ++l)
      spread_share[k].segment<3>(3 * l) = share.cwiseMin(0.6F);
  }
  unscattered.assign(lit_vertex.size(), VertexLight::Zero());
  scattered = scattered_next = unscattered;
}

void Renderer::State::measure_lashes() {
  const std::size_t n = face.neutral_m.size();
  lash_length_m.assign(n, 0);
  std::vector<bool> is_lash(n, false), is_skin(n, false);
  for (std::size_t t = 0; t < face.triangles.size(); ++t)
    for (const std::uint32_t i : face.triangles[t]) {
      if (material[t] == Material::lash) is_lash[i] = true;
      if (!is_hair(material[t])) is_skin[i] = true;
    }
  Vec3f low = Vec3f::Constant(std::numeric_limits<float>::max()), high = -low;
  for (std::size_t i = 0; i < n; ++i)
    if (is_lash[i]) {
      low = low.cwiseMin(face.neutral_m[i]);
      high = high.cwiseMax(face.neutral_m[i]);
    }
  constexpr float kReach_m = 0.015F;
  std::vector<Vec3f> near;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3f& p = face.neutral_m[i];
    if (is_skin[i] && (p - low).minCoeff() > -kReach_m && (high - p).minCoeff() > -kReach_m)
      near.push_back(p);
  }
  parallel(workers, n, 512, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (!is_lash[i]) continue;
      float nearest2 = kReach_m * kReach_m;
      for (const Vec3f& p : near) nearest2 = std::min(nearest2, (p - face.neutral_m[i]).squaredNorm());
      lash_length_m[i] = std::sqrt(nearest2);
    }
  });
}

}  // namespace mien::render
