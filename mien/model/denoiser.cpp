#include "mien/model/denoiser.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

namespace mien::model {
namespace {

AlignedFloats aligned(std::span<const float> values) {
  AlignedFloats copy(values.size());
  std::copy(values.begin(), values.end(), copy.data());
  return copy;
}

/// The exact one, x Phi(x), not its tanh approximation.
double gelu(double x) {
  return 0.5 * x * (1 + std::erf(x / std::numbers::sqrt2));
}

std::vector<float> transposed(std::span<const float> matrix, std::size_t rows) {
  const std::size_t columns = matrix.size() / rows;
  std::vector<float> out(matrix.size());
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t c = 0; c < columns; ++c) out[c * rows + r] = matrix[r * columns + c];
  return out;
}

/// out = bias + x matrix, for a matrix [x.size(), out.size()].
void multiply_vector(std::span<const double> x, std::span<const float> matrix, std::span<const float> bias,
                     std::span<double> out) {
  std::ranges::copy(bias, out.begin());
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t j = 0; j < out.size(); ++j) out[j] += double{matrix[i * out.size() + j]} * x[i];
}

}  // namespace

Result<Denoiser> Denoiser::create(const Architecture& a, std::span<const Tensor> network,
                                  Precision precision) {
  MIEN_TRY(check(a));
  if (a.kind != NetworkKind::window)
    return fail(ErrorCode::mismatch, "this is a causal network, not a window network", "model file",
                "use --live with it, or a model such as models/default.safetensors");
  MIEN_TRY(check_tensors(a, network));

  // The tensors come in network_tensors' order, so they are taken one after the other.
  auto next = network.begin();
  const auto take = [&]() -> const std::vector<float>& { return (next++)->values; };
  const auto linear = [&](std::size_t out, std::size_t in) {
    const auto& weight = take();
    return pack_linear(weight, take(), out, in, 0, in, precision);
  };

  Denoiser d;
  d.architecture_ = a;
  const auto& input_weight = take();
  d.noisy_input_ = pack_linear(input_weight, {}, a.d_model, a.input(), 0, a.outputs, precision);
  d.condition_input_ =
      pack_linear(input_weight, take(), a.d_model, a.input(), a.outputs, a.condition, precision);
  d.noise_hidden_weight_ = transposed(take(), kNoiseHidden);
  d.noise_hidden_bias_ = take();
  d.noise_out_weight_ = transposed(take(), a.d_model);
  d.noise_out_bias_ = take();
  for (std::size_t i = 0; i < a.layers; ++i) {
    Layer& layer = d.layers_.emplace_back();
    layer.query = linear(a.d_attention(), a.d_model);
    std::vector<float> weight = take(), bias = take();
    const auto& value_weight = take();
    const auto& value_bias = take();
    weight.insert(weight.end(), value_weight.begin(), value_weight.end());
    bias.insert(bias.end(), value_bias.begin(), value_bias.end());
    layer.keys_values = pack_linear(weight, bias, 2 * a.d_attention(), a.d_model, 0, a.d_model, precision);
    layer.attended = linear(a.d_model, a.d_attention());
    layer.attention_gain = aligned(take());
    layer.attention_shift = aligned(take());
    layer.ffn_hidden = linear(a.ffn, a.d_model);
    layer.ffn_out = linear(a.d_model, a.ffn);
    layer.ffn_gain = aligned(take());
    layer.ffn_shift = aligned(take());
  }
  d.output_ = linear(a.outputs, a.d_model);

  d.positions_ = AlignedFloats(a.tokens() * row_stride(a.d_model));
  std::vector<float> position(a.d_model);
  for (std::size_t token = 0; token < a.tokens(); ++token) {
    position_encoding(token, position);
    std::ranges::copy(position, d.positions_.data() + token * row_stride(a.d_model));
  }
  return d;
}

Denoiser::Workspace::Workspace(const Denoiser& denoiser) {
  const Architecture& a = denoiser.architecture_;
  const std::size_t tokens = a.tokens();
  conditioned_ = AlignedFloats(a.window * row_stride(a.d_model));
  tokens_ = AlignedFloats(tokens * row_stride(a.d_model));
  queries_ = AlignedFloats(tokens * row_stride(a.d_attention()));
  keys_values_ = AlignedFloats(tokens * row_stride(2 * a.d_attention()));
  head_keys_ = AlignedFloats(a.d_head * row_stride(tokens));
  scores_ = AlignedFloats(tokens * row_stride(tokens));
  attended_ = AlignedFloats(tokens * row_stride(a.d_attention()));
  hidden_ = AlignedFloats(tokens * row_stride(a.ffn));
  answer_ = AlignedFloats(a.window * row_stride(a.outputs));
  noise_ = Aligned<double>(a.d_model);
  converted_ = ConvertedRows(tokens, std::max({a.input(), a.d_model, a.d_attention(), a.ffn}));
}

