#include "mien/face/profile_map.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "mien/core/excerpt.h"
#include "mien/core/nearest_word.h"

namespace mien::face {
namespace {

/// The sum begins with its first term and not with 0: a row that takes one weight over keeps its bits.
template <class Weight>
float row_sum(std::span<const ProfileTerm> row, Weight weight) noexcept {
  if (row.empty()) return 0;
  float sum = row.front().factor * weight(row.front().column);
  for (const ProfileTerm& term : row.subspan(1)) sum += term.factor * weight(term.column);
  return sum;
}

std::size_t rows_of_several(const SparseRows& rows) noexcept {
  std::size_t count = 0;
  for (std::size_t row = 0; row < rows.size(); ++row) count += rows[row].size() > 1 ? 1 : 0;
  return count;
}

}  // namespace

void ProfileMap::from_ict(const BlendshapeWeights& ict, float tongue_out,
                          std::span<float> out) const noexcept {
  const auto weight = [&](std::size_t k) { return k < kShapeCount ? ict[k] : tongue_out; };
  for (std::size_t i = 0; i < std::min(out.size(), outward.size()); ++i) out[i] = row_sum(outward[i], weight);
}

BlendshapeWeights ProfileMap::to_ict(std::span<const float> weights, float* tongue_out) const noexcept {
  const auto weight = [&](std::size_t i) { return i < weights.size() ? weights[i] : 0.0F; };
  BlendshapeWeights ict;
  for (std::size_t k = 0; k < kShapeCount; ++k) ict[k] = row_sum(inward[k], weight);
  if (tongue_out != nullptr) *tongue_out = row_sum(inward[kShapeCount], weight);
  return ict;
}

std::string_view ProfileMap::group_of(std::size_t shape) const noexcept {
  for (const ShapeGroup& group : groups) {
    if (shape < group.count) return group.name;
    shape -= group.count;
  }
  return {};
}

std::size_t ProfileMap::merged_count() const noexcept {
  return rows_of_several(outward);
}

std::size_t ProfileMap::divided_count() const noexcept {
  // Of the outward matrix: a shape that the way back does not read (its share is 0) is made of ours all the
  // same.
  std::array<std::size_t, kInnerCount> made_of{};
  for (const ProfileTerm& term : outward.terms) ++made_of[term.column];
  return static_cast<std::size_t>(std::ranges::count_if(made_of, [](std::size_t n) { return n > 1; }));
}

const ProfileMap& profile_map(OutsideProfile profile) noexcept {
  return profile_maps()[static_cast<std::size_t>(profile)];
}

Result<const ProfileMap*> find_profile_map(const std::string& name) {
  std::vector<std::string> names;
  for (const ProfileMap& map : profile_maps()) {
    if (map.name == name) return &map;
    names.emplace_back(map.name);
  }
  return fail(ErrorCode::not_found,
              fmt::format("there is no profile '{}'{}", excerpt(name), did_you_mean(name, names)), {},
              fmt::format("there are: {}", fmt::join(names, ", ")));
}

}  // namespace mien::face
