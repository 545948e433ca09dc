#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "mien/model/aligned.h"
#include "mien/model/linear.h"
#include "mien/model/precision.h"

/// Convolutions of 3 x 3 pixels with a pixel of zeros around, a bias (which a batch norm folds into) and a
/// ReLU: rows of the linear layers' products, in their precisions, without a copy of the inputs where maps
/// are wide. A call allocates nothing, runs on one thread, and gives the same bits each time on one build and
/// CPU family, for a map among others as for the map alone.
namespace mien::model {

struct MapSize {
  std::size_t height = 0, width = 0, channels = 0;
  bool operator==(const MapSize&) const = default;
};

/// What a convolution makes of a map of that size; `stride` at least 1.
[[nodiscard]] constexpr MapSize convolved(const MapSize& in, std::size_t stride, std::size_t channels) {
  return {(in.height - 1) / stride + 1, (in.width - 1) / stride + 1, channels};
}

/// Maps of one size, of numbers that are not negative: line after line, pixel after pixel, a pixel's channels
/// side by side. Zeros fill each pixel up to whole channel steps and stand around each map, a pixel wide.
/// fp32 and bf16 are numbers; int8's are bytes from 0 to 127, each counting its map's scale.
class FeatureMaps {
 public:
  FeatureMaps() = default;
  /// `channel_step`: kPanel, or 16 for what convolve_picture() makes.
  FeatureMaps(const MapSize& size, std::size_t channel_step, std::size_t count, Precision precision);

  [[nodiscard]] const MapSize& size() const { return size_; }
  [[nodiscard]] Precision precision() const { return precision_; }
  /// Numbers of a pixel, with those that fill it up.
  [[nodiscard]] std::size_t pixel() const { return pixel_; }
  [[nodiscard]] std::size_t pixel_bytes() const {
    return pixel_ * sizeof(float) / numbers_in_word(precision_);
  }
  [[nodiscard]] std::size_t line_bytes() const { return (size_.width + 2) * pixel_bytes(); }
  [[nodiscard]] std::size_t map_bytes() const { return (size_.height + 2) * line_bytes(); }
  /// Where a pixel stands; lines and pixels count from the zeros before the first.
  [[nodiscard]] std::byte* at(std::size_t map, std::size_t line, std::size_t pixel) {
    return numbers_.data() + map * map_bytes() + line * line_bytes() + pixel * pixel_bytes();
  }
  [[nodiscard]] const std::byte* at(std::size_t map, std::size_t line, std::size_t pixel) const {
    return numbers_.data() + map * map_bytes() + line * line_bytes() + pixel * pixel_bytes();
  }
  /// int8: what a byte of each map counts.
  [[nodiscard]] float* scales() { return scales_.data(); }
  [[nodiscard]] const float* scales() const { return scales_.data(); }

 private:
  MapSize size_;
  Precision precision_ = Precision::fp32;
  std::size_t pixel_ = 0;
  Aligned<std::byte> numbers_;
  AlignedFloats scales_;
};

/// Two lines of a convolution of stride 2 at once, by five products instead of six. Of a window's lines of
/// weights u, v, w and the five lines a to e that both read, the upper one is u a + v b + w c, the lower one
/// u c + v d + w e, and so
///   upper = (u + w) c + u (a - c) + v b,  lower = (u + w) c + v d - w (c - e).
/// Source: Winograd, Arithmetic Complexity of Computations (1980): F(2, 2).
struct PairedLines {
  PackedLinear shared;  ///< u + w, and the bias.
  PackedLinear upper;   ///< u and v.
  PackedLinear lower;   ///< v and -w.
};

/// A convolution whose inputs are maps.
struct PackedConvolution {
  std::size_t stride = 2;
  std::size_t in_pixel = 0;          ///< Of the maps that it reads.
  PackedLinear product;              ///< Of rows of three lines of three pixels.
  std::optional<PairedLines> pairs;  ///< In fp32, where these weights stay in the second cache.
};

/// `weight`: [out, in, 3, 3] as libtorch has it; `bias`: out numbers. `in_pixel`: of the maps that it will
/// read.
[[nodiscard]] PackedConvolution pack_convolution(std::span<const float> weight, std::span<const float> bias,
                                                 std::size_t out, std::size_t in, std::size_t in_pixel,
                                                 std::size_t stride, Precision precision);

/// A convolution of one channel of fp32 numbers, into maps of any precision; its channel step is 16.
struct PictureConvolution {
  std::size_t stride = 2, out = 0;
  AlignedFloats weight;  ///< 9 rows of the padded channels.
  AlignedFloats bias;
};

/// `weight`: [out, 1, 3, 3].
[[nodiscard]] PictureConvolution pack_picture_convolution(std::span<const float> weight,
                                                          std::span<const float> bias, std::size_t out,
                                                          std::size_t stride);

/// Memory of calls that make up to `count` maps of at most these sizes; for one thread.
class ConvolutionMemory {
 public:
  ConvolutionMemory() = default;
  /// Makes room for a convolution from maps into others.
  void reserve(const FeatureMaps& in, const FeatureMaps& out, std::size_t count);
  /// For one of a picture.
  void reserve(const FeatureMaps& out);

 private:
  friend void convolve(const PackedConvolution&, const FeatureMaps&, std::size_t, FeatureMaps&, std::size_t,
                       std::size_t, ConvolutionMemory&);
  friend void convolve_picture(const PictureConvolution&, const float*, std::size_t, FeatureMaps&,
                               std::size_t, ConvolutionMemory&);
  void convolve_paired(const PairedLines& pairs, const FeatureMaps& in, std::size_t map, std::size_t y,
                       RowsOut to, std::size_t width);

  AlignedFloats differences_;  ///< A line of inputs less another,
  AlignedFloats shared_;       ///< and what two lines of answers share.
  AlignedFloats answers_;      ///< A map before it is put into its precision.
  AlignedFloats row_scales_;   ///< int8: of each row.
  Aligned<std::byte> rows_;    ///< Gathered inputs
  AlignedFloats row_answers_;  ///< and what comes of them.
};

/// Makes maps [first_out, first_out + count) of `out` of maps [first_in, first_in + count) of `in`.
void convolve(const PackedConvolution& layer, const FeatureMaps& in, std::size_t first_in, FeatureMaps& out,
              std::size_t first_out, std::size_t count, ConvolutionMemory& memory);

/// Makes a map of a picture, which has zeros around it, a pixel wide, in lines of `line` numbers; it stands
/// at the first of the zeros.
void convolve_picture(const PictureConvolution& layer, const float* picture, std::size_t line,
                      FeatureMaps& out, std::size_t map, ConvolutionMemory& memory);

}  // namespace mien::model
