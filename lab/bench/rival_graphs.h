#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mien::lab {

/// A graph of the size of a network that another program runs, with random weights: what it costs to run, and
/// nothing of what it knows. One input, "pictures".
struct RivalGraph {
  std::vector<std::byte> onnx;
  std::vector<std::size_t> input;  ///< Its shape: batch, channels, rows, columns.
};

/// Six convolutions of 3 x 3 (14, 21, 32, 47, 70 and 106 channels) with pooling by 2 between them, over four
/// pictures of 112 x 112 at once (two eyes, two moments), to seven numbers: as open eye trackers of headsets
/// have them.
[[nodiscard]] RivalGraph rival_eye_graph(std::uint64_t seed);

/// EfficientNet-B0 (Tan and Le 2019, arXiv:1905.11946, table 1) over one grey picture of 224 x 224, to 45
/// shapes: as an open mouth tracker has it.
[[nodiscard]] RivalGraph rival_mouth_graph(std::uint64_t seed);

}  // namespace mien::lab
