#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/model/architecture.h"
#include "mien/model/convolution.h"
#include "mien/model/linear.h"
#include "mien/model/safetensors.h"

namespace mien::model {

/// The size of a network that looks at pictures: convolutions of 3 x 3 pixels and stride 2, each with a ReLU,
/// then a linear layer of the last map.
struct BackboneShape {
  std::size_t size = 96;  ///< Pixels of a picture either way; 8 to 256.
  /// Channels of each convolution, 1 to 1024; at most kMostConvolutions of them, at least one.
  std::vector<std::size_t> widths = {16, 32, 64, 96, 128};
  std::size_t features = 96;  ///< Numbers that come out, 1 to 4096.
  bool operator==(const BackboneShape&) const = default;
};

inline constexpr std::size_t kMostConvolutions = 8;

/// Of both backbones of a network of pictures.
[[nodiscard]] BackboneShape backbone_shape(const Architecture& architecture);

/// Errors: out_of_range. Everything below expects a checked one.
[[nodiscard]] Result<void> check(const BackboneShape& shape);

/// Size of the map behind `convolutions` of them; 0: the picture.
[[nodiscard]] MapSize map_size(const BackboneShape& shape, std::size_t convolutions);

/// Every tensor, in one fixed order, as libtorch has them: "convolutions.K.weight" [out, in, 3, 3] and .bias,
/// then "features.weight" [features, channels x height x width of the last map] and .bias.
[[nodiscard]] std::vector<TensorSpec> tensor_specs(const BackboneShape& shape);

/// Floating point operations of one picture, a multiplication and its addition counting as two; what is
/// multiplied with the zeros around a map counts.
[[nodiscard]] double flop_count(const BackboneShape& shape);

/// The network at run time: pictures in, features out. One thread. Immutable, so any number of threads may
/// share one, each with a Workspace of its own.
class Backbone {
 public:
  /// Lays the weights out for the kernels. The first layer and everything between layers' sums is fp32 in
  /// every precision. Errors: out_of_range (shape, numbers that are not finite), mismatch (tensors that do
  /// not belong here).
  [[nodiscard]] static Result<Backbone> create(const BackboneShape& shape, std::span<const Tensor> tensors,
                                               Precision precision = Precision::fp32);

  /// Memory that calls of up to `pictures` work in, for one thread.
  class Workspace {
   public:
    explicit Workspace(const Backbone& backbone, std::size_t pictures = 1);

   private:
    friend class Backbone;
    std::size_t pictures_ = 0;
    std::size_t line_ = 0;           ///< Numbers of a line of the picture below.
    AlignedFloats picture_;          ///< With zeros around it.
    std::vector<FeatureMaps> maps_;  ///< Behind each convolution.
    ConvolutionMemory memory_;
    AlignedFloats answers_;  ///< A row of features a picture.
  };

  /// One picture or several, with one reading of the large layers' weights. `pictures`: each size x size
  /// numbers, line by line, nominally from 0 to 1; `features`: as many rows of shape().features. Each picture
  /// gets the bits that it would get alone. No allocation. Cost: flop_count() a picture.
  void apply(std::span<const float> pictures, Workspace& workspace, std::span<float> features) const;

  [[nodiscard]] const BackboneShape& shape() const { return shape_; }
  [[nodiscard]] Precision precision() const { return features_.precision; }
  /// Of all weights as they are laid out.
  [[nodiscard]] std::size_t weight_bytes() const;

 private:
  Backbone() = default;
  void apply_first(std::span<const float> picture, std::size_t map, Workspace& workspace) const;

  BackboneShape shape_;
  PictureConvolution first_;
  std::vector<PackedConvolution> layers_;  ///< Behind the first.
  /// Of `layers_`: from this one on, all pictures go through a layer together. Before, maps are larger than
  /// weights, and one picture's at a time stay in the caches.
  std::size_t together_ = 0;
  PackedLinear features_;
};

}  // namespace mien::model
