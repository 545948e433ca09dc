#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "mien/core/sha256.h"
#include "mien/tracker/answer_correction.h"

namespace {

using namespace mien;

// A wearer's correction of one frame: three moments of 53 answers onto 53.
void correction(benchmark::State& state) {
  model::Correction made{.lags = {0, 3, 9}, .weights = {}};
  for (std::size_t i = 0; i < face::kShapeCount * 3 * face::kShapeCount; ++i)
    made.weights.push_back(0.01F * static_cast<float>(std::sin(0.7 * static_cast<double>(i))));
  const tracker::AnswerCorrection corrected(made);
  tracker::AnswerCorrection::History history(corrected);
  std::vector<face::BlendshapeWeights> frames(600);
  for (std::size_t f = 0; f < frames.size(); ++f)
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      frames[f][k] = static_cast<float>(0.5 + 0.5 * std::sin(0.1 * static_cast<double>(f + 7 * k)));
  std::size_t f = 0;
  for (auto _ : state) {
    face::BlendshapeWeights weights = frames[f];
    corrected.apply(history, weights);
    benchmark::DoNotOptimize(weights.values.data());
    f = (f + 1) % frames.size();
  }
  Sha256 hash;
  history.reset();
  for (face::BlendshapeWeights weights : frames) {
    corrected.apply(history, weights);
    for (const float weight : weights.values) hash.add_value(weight);
  }
  state.SetLabel(hash.hex().substr(0, 16));
}
BENCHMARK(correction);

}  // namespace
