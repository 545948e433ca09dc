#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/model/architecture.h"
#include "mien/model/correction.h"
#include "mien/model/linear.h"
#include "mien/model/safetensors.h"

namespace mien::model {

/// The recurrent network at run time: one frame's condition in, that frame's weights out, nothing of the
/// future. One thread. Steps change nothing in it, so any number of threads may share one; each performance
/// needs a State of its own. In fp32 it agrees with libtorch to 1e-4 over hundreds of frames (`mien-train
/// parity`); what the other precisions cost stands in docs/experiments/engine.md.
class CausalNetwork {
 public:
  /// Lays the weights out for the kernels. Errors: mismatch (tensors or a kind that do not belong here),
  /// out_of_range.
  [[nodiscard]] static Result<CausalNetwork> create(const Architecture& architecture,
                                                    std::span<const Tensor> network,
                                                    Precision precision = Precision::fp32);

  /// Memory that the steps of up to `performers` work in, for one thread.
  class Workspace {
   public:
    explicit Workspace(const CausalNetwork& network, std::size_t performers = 1);

    /// What the output layer read of a performer in the last step, d_model numbers; until the next one.
    [[nodiscard]] std::span<const float> hidden(std::size_t performer) const;

   private:
    friend class CausalNetwork;
    std::size_t performers_ = 0, width_ = 0;
    // A row a performer, row_stride() apart.
    AlignedFloats x_;                        ///< d_model: what the next layer reads.
    AlignedFloats state_;                    ///< d_model: what a layer remembers.
    AlignedFloats from_input_, from_state_;  ///< 3 d_model each: a unit's three parts.
    AlignedFloats answer_;                   ///< outputs.
    ConvertedRows converted_;
  };

  /// What the network remembers of a performance, and memory for steps by itself.
  class State {
   public:
    explicit State(const CausalNetwork& network);
    /// Forgets everything: as at the beginning of a session.
    void reset();

   private:
    friend class CausalNetwork;
    std::vector<AlignedFloats> layers_;  ///< d_model a layer.
    Workspace alone_;
  };

  /// The next frame. `condition`: architecture().condition numbers; `out`: architecture().outputs, nominally
  /// in [-1, 1] (from_network() makes weights of them). No allocation. A condition that is not finite spoils
  /// the state until reset(). Cost: flop_count() and one reading of weight_bytes().
  void step(std::span<const float> condition, State& state, std::span<float> out) const;

  /// The next frame of several performers, with one reading of the weights: `conditions` and `out` hold a row
  /// a performer. Each gets the bits that it would get alone, in every precision.
  void step(std::span<const float> conditions, std::span<State* const> states, Workspace& workspace,
            std::span<float> out) const;

  /// The output layer is corrected for a wearer from now on, in fp32 whatever the precision; nullptr: no
  /// more. Not while it is shared with another thread. Sizes: `weights` outputs x d_model, `bias` outputs.
  void correct(const Correction* correction);

  [[nodiscard]] const Architecture& architecture() const { return architecture_; }
  [[nodiscard]] Precision precision() const { return input_.precision; }
  /// Of all weights as they are laid out: what a step reads at least.
  [[nodiscard]] std::size_t weight_bytes() const;

 private:
  struct Layer {
    PackedLinear input, state;
  };

  CausalNetwork() = default;
  void step_layer(std::size_t index, std::span<State* const> states, Workspace& workspace) const;

  Architecture architecture_;
  PackedLinear input_;
  std::vector<Layer> layers_;
  PackedLinear output_;
  std::optional<PackedLinear> correction_;
};

}  // namespace mien::model
