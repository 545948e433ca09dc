#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "mien/core/error.h"
#include "mien/model/architecture.h"
#include "mien/model/backbone.h"
#include "mien/model/linear.h"
#include "mien/model/safetensors.h"

namespace mien::model {

/// The network of pictures at run time: views of one moment in, answers out, nothing of other moments. One
/// thread. Immutable, so any number of threads may share one, each with a Workspace of its own.
class ViewsNetwork {
 public:
  /// Errors: mismatch (tensors or a kind that do not belong here), out_of_range.
  [[nodiscard]] static Result<ViewsNetwork> create(const Architecture& architecture,
                                                   std::span<const Tensor> network,
                                                   Precision precision = Precision::fp32);

  /// Memory of one thread.
  class Workspace {
   public:
    explicit Workspace(const ViewsNetwork& network);

   private:
    friend class ViewsNetwork;
    Backbone::Workspace eye_, mouth_;
    AlignedFloats features_, hidden_, answer_;
    ConvertedRows converted_;
  };

  /// What the backbones find: `views`: kViews of side x side numbers from 0 to 1, row by row; those that are
  /// not there are passed over, and what stands for them is written. `features`: kViews x features.
  void find(std::span<const float> views, const std::array<bool, kViews>& present, Workspace& workspace,
            std::span<float> features) const;
  /// The same of one view, `which` below kViews: side x side numbers in, its features out, with the bits that
  /// find() gives it beside others.
  void find_one(std::size_t which, std::span<const float> view, Workspace& workspace,
                std::span<float> features) const;
  /// What stands for a view that is not there.
  [[nodiscard]] std::span<const float> missing(std::size_t which) const {
    return {missing_.data() + which * architecture_.features, architecture_.features};
  }
  /// What it answers of them: architecture().outputs numbers, nominally in [-1, 1]. `differences`: features
  /// less those of the wearer at rest, as many; 0 where either is not known.
  void answer(std::span<const float> features, std::span<const float> differences, Workspace& workspace,
              std::span<float> out) const;

  [[nodiscard]] const Architecture& architecture() const { return architecture_; }

 private:
  ViewsNetwork(Backbone eye, Backbone mouth) : eye_(std::move(eye)), mouth_(std::move(mouth)) {}

  Architecture architecture_;
  Backbone eye_, mouth_;
  AlignedFloats missing_;  // kViews x features.
  PackedLinear hidden_, output_;
};

}  // namespace mien::model
