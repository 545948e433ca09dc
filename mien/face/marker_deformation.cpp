#include "mien/face/marker_deformation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

namespace mien::face {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();
/// Keeps two markers on one vertex from making the system singular.
constexpr double kRidge = 1e-3;

/// The mesh's edges, a run of neighbours a vertex.
struct Edges {
  std::vector<std::uint32_t> first;  // Size of the vertices and one.
  std::vector<std::uint32_t> to;
};

Edges edges_of(const Face& face) {
  const std::size_t vertices = face.neutral_m.size();
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  pairs.reserve(6 * face.triangles.size());
  for (const auto& t : face.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      pairs.emplace_back(t[i], t[(i + 1) % 3]);
      pairs.emplace_back(t[(i + 1) % 3], t[i]);
    }
  std::ranges::sort(pairs);
  pairs.erase(std::ranges::unique(pairs).begin(), pairs.end());
  Edges edges;
  edges.first.assign(vertices + 1, 0);
  for (const auto& [from, to] : pairs) {
    ++edges.first[from + 1];
    edges.to.push_back(to);
  }
  for (std::size_t v = 0; v < vertices; ++v) edges.first[v + 1] += edges.first[v];
  return edges;
}

/// Distances along the edges from one vertex, up to `reach_m` (Dijkstra).
std::vector<float> distances_from(std::uint32_t start, const Face& face, const Edges& edges, double reach_m) {
  std::vector<float> distance(face.neutral_m.size(), kFar);
  using Entry = std::pair<float, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> next;
  distance[start] = 0;
  next.emplace(0.0F, start);
  while (!next.empty()) {
    const auto [so_far, v] = next.top();
    next.pop();
    if (so_far > distance[v]) continue;
    for (std::uint32_t e = edges.first[v]; e < edges.first[v + 1]; ++e) {
      const std::uint32_t to = edges.to[e];
      const float d = so_far + (face.neutral_m[to] - face.neutral_m[v]).norm();
      if (d >= distance[to] || static_cast<double>(d) > reach_m) continue;
      distance[to] = d;
      next.emplace(d, to);
    }
  }
  return distance;
}

/// Wendland's function of second smoothness: 1 at 0, 0 from `reach_m` on.
double kernel(float distance_m, double reach_m) {
  const double r = static_cast<double>(distance_m) / reach_m;
  if (!(r < 1)) return 0;
  const double q = (1 - r) * (1 - r);
  return q * q * (4 * r + 1);
}

}  // namespace

Result<MarkerDeformation> MarkerDeformation::create(const Face& face, const Eigen::VectorXd& markers_m,
                                                    double reach_m) {
  if (markers_m.size() % 3 != 0)
    return fail(ErrorCode::mismatch, "markers without three coordinates each", "marker deformation");
  if (markers_m.size() == 0 || !markers_m.allFinite() || !(reach_m > 0) || !std::isfinite(reach_m))
    return fail(ErrorCode::out_of_range, "no markers, or a number that is not finite", "marker deformation");
  const Region* skin = face.region("skin");
  if (skin == nullptr || skin->vertex.empty())
    return fail(ErrorCode::not_found, "the face has no skin to move", face.name);

  const auto count = markers_m.size() / 3;
  const Edges edges = edges_of(face);
  std::vector<std::uint32_t> holds;
  std::vector<std::vector<float>> distance;
  for (Eigen::Index m = 0; m < count; ++m) {
    const Vec3f place = markers_m.segment<3>(3 * m).cast<float>();
    holds.push_back(*std::ranges::min_element(
        skin->vertex, {}, [&](std::uint32_t v) { return (face.neutral_m[v] - place).squaredNorm(); }));
    distance.push_back(distances_from(holds.back(), face, edges, reach_m));
  }

  // The displacement at marker i is sum_j kernel(i, j) c_j; c is what the markers' own displacements ask for.
  Eigen::MatrixXd between(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < count; ++j)
      between(i, j) =
          kernel(distance[static_cast<std::size_t>(i)][holds[static_cast<std::size_t>(j)]], reach_m);
  between = (0.5 * (between + between.transpose())).eval();
  between.diagonal().array() += kRidge;
  const Eigen::MatrixXd inverse = between.fullPivLu().inverse();

  MarkerDeformation out;
  out.neutral_m_ = markers_m;
  for (std::uint32_t v = 0; v < face.neutral_m.size(); ++v)
    if (std::ranges::any_of(distance, [&](const std::vector<float>& from) { return from[v] < kFar; }))
      out.vertices_.push_back(v);
  out.shares_.resize(static_cast<Eigen::Index>(out.vertices_.size()), count);
  Eigen::RowVectorXd row(count);
  for (std::size_t v = 0; v < out.vertices_.size(); ++v) {
    for (Eigen::Index m = 0; m < count; ++m)
      row[m] = kernel(distance[static_cast<std::size_t>(m)][out.vertices_[v]], reach_m);
    out.shares_.row(static_cast<Eigen::Index>(v)) = (row * inverse).cast<float>();
  }
  return out;
}

void MarkerDeformation::apply(const Face& face, const Eigen::VectorXd& markers_m,
                              std::span<Vec3f> vertices_m) const {
  std::ranges::copy(face.neutral_m, vertices_m.begin());
  const Eigen::Index count = neutral_m_.size() / 3;
  for (std::size_t v = 0; v < vertices_.size(); ++v) {
    const float* share = shares_.row(static_cast<Eigen::Index>(v)).data();
    Vec3f moved = Vec3f::Zero();
    for (Eigen::Index m = 0; m < count; ++m)
      moved += share[m] * (markers_m.segment<3>(3 * m) - neutral_m_.segment<3>(3 * m)).cast<float>();
    vertices_m[vertices_[v]] += moved;
  }
}

}  // namespace mien::face