void Denoiser::set_condition(std::span<const float> condition, Workspace& w) const {
  const Architecture& a = architecture_;
  const std::size_t stride = row_stride(a.d_model);
  w.frames_ = condition.size() / a.condition;
  assert(w.frames_ >= 1 && w.frames_ <= a.window && condition.size() == w.frames_ * a.condition);
  // The first frame is token 1, behind the noise token.
  apply_linear(condition_input_, w.frames_, {condition.data(), a.condition}, {w.conditioned_.data(), stride},
               {.add = {positions_.data() + stride, stride}}, w.converted_);
}

void Denoiser::write_noise_token(std::size_t level, Workspace& w) const {
  const std::array<float, kNoiseSinusoid> sinusoid = noise_sinusoid(level);
  std::array<double, kNoiseSinusoid> wide{};
  std::ranges::copy(sinusoid, wide.begin());
  std::array<double, kNoiseHidden> hidden{};
  multiply_vector(wide, noise_hidden_weight_, noise_hidden_bias_, hidden);
  std::ranges::transform(hidden, hidden.begin(), gelu);
  const std::span<double> out(w.noise_.data(), architecture_.d_model);
  multiply_vector(hidden, noise_out_weight_, noise_out_bias_, out);
  for (std::size_t j = 0; j < out.size(); ++j) w.tokens_[j] = static_cast<float>(out[j]) + positions_[j];
}

void Denoiser::attend(const Layer& layer, std::size_t first, Workspace& w) const {
  const Architecture& a = architecture_;
  const std::size_t tokens = w.frames_ + 1, rows = tokens - first, width = a.d_attention();
  const std::size_t stride = row_stride(width), kv_stride = row_stride(2 * width);
  const std::size_t token_stride = row_stride(a.d_model), score_stride = row_stride(a.tokens());
  apply_linear(layer.keys_values, tokens, {w.tokens_.data(), token_stride},
               {w.keys_values_.data(), kv_stride}, {}, w.converted_);
  apply_linear(layer.query, rows, {w.tokens_.data() + first * token_stride, token_stride},
               {w.queries_.data(), stride}, {}, w.converted_);
  const float scale = 1 / std::sqrt(static_cast<float>(a.d_head));
  for (std::size_t head = 0; head < a.heads; ++head) {
    const float* key = w.keys_values_.data() + head * a.d_head;
    for (std::size_t t = 0; t < tokens; ++t)
      for (std::size_t i = 0; i < a.d_head; ++i) w.head_keys_[i * score_stride + t] = key[t * kv_stride + i];
    multiply(rows, a.d_head, tokens, {w.queries_.data() + head * a.d_head, stride},
             {w.head_keys_.data(), score_stride}, {w.scores_.data(), score_stride});
    softmax_rows(rows, tokens, scale, w.scores_.data(), score_stride);
    multiply(rows, tokens, a.d_head, {w.scores_.data(), score_stride}, {key + width, kv_stride},
             {w.attended_.data() + head * a.d_head, stride});
  }
}

void Denoiser::run(const Layer& layer, std::size_t first, Workspace& w) const {
  const Architecture& a = architecture_;
  const std::size_t rows = w.frames_ + 1 - first, stride = row_stride(a.d_model), ffn = row_stride(a.ffn);
  float* tokens = w.tokens_.data() + first * stride;
  attend(layer, first, w);
  apply_linear(layer.attended, rows, {w.attended_.data(), row_stride(a.d_attention())}, {tokens, stride},
               {.add = {tokens, stride}}, w.converted_);
  normalise_rows(rows, a.d_model, layer.attention_gain.data(), layer.attention_shift.data(), tokens, stride);
  apply_linear(layer.ffn_hidden, rows, {tokens, stride}, {w.hidden_.data(), ffn}, {.relu = true},
               w.converted_);
  apply_linear(layer.ffn_out, rows, {w.hidden_.data(), ffn}, {tokens, stride}, {.add = {tokens, stride}},
               w.converted_);
  normalise_rows(rows, a.d_model, layer.ffn_gain.data(), layer.ffn_shift.data(), tokens, stride);
}

void Denoiser::predict(std::span<const float> noisy, std::size_t level, std::span<float> clean,
                       Workspace& w) const {
  const Architecture& a = architecture_;
  const std::size_t rows = w.frames_, stride = row_stride(a.d_model), answers = row_stride(a.outputs);
  assert(rows >= 1 && noisy.size() == rows * a.outputs && clean.size() == rows * a.outputs);
  write_noise_token(level, w);
  apply_linear(noisy_input_, rows, {noisy.data(), a.outputs}, {w.tokens_.data() + stride, stride},
               {.add = {w.conditioned_.data(), stride}}, w.converted_);
  // Nobody asks what the last layer makes of the noise token.
  for (const Layer& layer : layers_) run(layer, &layer == &layers_.back() ? 1 : 0, w);
  apply_linear(output_, rows, {w.tokens_.data() + stride, stride}, {w.answer_.data(), answers}, {},
               w.converted_);
  for (std::size_t r = 0; r < rows; ++r)
    std::copy_n(w.answer_.data() + r * answers, a.outputs, clean.data() + r * a.outputs);
}

}  // namespace mien::model
