#include "mien/synthetic/confidence_fit.h"

#include <algorithm>
#include <cmath>

#include "mien/tracker/shape_confidence.h"

namespace mien::synthetic {
namespace {

/// The lowest bin has nothing of what the shape is read from, the highest all of it.
const std::vector<float> kCoverageEdges = {0.001F, 0.3F, 0.5F, 0.7F, 0.85F, 0.999F};
/// Narrow where most frames are: shapes rest most of the time.
const std::vector<float> kValueEdges = {0.02F, 0.05F, 0.1F, 0.15F, 0.2F, 0.3F, 0.45F, 0.6F, 0.8F};
constexpr double kSpare = 0.02;

}  // namespace

void Correlation::add(double truth, double estimate) {
  n_ += 1;
  truth_ += truth;
  estimate_ += estimate;
  truth_square_ += truth * truth;
  estimate_square_ += estimate * estimate;
  product_ += truth * estimate;
}

bool Correlation::speaks() const {
  return n_ >= kFrames && truth_square_ / n_ - (truth_ / n_) * (truth_ / n_) >= kMoves * kMoves;
}

double Correlation::r() const {
  const double truth = truth_square_ - truth_ * truth_ / n_;
  const double estimate = estimate_square_ - estimate_ * estimate_ / n_;
  constexpr double kStill = 1e-9;
  return truth > kStill && estimate > kStill
             ? (product_ - truth_ * estimate_ / n_) / std::sqrt(truth * estimate)
             : 0;
}

ConfidenceFit::ConfidenceFit() {
  empty_.coverage_edges = kCoverageEdges;
  empty_.value_edges = kValueEdges;
  const std::size_t rows = face::kShapeCount * empty_.coverage_bins();
  moments_.resize(rows);
  person_.resize(rows);
  hits_.resize(rows * empty_.value_bins());
}

void ConfidenceFit::add(std::size_t shape, float coverage, float estimate, float truth) {
  const std::size_t row =
      shape * empty_.coverage_bins() + model::confidence_bin(empty_.coverage_edges, coverage);
  Moments& moments = moments_[row];
  const double error = static_cast<double>(estimate) - truth;
  moments.frames += 1;
  moments.sum += truth;
  moments.square += static_cast<double>(truth) * truth;
  moments.squared_error += error * error;
  Hits& hits = hits_[row * empty_.value_bins() + model::confidence_bin(empty_.value_edges, estimate)];
  hits.frames += 1;
  hits.within += std::abs(error) <= model::kConfidenceTolerance ? 1 : 0;
  person_[row].add(truth, estimate);
}

void ConfidenceFit::end_person() {
  for (std::size_t row = 0; row < person_.size(); ++row) {
    if (person_[row].speaks() && !tracker::is_gaze(row / empty_.coverage_bins()))
      pairs_.push_back({row, person_[row].r()});
    person_[row] = {};
  }
}

void ConfidenceFit::add(const ConfidenceFit& other) {
  for (std::size_t i = 0; i < moments_.size(); ++i) {
    moments_[i].frames += other.moments_[i].frames;
    moments_[i].sum += other.moments_[i].sum;
    moments_[i].square += other.moments_[i].square;
    moments_[i].squared_error += other.moments_[i].squared_error;
  }
  for (std::size_t i = 0; i < hits_.size(); ++i) {
    hits_[i].frames += other.hits_[i].frames;
    hits_[i].within += other.hits_[i].within;
  }
  pairs_.insert(pairs_.end(), other.pairs_.begin(), other.pairs_.end());
}

model::ConfidenceTable ConfidenceFit::table() const {
  model::ConfidenceTable out = empty_;
  out.explained = explained();
  out.within = within();
  out.measured_from = measured_from(out.explained);
  return out;
}

std::vector<float> ConfidenceFit::explained() const {
  const std::size_t bins = empty_.coverage_bins();
  std::vector<float> out(moments_.size());
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    float next = 1;
    for (std::size_t c = bins; c-- > 0;) {
      const Moments& m = moments_[k * bins + c];
      const double variance = m.frames > 0 ? m.square - m.sum * m.sum / m.frames : 0;
      const double share = variance > 0 ? 1 - m.squared_error / variance : 0;
      // Where one sensor tells half of a shape, no set of sensors leaves some bins in between: these keep
      // the next one's. The highest and the lowest claim nothing that nobody saw.
      const bool unseen = m.frames == 0 && c + 1 < bins && c > 0;
      next = unseen ? next : std::min(next, static_cast<float>(std::clamp(share, 0.0, 1.0)));
      out[k * bins + c] = next;
    }
  }
  return out;
}

std::vector<float> ConfidenceFit::within() const {
  const std::size_t coverages = empty_.coverage_bins(), values = empty_.value_bins();
  const auto drawn = [](const Hits& own, double towards) {
    return (own.within + kPrior * towards) / (own.frames + kPrior);
  };
  std::vector<Hits> of_value(values);
  for (std::size_t i = 0; i < hits_.size(); ++i) {
    of_value[i % values].frames += hits_[i].frames;
    of_value[i % values].within += hits_[i].within;
  }
  std::vector<float> out(hits_.size());
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    for (std::size_t v = 0; v < values; ++v) {
      Hits shape;
      for (std::size_t c = 0; c < coverages; ++c) {
        const Hits& one = hits_[(k * coverages + c) * values + v];
        shape.frames += one.frames;
        shape.within += one.within;
      }
      const double own = drawn(shape, drawn(of_value[v], 0));
      for (std::size_t c = 0; c < coverages; ++c) {
        const std::size_t cell = (k * coverages + c) * values + v;
        out[cell] = static_cast<float>(drawn(hits_[cell], own));
      }
    }
  return out;
}

float ConfidenceFit::measured_from(const std::vector<float>& explained) const {
  constexpr int kSteps = 20;
  for (int step = 1; step < kSteps; ++step) {
    const float from = static_cast<float>(step) / kSteps;
    double all = 0, good = 0;
    for (const Pair& pair : pairs_) {
      if (explained[pair.row] < from) continue;
      all += 1;
      good += pair.r >= kMeasuredCorrelation ? 1 : 0;
    }
    if (all >= kFewest && good >= (kMeasuredShare + kSpare) * all) return from;
  }
  return 1;
}

}  // namespace mien::synthetic
