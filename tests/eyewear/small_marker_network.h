#pragma once

#include "mien/eyewear/marker_network.h"
#include "tests/model/random_network.h"

namespace mien::eyewear::test {

/// Three sensors, two markers and a random network, small enough for tests and for a corpus.
inline MarkerNetworkFile small_marker_network() {
  MarkerNetworkFile file;
  file.architecture = {.name = "small",
                       .kind = model::NetworkKind::causal,
                       .layers = 1,
                       .d_model = 32,
                       .heads = 0,
                       .d_head = 0,
                       .ffn = 0,
                       .window = 8,
                       .condition = 6,
                       .outputs = 6};
  file.sensors = {"s0", "s1", "s2"};
  file.markers = {"brow", "chin"};
  file.scale_m = 0.02;
  file.rig = "# rig";
  file.recipe = "seed = 1\n";
  file.results = R"({"markers":{"mean_mm":2}})";
  file.network = model::random_network(file.architecture, 1);
  return file;
}

}  // namespace mien::eyewear::test
