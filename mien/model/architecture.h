#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/model/safetensors.h"

namespace mien::model {

/// What a network is, which decides how it is run.
enum class NetworkKind {
  /// The denoiser: a post-LN transformer over one window of frames, the noise level as a token before them.
  /// Source of the structure: EgoEgo (Li et al. 2023, arXiv:2212.04636), which CAPUS follows.
  /// model::Denoiser.
  window,
  /// A recurrent network that answers each frame when it comes: gated recurrent units (Cho et al. 2014), each
  /// layer added to what it reads. model::CausalNetwork.
  causal,
  /// Pictures of several cameras at one moment: a backbone for eyes and one for mouths, and a hidden layer of
  /// what they find and how that differs from the wearer's face at rest. model::ViewsNetwork.
  views,
};

/// Cameras that a network of pictures has places for, in their order: left eye, right eye, left half of the
/// mouth, right half. Views of the right side are mirrored, so that both sides look alike.
inline constexpr std::size_t kViews = 4;

/// The size of a network. docs/method/window_model.md and docs/method/live_model.md draw both kinds.
struct Architecture {
  std::string name;  ///< "faithful", "light", "causal", or a recipe's own word.
  NetworkKind kind = NetworkKind::window;
  std::size_t layers = 4;     ///< 1 to 32.
  std::size_t d_model = 256;  ///< Width of a token, or of a layer's state; a multiple of 32.
  std::size_t heads = 4;      ///< Attention heads. This and the two below: 0 in a causal network.
  std::size_t d_head = 64;    ///< Width of one head; a multiple of 32. heads * d_head need not be d_model.
  std::size_t ffn = 1024;     ///< Hidden width of the feed-forward block; a multiple of 32.
  /// Frames that one call sees at most; causal: of a sequence in training; pictures: moments of one wearer
  /// that are trained together, the first at rest.
  std::size_t window = 120;
  std::size_t condition = 0;  ///< Numbers of condition a frame: FeatureLayout::width().
  std::size_t outputs = 53;   ///< Shapes.
  // Of a network of pictures; 0 and empty in others. Its layers are the convolutions, d_model the hidden
  // layer.
  std::size_t side = 0;             ///< Pixels of a view either way.
  std::size_t features = 0;         ///< Numbers that a backbone finds in a view.
  std::vector<std::size_t> widths;  ///< Channels of its convolutions.

  [[nodiscard]] std::size_t input() const { return outputs + condition; }
  [[nodiscard]] std::size_t tokens() const { return window + 1; }
  [[nodiscard]] std::size_t d_attention() const { return heads * d_head; }
  bool operator==(const Architecture&) const = default;
};

/// Width of the sinusoid that tells the noise level, and of the hidden layer behind it (EgoEgo's 64 and 4 x
/// 64).
inline constexpr std::size_t kNoiseSinusoid = 64;
inline constexpr std::size_t kNoiseHidden = 256;
/// Parts of a recurrent unit, each d_model wide: reset, update, new.
inline constexpr std::size_t kGates = 3;
/// Added to the variance in every layer normalisation.
inline constexpr double kLayerNormEpsilon = 1e-5;

/// "faithful": EgoEgo's 4 layers of 512, 4 heads of 256, feed-forward 512, to be used without presence flags.
/// "light": 4 layers of 256, 4 heads of 64, feed-forward 1024: a quarter of the work.
/// "causal": 2 recurrent layers of 256.
/// "views": views of 96 pixels, convolutions of 16, 32, 64, 96 and 128 channels, 96 features, a hidden layer
/// of 256; `condition` is what it says. `condition` is the layout's width. Errors: not_found.
[[nodiscard]] Result<Architecture> named_architecture(std::string_view name, std::size_t condition);

/// Errors: out_of_range, when a number is outside what its comment says. Everything below expects a checked
/// one.
[[nodiscard]] Result<void> check(const Architecture& architecture);

/// Name and shape of one tensor of weights; matrices are [out, in], row-major.
struct TensorSpec {
  std::string name;
  std::vector<std::size_t> shape;
  bool operator==(const TensorSpec&) const = default;
};

/// Numbers that a network of pictures reads a moment: the views' pixels one after the other, 0 to 1, then of
/// each whether it is there, 0 or 1, and whether the wearer's face at rest is known, 0 or 1.
[[nodiscard]] constexpr std::size_t views_condition(std::size_t side) {
  return kViews * (side * side + 1) + 1;
}

/// Every tensor of the network, in one fixed order. Training writes exactly these and the run time reads
/// them.
[[nodiscard]] std::vector<TensorSpec> network_tensors(const Architecture& architecture);

/// Whether these are exactly a network's tensors, in order and of the right sizes. Errors: mismatch, which
/// says what stands where another belongs.
[[nodiscard]] Result<void> check_tensors(const Architecture& architecture, std::span<const Tensor> network);
/// The same of any network whose tensors these are.
[[nodiscard]] Result<void> check_tensors(std::span<const TensorSpec> specs, std::span<const Tensor> network);

[[nodiscard]] std::size_t parameter_count(const Architecture& architecture);

/// Floating point operations of one call, on a full window or on a causal network's one frame; a
/// multiplication and its addition count as two.
[[nodiscard]] double flop_count(const Architecture& architecture);

/// The fixed sinusoid added to token `position` (0 is the noise token): out[j] = sin or cos of
/// (position + 1) / 10000^(2 floor(j/2) / size).
void position_encoding(std::size_t position, std::vector<float>& out);

/// The sinusoid of a noise level (0 to 999) of kNoiseSinusoid numbers: sines, then cosines, of
/// level * 10000^(-i/31).
[[nodiscard]] std::array<float, kNoiseSinusoid> noise_sinusoid(std::size_t level);

}  // namespace mien::model
