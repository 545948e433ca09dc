#include "mien/tracker/shape_confidence.h"

#include <utility>

#include "mien/tracker/provenance.h"

namespace mien::tracker {

ShapeConfidence::ShapeConfidence(std::optional<model::ConfidenceTable> table) : table_(std::move(table)) {
  if (!table_) return;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    for (std::size_t bin = 0; bin < table_->coverage_bins(); ++bin)
      provenance_.push_back(provenance_of(*table_, k, bin));
}

Explained ShapeConfidence::write(const Coverage& coverage, face::OutputFrame& out) const {
  Explained explained{};
  if (!table_) {
    out.provenance.fill(face::Provenance::predicted);
    out.confidence.fill(0);
    return explained;
  }
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const std::size_t row =
        k * table_->coverage_bins() + model::confidence_bin(table_->coverage_edges, coverage[k]);
    explained[k] = table_->explained[row];
    out.provenance[k] = provenance_[row];
    out.confidence[k] =
        table_
            ->within[row * table_->value_bins() + model::confidence_bin(table_->value_edges, out.weights[k])];
  }
  return explained;
}

}  // namespace mien::tracker
