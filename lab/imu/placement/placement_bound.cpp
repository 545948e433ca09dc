#include "lab/imu/placement/placement_bound.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "mien/core/units.h"

namespace mien::lab {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
constexpr auto kPlacementShapes = static_cast<Index>(face::kShapeCount);
constexpr std::size_t kMostInMiddle = 3;

/// Candidates that are chosen together.
using SiteGroup = std::vector<std::size_t>;

MatrixXd rows_of(const MatrixXd& slopes, const SiteGroup& group) {
  MatrixXd rows(3 * static_cast<Index>(group.size()), slopes.cols());
  for (std::size_t i = 0; i < group.size(); ++i)
    rows.middleRows(3 * static_cast<Index>(i), 3) = slopes.middleRows(3 * static_cast<Index>(group[i]), 3);
  return rows;
}

/// One search: what is known so far.
struct PlacementSearch {
  const std::vector<SensorCandidate>& candidates;
  const MatrixXd& slopes;
  const MatrixXd& gram;
  const PlacementSettings& settings;

  [[nodiscard]] bool has_room(const SiteGroup& group, const std::vector<std::size_t>& chosen) const {
    for (const std::size_t i : group)
      for (const std::size_t c : chosen)
        if ((candidates[i].position_m - candidates[c].position_m).norm() < settings.apart_m) return false;
    return true;
  }

  /// What each group gains, of those that have room; below 0 where they have none.
  [[nodiscard]] std::vector<double> gains(const std::vector<SiteGroup>& groups,
                                          const PlacementSet& set) const {
    // h C and h C G C of all candidates at once.
    const MatrixXd h_c = slopes * set.covariance;
    const MatrixXd h_cgc = h_c * (gram * set.covariance);
    const double noise = settings.noise_rad * settings.noise_rad;
    std::vector<double> out;
    for (const SiteGroup& group : groups) {
      if (!has_room(group, set.chosen)) {
        out.push_back(-1);
        continue;
      }
      const auto size = 3 * static_cast<Index>(group.size());
      MatrixXd innovation(size, size), gain(size, size);  // h C h^T + noise^2 I, h C G C h^T.
      for (std::size_t a = 0; a < group.size(); ++a)
        for (std::size_t b = 0; b < group.size(); ++b) {
          const auto h_b = slopes.middleRows(3 * static_cast<Index>(group[b]), 3).transpose();
          const auto row = 3 * static_cast<Index>(a), column = 3 * static_cast<Index>(b);
          innovation.block<3, 3>(row, column) = h_c.middleRows(3 * static_cast<Index>(group[a]), 3) * h_b;
          gain.block<3, 3>(row, column) = h_cgc.middleRows(3 * static_cast<Index>(group[a]), 3) * h_b;
        }
      innovation.diagonal().array() += noise;
      out.push_back(innovation.llt().solve(gain).trace());
    }
    return out;
  }

  void add(const SiteGroup& group, PlacementSet& set) const {
    set.covariance = posterior_with(set.covariance, rows_of(slopes, group), settings.noise_rad);
    set.chosen.insert(set.chosen.end(), group.begin(), group.end());
    set.squared_error = expected_squared_error(gram, set.covariance);
  }

  /// Adds the best of the groups; false where none has room.
  bool add_best(const std::vector<SiteGroup>& groups, PlacementSet& set) const {
    if (groups.empty()) return false;
    const std::vector<double> gain = gains(groups, set);
    const auto best = std::ranges::max_element(gain);
    if (*best < 0) return false;
    add(groups[static_cast<std::size_t>(best - gain.begin())], set);
    return true;
  }

