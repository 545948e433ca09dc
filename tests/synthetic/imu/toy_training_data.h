#pragma once

#include <string>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/profile.h"
#include "mien/synthetic/imu/make_dataset.h"

namespace mien::synthetic::test {

/// So many people before these sensors: nothing but numbers that are told apart. Every third sequence is of a
/// take, every second one in *lab*.
inline dataset::Dataset toy_dataset(std::vector<std::string> sensors, std::uint32_t people,
                                    std::uint32_t first = 0) {
  dataset::Dataset out;
  out.sensors = std::move(sensors);
  const std::size_t n = out.sensors.size();
  Random random(first + 1);
  const auto draw = [&](std::size_t count) {
    std::vector<float> values(count);
    for (float& v : values) v = static_cast<float>(random.uniform());
    return values;
  };
  out.standard_slopes = draw(3 * n * face::kShapeCount);
  for (std::uint32_t p = first; p < first + people; ++p) {
    dataset::Sequence& s = out.sequences.emplace_back();
    s.performer = p;
    s.lab = p % 2 == 0;
    s.from_take = p % 3 == 0;
    s.frames = 4 + p % 3;
    s.values = draw(s.frames * 7 * n);
    for (std::size_t i = 0; i < s.frames * 2 * n; ++i) s.present.push_back(random.chance(0.8) ? 1 : 0);
    if (!s.from_take) s.slopes = draw(3 * n * face::kShapeCount);
    s.weights = draw(s.frames * face::kShapeCount);
  }
  return out;
}

inline bool same(const dataset::Dataset& a, const dataset::Dataset& b) {
  if (a.sensors != b.sensors || a.standard_slopes != b.standard_slopes ||
      a.sequences.size() != b.sequences.size())
    return false;
  for (std::size_t i = 0; i < a.sequences.size(); ++i) {
    const dataset::Sequence &x = a.sequences[i], &y = b.sequences[i];
    if (x.performer != y.performer || x.lab != y.lab || x.from_take != y.from_take || x.frames != y.frames ||
        x.values != y.values || x.present != y.present || x.slopes != y.slopes || x.weights != y.weights)
      return false;
  }
  return true;
}

}  // namespace mien::synthetic::test
