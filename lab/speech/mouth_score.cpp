#include "lab/speech/mouth_score.h"

#include <utility>
#include <vector>

#include "mien/speech/listener.h"

namespace mien::lab {

MouthScore score_mouth(const measure::Meter& meter, std::span<const measure::Stretch> stretches) {
  std::vector<std::vector<face::BlendshapeWeights>> mouths;
  std::vector<measure::Stretch> moved;
  for (const measure::Stretch& stretch : stretches) {
    std::vector<face::BlendshapeWeights> mouth(stretch.truth.begin(), stretch.truth.end());
    for (std::size_t f = 0; f < mouth.size(); ++f)
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        if (speech::is_heard(k)) mouth[f][k] = stretch.estimate[f][k];
    mouths.push_back(std::move(mouth));
    moved.push_back({stretch.truth, mouths.back()});
  }
  const measure::Metrics metrics = meter.measure(moved);
  return {metrics.pve_mm.mean, metrics.per_shape[face::shape("jawOpen")].pearson};
}

}  // namespace mien::lab
