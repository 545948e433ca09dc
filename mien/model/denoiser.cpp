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

}  // namespace

Result<Denoiser> Denoiser::create(const Architecture& a, std::span<const Tensor> network) {
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
    return pack_linear(weight, take(), out, in, 0, in);
  };

  Denoiser d;
  d.architecture_ = a;
  const auto& input_weight = take();
  d.noisy_input_ = pack_linear(input_weight, {}, a.d_model, a.input(), 0, a.outputs);
  d.condition_input_ = pack_linear(input_weight, take(), a.d_model, a.input(), a.outputs, a.condition);
  d.noise_hidden_weight_ = take();
  d.noise_hidden_bias_ = take();
  d.noise_out_weight_ = take();
  d.noise_out_bias_ = take();
  for (std::size_t i = 0; i < a.layers; ++i) {
    Layer& layer = d.layers_.emplace_back();
    std::vector<float> weight, bias;
    for (int part = 0; part < 3; ++part) {
      const auto& w = take();
      const auto& b = take();
      weight.insert(weight.end(), w.begin(), w.end());
      bias.insert(bias.end(), b.begin(), b.end());
    }
    layer.projection = pack_linear(weight, bias, 3 * a.d_attention(), a.d_model, 0, a.d_model);
    layer.attended = linear(a.d_model, a.d_attention());
    layer.attention_gain = aligned(take());
    layer.attention_shift = aligned(take());
    layer.ffn_hidden = linear(a.ffn, a.d_model);
    layer.ffn_out = linear(a.d_model, a.ffn);
    layer.ffn_gain = aligned(take());
    layer.ffn_shift = aligned(take());
  }
  d.output_ = linear(a.outputs, a.d_model);

  d.positions_ = AlignedFloats(a.tokens() * a.d_model);
  std::vector<float> position(a.d_model);
  for (std::size_t token = 0; token < a.tokens(); ++token) {
    position_encoding(token, position);
    std::copy(position.begin(), position.end(), d.positions_.data() + token * a.d_model);
  }
  return d;
}

Denoiser::Workspace::Workspace(const Denoiser& denoiser) {
  const Architecture& a = denoiser.architecture_;
  const std::size_t tokens = a.tokens();
  conditioned_ = AlignedFloats(a.window * a.d_model);
  tokens_ = AlignedFloats(tokens * a.d_model);
  projected_ = AlignedFloats(tokens * 3 * a.d_attention());
  keys_ = AlignedFloats(a.d_head * padded(tokens));
  scores_ = AlignedFloats(tokens * padded(tokens));
  attended_ = AlignedFloats(tokens * a.d_attention());
  hidden_ = AlignedFloats(tokens * a.ffn);
  answer_ = AlignedFloats(a.window * padded(a.outputs));
}

void Denoiser::set_condition(std::span<const float> condition, Workspace& w) const {
  const Architecture& a = architecture_;
  w.frames_ = condition.size() / a.condition;
  assert(w.frames_ >= 1 && w.frames_ <= a.window && condition.size() == w.frames_ * a.condition);
  // The first frame is token 1, behind the noise token.
  apply_linear(condition_input_, w.frames_, condition.data(), a.condition, positions_.data() + a.d_model,
               a.d_model, Activation::none, w.conditioned_.data(), a.d_model);
}

void Denoiser::write_noise_token(std::size_t level, float* token) const {
  const std::array<float, kNoiseSinusoid> sinusoid = noise_sinusoid(level);
  std::array<double, kNoiseHidden> hidden;
  for (std::size_t h = 0; h < kNoiseHidden; ++h) {
    double sum = noise_hidden_bias_[h];
    for (std::size_t i = 0; i < kNoiseSinusoid; ++i)
      sum += double{noise_hidden_weight_[h * kNoiseSinusoid + i]} * double{sinusoid[i]};
    hidden[h] = gelu(sum);
  }
  for (std::size_t j = 0; j < architecture_.d_model; ++j) {
    double sum = noise_out_bias_[j];
    for (std::size_t h = 0; h < kNoiseHidden; ++h)
      sum += double{noise_out_weight_[j * kNoiseHidden + h]} * hidden[h];
    token[j] = static_cast<float>(sum) + positions_[j];
  }
}

void Denoiser::attend(const Layer& layer, Workspace& w) const {
  const Architecture& a = architecture_;
  const std::size_t tokens = w.frames_ + 1, width = a.d_attention(), stride = 3 * width;
  const std::size_t score_stride = padded(a.tokens());
  apply_linear(layer.projection, tokens, w.tokens_.data(), a.d_model, nullptr, 0, Activation::none,
               w.projected_.data(), stride);
  const float scale = 1 / std::sqrt(static_cast<float>(a.d_head));
  for (std::size_t head = 0; head < a.heads; ++head) {
    const float* query = w.projected_.data() + head * a.d_head;
    const float* key = query + width;
    const float* value = key + width;
    for (std::size_t t = 0; t < tokens; ++t)
      for (std::size_t i = 0; i < a.d_head; ++i) w.keys_[i * score_stride + t] = key[t * stride + i];
    multiply(tokens, a.d_head, tokens, query, stride, w.keys_.data(), score_stride, w.scores_.data(),
             score_stride);
    softmax_rows(tokens, tokens, scale, w.scores_.data(), score_stride);
    multiply(tokens, tokens, a.d_head, w.scores_.data(), score_stride, value, stride,
             w.attended_.data() + head * a.d_head, width);
  }
}

void Denoiser::predict(std::span<const float> noisy, std::size_t level, std::span<float> clean,
                       Workspace& w) const {
  const Architecture& a = architecture_;
  assert(w.frames_ >= 1 && noisy.size() == w.frames_ * a.outputs && clean.size() == noisy.size());
  const std::size_t tokens = w.frames_ + 1;
  write_noise_token(level, w.tokens_.data());
  apply_linear(noisy_input_, w.frames_, noisy.data(), a.outputs, w.conditioned_.data(), a.d_model,
               Activation::none, w.tokens_.data() + a.d_model, a.d_model);
  for (const Layer& layer : layers_) {
    attend(layer, w);
    apply_linear(layer.attended, tokens, w.attended_.data(), a.d_attention(), w.tokens_.data(), a.d_model,
                 Activation::none, w.tokens_.data(), a.d_model);
    normalise_rows(tokens, a.d_model, layer.attention_gain.data(), layer.attention_shift.data(),
                   w.tokens_.data(), a.d_model);
    apply_linear(layer.ffn_hidden, tokens, w.tokens_.data(), a.d_model, nullptr, 0, Activation::relu,
                 w.hidden_.data(), a.ffn);
    apply_linear(layer.ffn_out, tokens, w.hidden_.data(), a.ffn, w.tokens_.data(), a.d_model,
                 Activation::none, w.tokens_.data(), a.d_model);
    normalise_rows(tokens, a.d_model, layer.ffn_gain.data(), layer.ffn_shift.data(), w.tokens_.data(),
                   a.d_model);
  }
  apply_linear(output_, w.frames_, w.tokens_.data() + a.d_model, a.d_model, nullptr, 0, Activation::none,
               w.answer_.data(), padded(a.outputs));
  for (std::size_t f = 0; f < w.frames_; ++f)
    std::copy_n(w.answer_.data() + f * padded(a.outputs), a.outputs, clean.data() + f * a.outputs);
}

}  // namespace mien::model
