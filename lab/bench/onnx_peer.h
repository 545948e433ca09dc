#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "app/json_output.h"
#include "mien/core/error.h"

namespace mien::lab {

/// What ONNX Runtime took for a model's network on one thread, in fp32, called through Node. What calling
/// costs by itself was measured with a graph that does nothing, and taken off.
struct PeerTimes {
  /// One exported file. All seconds are medians of rounds' medians.
  struct Graph {
    std::size_t steps = 1;   ///< Steps that one run does.
    double run_s = 0;        ///< One run.
    double echo_s = 0;       ///< One run of the graph that does nothing.
    double step_s = 0;       ///< (run_s - echo_s) / steps.
    double best_step_s = 0;  ///< The same of the quickest rounds.
  };
  std::string version, node;  ///< ONNX Runtime's and Node's, as they write them.
  std::string kind;           ///< Of a model's network: "causal" or "window".
  std::vector<Graph>
      graphs;         ///< Causal: 1, 4, 16 and 64 steps in a row; window: one full window; else as asked.
  double step_s = 0;  ///< The smallest of the graphs' step_s: the peer at its best.
  double best_step_s = 0;  ///< The smallest of their best_step_s.
  /// Of its answers from our run time's to the same input, of the numbers that the graph gives.
  double largest_difference = 0;
  std::string hash;  ///< SHA-256 of the last graph's answer, fp32.
};

/// How long a peer is measured: about graphs * rounds * round_s, and a second to begin.
struct PeerEffort {
  std::size_t rounds = 9;
  double round_s = 0.1;  ///< Of each graph in each round.
};

/// One graph to be timed, what goes in, and what must come out.
struct PeerGraph {
  std::vector<std::byte> onnx;
  std::size_t steps = 1;        ///< Steps that one run does.
  app::Json inputs;             ///< By name: {"dims": [...], "data": [...]}.
  std::vector<float> expected;  ///< Empty: whatever it answers.
};

/// Times graphs in a temporary folder, under this process's own affinity and priority. Errors: not_found (no
/// node, no ONNX Runtime: says how to install them), mismatch (it answers otherwise than expected, by more
/// than 1e-3: then its time is worth nothing), io (what node says).
[[nodiscard]] Result<PeerTimes> measure_graphs(const std::vector<PeerGraph>& graphs,
                                               const PeerEffort& effort);

struct PeerRequest {
  std::filesystem::path model;  ///< A model file of weights, causal or window.
  PeerEffort effort;
};

/// Exports the network and times it. Errors: measure_graphs()'s and the model reader's.
[[nodiscard]] Result<PeerTimes> measure_onnxruntime(const PeerRequest& request);

}  // namespace mien::lab