  [[nodiscard]] PlacementSet no_sensor() const {
    PlacementSet set;
    set.covariance = prior_covariance(settings.prior);
    set.squared_error = expected_squared_error(gram, set.covariance);
    return set;
  }
};

std::vector<PlacementSet> search_one_sided(const PlacementSearch& search) {
  std::vector<SiteGroup> groups;
  for (std::size_t i = 0; i < search.candidates.size(); ++i) groups.push_back({i});
  std::vector<PlacementSet> sets;
  PlacementSet set = search.no_sensor();
  while (set.chosen.size() < search.settings.most && search.add_best(groups, set)) sets.push_back(set);
  return sets;
}

/// Sets with `middle` sensors on the midline, by the number of their pairs; the last ones of the midline are
/// added to each where the search would have taken them later.
std::vector<std::optional<PlacementSet>> search_pairs(const PlacementSearch& search,
                                                      const std::vector<SiteGroup>& pairs,
                                                      const std::vector<SiteGroup>& singles,
                                                      std::size_t middle) {
  std::vector<std::optional<PlacementSet>> sets;
  PlacementSet set = search.no_sensor();
  std::size_t in_middle = 0;
  for (std::size_t pair = 0; 2 * pair + middle <= search.settings.most; ++pair) {
    if (pair > 0) {
      // Sensors of the midline that gain more than half of what the best pair does come first.
      bool added = false;
      while (!added) {
        const std::vector<double> of_pairs = search.gains(pairs, set);
        if (pairs.empty() || *std::ranges::max_element(of_pairs) < 0) return sets;
        const auto best = std::ranges::max_element(of_pairs);
        if (in_middle < middle && !singles.empty()) {
          const std::vector<double> of_singles = search.gains(singles, set);
          const auto single = std::ranges::max_element(of_singles);
          if (*single > *best / 2) {
            search.add(singles[static_cast<std::size_t>(single - of_singles.begin())], set);
            ++in_middle;
            continue;
          }
        }
        search.add(pairs[static_cast<std::size_t>(best - of_pairs.begin())], set);
        added = true;
      }
    }
    PlacementSet whole = set;
    std::size_t had = in_middle;
    while (had < middle && search.add_best(singles, whole)) ++had;
    sets.push_back(had == middle ? std::optional(std::move(whole)) : std::nullopt);
  }
  return sets;
}

Result<std::vector<PlacementSet>> search_symmetric(const PlacementSearch& search) {
  const std::vector<std::size_t> mirror = mirror_candidates(search.candidates);
  std::vector<SiteGroup> pairs, singles;
  for (std::size_t i = 0; i < mirror.size(); ++i) {
    const std::size_t other = mirror[i];
    if (other == i) singles.push_back({i});
    if (other == mirror.size() || other <= i || mirror[other] != i) continue;
    const double apart_m = (search.candidates[i].position_m - search.candidates[other].position_m).norm();
    if (apart_m >= search.settings.apart_m) pairs.push_back({i, other});
  }
  if (pairs.empty() && singles.empty())
    return fail(ErrorCode::bad_usage, "no candidate has a partner on the other side of the face", {},
                "give mirror images, or let each side be for itself (--one-sided)");
  std::vector<std::optional<PlacementSet>> best(search.settings.most + 1);
  for (std::size_t middle = 0; middle <= std::min(kMostInMiddle, singles.size()); ++middle)
    for (std::optional<PlacementSet>& set : search_pairs(search, pairs, singles, middle)) {
      if (!set || set->chosen.empty()) continue;
      std::optional<PlacementSet>& place = best[set->chosen.size()];
      if (!place || set->squared_error < place->squared_error) place = std::move(set);
    }
  std::vector<PlacementSet> sets;
  for (std::optional<PlacementSet>& set : best)
    if (set) sets.push_back(std::move(*set));
  return sets;
}

/// Each group has an equal share of the trace.
MatrixXd even_groups() {
  std::array<double, kShapeGroups.size()> shapes{};
  for (std::size_t k = 0; k < face::kShapeCount; ++k) ++shapes[shape_group(k)];
  Eigen::VectorXd diagonal(kPlacementShapes);
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    diagonal[static_cast<Index>(k)] = 1 / (static_cast<double>(kShapeGroups.size()) * shapes[shape_group(k)]);
  return diagonal.asDiagonal();
}

}  // namespace

