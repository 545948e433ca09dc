#pragma once

#include <cstddef>
#include <vector>

#include "mien/face/profile.h"
#include "mien/model/confidence.h"

namespace mien::synthetic {

/// Pearson correlation of two tracks, sample by sample.
class Correlation {
 public:
  void add(double truth, double estimate);
  /// Whether there is one to speak of: ten seconds of frames, in which the truth's standard deviation is at
  /// least kMoves. Of a shape that hardly moves a correlation says nothing.
  [[nodiscard]] bool speaks() const;
  /// -1 to 1; 0 where the estimate does not move.
  [[nodiscard]] double r() const;

  static constexpr std::size_t kFrames = 600;
  static constexpr double kMoves = 0.03;

 private:
  double n_ = 0, truth_ = 0, estimate_ = 0, truth_square_ = 0, estimate_square_ = 0, product_ = 0;
};

/// Correlation with the truth that a measured shape is to have, and for what share of them.
inline constexpr double kMeasuredCorrelation = 0.5;
inline constexpr double kMeasuredShare = 0.9;

/// Sums up a tracker's answers beside the truth, and makes a table of them (model::ConfidenceTable).
class ConfidenceFit {
 public:
  ConfidenceFit();
  /// A frame of one shape. `coverage`: what was there of what the shape is read from (tracker::Coverage).
  void add(std::size_t shape, float coverage, float estimate, float truth);
  /// Ends what one person did under one set of sensors: a correlation is of one of these.
  void end_person();
  /// Adds what another has summed up; it has ended its person.
  void add(const ConfidenceFit& other);

  /// The explained share of each shape and bin of coverage, held to that of the next higher bin; the share
  /// within tolerance, drawn towards the shape's own over all coverages and from there towards that of all
  /// shapes by kPrior frames; the least explained share, in steps of a twentieth, from which on
  /// kMeasuredShare of at least kFewest correlations reach kMeasuredCorrelation, with two hundredths to spare
  /// (1: none).
  /// People and seed are left to the caller.
  [[nodiscard]] model::ConfidenceTable table() const;

  /// Ten seconds: frames in a row are alike, so fewer tell little. Raising: rare bins become more like common
  /// ones. Lowering: they follow their few frames.
  static constexpr double kPrior = 600;
  /// Fewer correlations than these show no share of nine in ten: of one shape and two dozen people 92 % were
  /// good, and of two dozen others 75 % (docs/experiments/confidence.md). Raising: only what many people and
  /// shapes show is measured. Lowering: a lucky few make it so.
  static constexpr double kFewest = 50;

 private:
  struct Moments {
    double frames = 0, sum = 0, square = 0, squared_error = 0;
  };
  struct Hits {
    double frames = 0, within = 0;
  };
  struct Pair {
    std::size_t row = 0;  ///< Of `explained`.
    double r = 0;
  };

  [[nodiscard]] std::vector<float> explained() const;
  [[nodiscard]] std::vector<float> within() const;
  [[nodiscard]] float measured_from(const std::vector<float>& explained) const;

  model::ConfidenceTable empty_;  ///< The edges.
  std::vector<Moments> moments_;  ///< shapes x coverage bins.
  std::vector<Hits> hits_;        ///< shapes x coverage bins x value bins.
  std::vector<Correlation> person_;
  std::vector<Pair> pairs_;
};

}  // namespace mien::synthetic
