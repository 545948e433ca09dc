#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/train/toy_data.h"

namespace mien::train {

/// The shape that toy takes hold at 0.9, and toy performers at 0.05: by it a window tells whose it is.
inline constexpr std::size_t kShapeOfTakes = 10;

/// The toy's people with real sensors: in one profile, of unknown skin, not yet marked.
inline dataset::Dataset toy_takes(std::uint32_t first_person, std::size_t people, std::size_t frames = 200) {
  dataset::Dataset dataset = toy_data(first_person, people, frames);
  std::erase_if(dataset.sequences, [](const dataset::Sequence& s) { return s.lab; });
  for (dataset::Sequence& s : dataset.sequences)
    for (std::size_t f = 0; f < s.frames; ++f) s.weights[f * face::kShapeCount + kShapeOfTakes] = 0.9F;
  return dataset;
}

}  // namespace mien::train