MatrixXd placement_gram(const face::Face& face, PlacementObjective objective) {
  if (objective == PlacementObjective::mse)
    return MatrixXd::Identity(kPlacementShapes, kPlacementShapes) / static_cast<double>(kPlacementShapes);
  if (objective == PlacementObjective::groups) return even_groups();
  std::vector<char> counts(face.neutral_m.size(), 1);
  double count = static_cast<double>(counts.size());
  if (const face::Region* skin = face.region("skin"); skin != nullptr && !skin->vertex.empty()) {
    std::ranges::fill(counts, 0);
    for (const std::uint32_t v : skin->vertex) counts[v] = 1;
    count = static_cast<double>(skin->vertex.size());
  }
  MatrixXd gram(kPlacementShapes, kPlacementShapes);
  for (std::size_t a = 0; a < face::kShapeCount; ++a)
    for (std::size_t b = a; b < face::kShapeCount; ++b) {
      // Both lists of vertices ascend.
      const face::Shape &one = face.shapes[a], &two = face.shapes[b];
      double sum = 0;
      for (std::size_t i = 0, j = 0; i < one.vertex.size() && j < two.vertex.size();) {
        if (one.vertex[i] < two.vertex[j]) {
          ++i;
        } else if (two.vertex[j] < one.vertex[i]) {
          ++j;
        } else {
          if (counts[one.vertex[i]] != 0)
            sum += one.delta_m[i].cast<double>().dot(two.delta_m[j].cast<double>());
          ++i;
          ++j;
        }
      }
      gram(static_cast<Index>(a), static_cast<Index>(b)) =
          gram(static_cast<Index>(b), static_cast<Index>(a)) = kMmPerM * kMmPerM * sum / count;
    }
  return gram;
}

MatrixXd prior_covariance(double prior) {
  return MatrixXd::Identity(kPlacementShapes, kPlacementShapes) * (prior * prior);
}

double expected_squared_error(const MatrixXd& gram, const MatrixXd& covariance) {
  return gram.cwiseProduct(covariance).sum();  // Both are symmetric.
}

MatrixXd posterior_with(const MatrixXd& covariance, const MatrixXd& rows, double noise_rad) {
  const MatrixXd h_c = rows * covariance;
  MatrixXd innovation = h_c * rows.transpose();
  innovation.diagonal().array() += noise_rad * noise_rad;
  const MatrixXd next = covariance - h_c.transpose() * innovation.llt().solve(h_c);
  return (next + next.transpose()) / 2;
}

std::vector<double> error_reductions(const MatrixXd& gram, const MatrixXd& covariance, const MatrixXd& slopes,
                                     double noise_rad) {
  const MatrixXd h_c = slopes * covariance;
  const MatrixXd h_cgc = h_c * (gram * covariance);
  const double squared_error = expected_squared_error(gram, covariance);
  std::vector<double> reductions;
  for (Index row = 0; row + 2 < slopes.rows(); row += 3) {
    const auto h = slopes.middleRows<3>(row).transpose();
    Mat3 innovation = h_c.middleRows<3>(row) * h;
    innovation.diagonal().array() += noise_rad * noise_rad;
    const Mat3 gain = h_cgc.middleRows<3>(row) * h;
    reductions.push_back(innovation.llt().solve(gain).trace() / squared_error);
  }
  return reductions;
}

PosteriorOverPrior posterior_over_prior(const MatrixXd& covariance, double prior) {
  PosteriorOverPrior ratios{};
  for (std::size_t k = 0; k < ratios.size(); ++k)
    ratios[k] = std::sqrt(std::max(0.0, covariance(static_cast<Index>(k), static_cast<Index>(k)))) / prior;
  return ratios;
}

const PlacementSet* PlacementBound::of_size(std::size_t sensors) const {
  const auto found =
      std::ranges::find_if(sets, [sensors](const PlacementSet& set) { return set.chosen.size() == sensors; });
  return found == sets.end() ? nullptr : &*found;
}

Result<PlacementBound> bound_placement(const std::vector<SensorCandidate>& candidates, const MatrixXd& slopes,
                                       const MatrixXd& gram, const PlacementSettings& settings) {
  if (candidates.empty()) return fail(ErrorCode::bad_usage, "there is no candidate for a sensor");
  const PlacementSearch search{candidates, slopes, gram, settings};
  PlacementBound bound;
  if (settings.one_sided) {
    bound.sets = search_one_sided(search);
    return bound;
  }
  MIEN_TRY_ASSIGN(bound.sets, search_symmetric(search));
  return bound;
}

std::size_t shape_group(std::size_t shape) {
  const std::string_view name = face::kShapeNames[shape];
  if (name.starts_with("brow")) return 0;
  if (name.starts_with("eye")) return 1;
  if (name.starts_with("cheek") || name.starts_with("nose")) return 2;
  return name.starts_with("jaw") ? 4 : 3;
}

}  // namespace mien::lab
