#pragma once

#include <cstddef>
#include <vector>

#include "mien/face/profile.h"
#include "mien/model/correction.h"

namespace mien::tracker {

/// Applies a wearer's correction to answers, frame by frame. Immutable; performances may share one.
class AnswerCorrection {
 public:
  /// As a model file holds it, of the 53 shapes.
  explicit AnswerCorrection(const model::Correction& correction);

  /// A performance's newest answers, before they were corrected.
  class History {
   public:
    explicit History(const AnswerCorrection& correction) : answers_(correction.lags_.back() + 1) {}
    /// Forgets them.
    void reset() { frames_ = 0; }

   private:
    friend class AnswerCorrection;
    std::vector<face::BlendshapeWeights> answers_;  // A ring.
    std::size_t frames_ = 0;
  };

  /// The next frame's weights, in place, to [0, 1]. What came before the first frame is taken to be as that.
  /// No allocation; under 2 us (bench/correction_bench.cpp).
  void apply(History& history, face::BlendshapeWeights& weights) const;

 private:
  std::vector<std::size_t> lags_;
  std::vector<float> columns_;  // W by columns: what each input adds to all shapes.
  std::vector<char> used_;      // Whether a column has anything.
};

}  // namespace mien::tracker
