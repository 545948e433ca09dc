#include "mien/model/confidence.h"

#include <algorithm>
#include <cmath>

#include "mien/core/logistic.h"

namespace mien::model {
namespace {

bool is_share(float value) {
  return value >= 0 && value <= 1;  // What is no number is none.
}

/// Ascending, above 0, at most 1.
bool are_edges(std::span<const float> edges) {
  float last = 0;
  for (const float edge : edges) {
    if (!(edge > last && edge <= 1)) return false;
    last = edge;
  }
  return true;
}

bool is_sound(const LogisticMap& map) {
  return std::abs(map.offset) <= LogisticMap::kLargest && std::abs(map.slope) <= LogisticMap::kLargest;
}

}  // namespace

float LogisticMap::at(float score) const {
  return logistic(offset + slope * score);
}

Result<void> check(const ConfidenceTable& table, std::size_t shapes, const std::string& where) {
  const std::size_t coverages = table.coverage_bins(), values = table.value_bins();
  if (coverages > kMostConfidenceBins || values > kMostConfidenceBins)
    return fail(ErrorCode::out_of_range, "the confidence table has too many bins", where);
  if (table.explained.size() != shapes * coverages || table.within.size() != shapes * coverages * values)
    return fail(ErrorCode::mismatch, "the confidence table has another size than shapes and bins", where);
  if (!are_edges(table.coverage_edges) || !are_edges(table.value_edges))
    return fail(ErrorCode::out_of_range, "the edges of the confidence table's bins do not ascend", where);
  if (!is_share(table.measured_from) || !std::ranges::all_of(table.explained, is_share) ||
      !std::ranges::all_of(table.within, is_share))
    return fail(ErrorCode::out_of_range, "a share of the confidence table is not within 0 to 1", where);
  for (std::size_t k = 0; k < shapes; ++k)
    if (!std::ranges::is_sorted(std::span(table.explained).subspan(k * coverages, coverages)))
      return fail(ErrorCode::out_of_range, "a shape's explained share grows as sensors are lost", where);
  if (table.regions && !std::ranges::all_of(*table.regions, is_sound))
    return fail(ErrorCode::out_of_range, "the map of a region's confidence is beyond its range", where);
  return {};
}

}  // namespace mien::model
