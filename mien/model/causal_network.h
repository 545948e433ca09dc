#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/model/architecture.h"
#include "mien/model/kernels.h"
#include "mien/model/safetensors.h"

namespace mien::model {

/// The recurrent network at run time: one frame's condition in, that frame's weights out, nothing of the
/// future. fp32, one thread. Immutable, so any number of threads may share one; each performance needs a
/// State of its own. Agrees with libtorch to 1e-4 over hundreds of frames (`mien-train parity`).
class CausalNetwork {
 public:
  /// Lays the weights out for the kernels. Errors: mismatch (tensors or a kind that do not belong here),
  /// out_of_range.
  [[nodiscard]] static Result<CausalNetwork> create(const Architecture& architecture,
                                                    std::span<const Tensor> network);

  /// What the network remembers of a performance, and the memory that a step works in.
  class State {
   public:
    explicit State(const CausalNetwork& network);
    /// Forgets everything: as at the beginning of a session.
    void reset();

   private:
    friend class CausalNetwork;
    std::vector<AlignedFloats> layers_;      ///< d_model a layer.
    AlignedFloats x_;                        ///< d_model: what the next layer reads.
    AlignedFloats from_input_, from_state_;  ///< 3 d_model each: a unit's three parts.
    AlignedFloats answer_;                   ///< padded(outputs).
  };

  /// The next frame. `condition`: architecture().condition numbers; `out`: architecture().outputs, nominally
  /// in
  /// [-1, 1] (from_network() makes weights of them). No allocation. A condition that is not finite spoils the
  /// state until reset(). Cost: flop_count(), about 30 us for two layers of 256.
  void step(std::span<const float> condition, State& state, std::span<float> out) const;

  [[nodiscard]] const Architecture& architecture() const { return architecture_; }

 private:
  struct Layer {
    PackedLinear input, state;
  };

  CausalNetwork() = default;

  Architecture architecture_;
  PackedLinear input_;
  std::vector<Layer> layers_;
  PackedLinear output_;
};

}  // namespace mien::model
