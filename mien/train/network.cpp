#include "mien/train/network.h"

#include <algorithm>
#include <cmath>

#include "mien/core/random.h"
#include "mien/train/batch_norm.h"
#include "mien/train/recurrent.h"

namespace mien::train {
namespace {

/// Hands out parameters one after the other, in the order in which the network uses them.
class Cursor {
 public:
  /// `statistics`: where those of each convolution go that is normalised; may be null.
  Cursor(const Parameters& parameters, const Pass& pass, std::vector<ChannelStatistics>* statistics = nullptr)
      : next_(parameters.begin()),
        pass_(pass),
        type_(pass.bf16 ? torch::kBFloat16 : torch::kFloat),
        statistics_(statistics) {}

  torch::Tensor linear(const torch::Tensor& x) {
    const torch::Tensor weight = take(), bias = take();
    return torch::linear(x.to(type_), weight, bias);
  }
  /// 3 x 3 pixels, stride 2, zeros around; a ReLU.
  torch::Tensor convolve(const torch::Tensor& x) {
    const torch::Tensor weight = take(), bias = take();
    if (!pass_.batch_norm) return torch::relu(torch::conv2d(x.to(type_), weight, bias, 2, 1));
    const torch::Tensor plain = torch::conv2d(x.to(type_), weight, {}, 2, 1);
    return normalise_and_rectify(plain, bias,
                                 statistics_ == nullptr ? nullptr : &statistics_->emplace_back());
  }
  /// A parameter that is added as it is.
  torch::Tensor plain() { return *next_++; }
  /// Query, key and value in one product, which is faster than three.
  torch::Tensor three_linears(const torch::Tensor& x) {
    std::vector<torch::Tensor> weights, biases;
    for (int i = 0; i < 3; ++i) {
      weights.push_back(take());
      biases.push_back(take());
    }
    return torch::linear(x.to(type_), torch::cat(weights), torch::cat(biases));
  }
  torch::Tensor normalise(const torch::Tensor& x) {
    const torch::Tensor gain = take(), shift = take();
    return torch::layer_norm(x, {x.size(-1)}, gain, shift, model::kLayerNormEpsilon);
  }
  /// A recurrent layer over [frames, sequences, width], fp32.
  torch::Tensor recur(const torch::Tensor& x) {
    const torch::Tensor from_input = linear(x).to(torch::kFloat);
    const torch::Tensor& weight = *next_++;
    const torch::Tensor& bias = *next_++;
    return run_recurrent(from_input, weight, bias, pass_.bf16);
  }
  [[nodiscard]] torch::Tensor drop(const torch::Tensor& x) const {
    return pass_.dropout > 0 ? torch::dropout(x, pass_.dropout, true) : x;
  }

 private:
  torch::Tensor take() { return (next_++)->to(type_); }
  Parameters::const_iterator next_;
  const Pass& pass_;
  torch::ScalarType type_;
  std::vector<ChannelStatistics>* statistics_;
};

torch::Tensor as_tensor(const std::vector<float>& values, at::IntArrayRef shape,
                        const torch::Device& device) {
  return torch::tensor(values).view(shape).to(device);
}

/// The sinusoids of whole noise levels, [windows, kNoiseSinusoid]: what model::noise_sinusoid gives for one.
torch::Tensor noise_sinusoids(const torch::Tensor& level) {
  constexpr std::int64_t kHalf = model::kNoiseSinusoid / 2;
  const auto options = torch::TensorOptions().dtype(torch::kDouble).device(level.device());
  const torch::Tensor frequency =
      torch::exp(torch::arange(kHalf, options) * (-std::log(10000.0) / (kHalf - 1)));
  const torch::Tensor angle = level.to(torch::kDouble).unsqueeze(1) * frequency;
  return torch::cat({angle.sin(), angle.cos()}, 1).to(torch::kFloat);
}

/// Adds to a query's or key's weights, [heads * d_head, d_model], what makes frames look at near ones: the
/// product of two frames' quickest position waves is largest where they meet. Later heads look more closely.
void look_near(const model::Architecture& a, std::vector<float>& weights) {
  for (std::size_t head = 0; head < a.heads; ++head)
    for (std::size_t i = 0; i < std::min(a.d_head, a.d_model); ++i)
      weights[(head * a.d_head + i) * a.d_model + i] += std::sqrt(static_cast<float>(head + 1));
}

/// Adds to the biases of the units' update gates what makes each unit begin with a memory of its own length,
/// from two frames to twenty; from zero biases on, all of them would have to learn to remember at all.
void remember(const model::Architecture& a, Random& random, std::vector<float>& biases) {
  constexpr double kLongest = 3;  // sigmoid(3) keeps 0.95 a frame.
  for (std::size_t i = a.d_model; i < 2 * a.d_model; ++i)
    biases[i] += static_cast<float>(random.uniform(0, kLongest));
}

torch::Tensor positions(std::size_t tokens, std::size_t d_model, const torch::Device& device) {
  std::vector<float> all, one(d_model);
  for (std::size_t t = 0; t < tokens; ++t) {
    model::position_encoding(t, one);
    all.insert(all.end(), one.begin(), one.end());
  }
  return as_tensor(all, {static_cast<std::int64_t>(tokens), static_cast<std::int64_t>(d_model)}, device);
}

}  // namespace

Parameters fresh_parameters(const model::Architecture& architecture, std::uint64_t seed, bool near_first,
                            const torch::Device& device) {
  const Random root(seed);
  Parameters parameters;
  std::size_t inputs = 1;
  for (const model::TensorSpec& spec : model::network_tensors(architecture)) {
    Random random = root.fork(spec.name);
    std::int64_t count = 1;
    std::vector<std::int64_t> shape;
    for (const std::size_t n : spec.shape) {
      shape.push_back(static_cast<std::int64_t>(n));
      count *= shape.back();
    }
    // A bias follows its weight.
    if (spec.shape.size() >= 2) inputs = static_cast<std::size_t>(count) / spec.shape[0];
    const bool norm = spec.name.find("_norm.") != std::string::npos;
    // Behind a ReLU as strong as before it (He et al. 2015, doi:10.1109/ICCV.2015.123), since many follow
    // each other; elsewhere as libtorch's own layers begin.
    const bool convolution = spec.name.find("convolutions.") != std::string::npos;
    const double spread = convolution
                              ? (spec.shape.size() == 4 ? std::sqrt(6.0 / static_cast<double>(inputs)) : 0)
                              : 1 / std::sqrt(static_cast<double>(inputs));
    std::vector<float> values(static_cast<std::size_t>(count), spec.name.ends_with("weight") ? 1.0F : 0.0F);
    if (!norm)
      for (float& v : values) v = static_cast<float>(random.uniform(-spread, spread));
    if (architecture.kind == model::NetworkKind::causal && spec.name.ends_with("state.bias"))
      remember(architecture, random, values);
    if (near_first && (spec.name.ends_with("query.weight") || spec.name.ends_with("key.weight")))
      look_near(architecture, values);
    parameters.push_back(as_tensor(values, shape, device).requires_grad_());
  }
  return parameters;
}

std::vector<model::Tensor> to_tensors(const model::Architecture& architecture, const Parameters& parameters) {
  std::vector<model::Tensor> tensors;
  auto parameter = parameters.begin();
  for (const model::TensorSpec& spec : model::network_tensors(architecture)) {
    const torch::Tensor plain = (parameter++)->detach().to(torch::kCPU, torch::kFloat).contiguous();
    const auto* data = plain.data_ptr<float>();
    tensors.push_back({.name = spec.name, .shape = spec.shape, .values = {data, data + plain.numel()}});
  }
  return tensors;
}

Parameters from_tensors(const std::vector<model::Tensor>& tensors, const torch::Device& device) {
  Parameters parameters;
  for (const model::Tensor& tensor : tensors)
    parameters.push_back(as_tensor(
        tensor.values, std::vector<std::int64_t>(tensor.shape.begin(), tensor.shape.end()), device));
  return parameters;
}

namespace {

torch::Tensor run_views(const model::Architecture& a, const torch::Tensor& condition, Cursor use) {
  constexpr auto kCameras = static_cast<std::int64_t>(model::kViews);
  const auto side = static_cast<std::int64_t>(a.side), wearers = condition.size(0), each = condition.size(1),
             moments = wearers * each;
  const torch::Tensor all = condition.view({moments, -1});
  const torch::Tensor views = all.narrow(1, 0, kCameras * side * side).view({moments, kCameras, side, side});
  const torch::Tensor present = all.narrow(1, kCameras * side * side, kCameras).unsqueeze(2);
  std::vector<torch::Tensor> found;
  for (const std::int64_t first : {0, 2}) {  // Eyes, then mouths: two views through one backbone.
    torch::Tensor x = views.narrow(1, first, 2).reshape({2 * moments, 1, side, side});
    for (std::size_t layer = 0; layer < a.layers; ++layer) x = use.convolve(x);
    found.push_back(use.linear(x.flatten(1)).to(torch::kFloat).view({moments, 2, -1}));
  }
  const torch::Tensor seen = torch::cat(found, 1);
  const torch::Tensor features = present * seen + (1 - present) * use.plain().unsqueeze(0);
  // Against the first moment, where both views are there and it is known.
  const torch::Tensor of_wearers = features.view({wearers, each, kCameras, -1});
  const torch::Tensor there = present.view({wearers, each, kCameras, 1}),
                      known = all.narrow(1, kCameras * (side * side + 1), 1).view({wearers, each, 1, 1});
  const torch::Tensor differences =
      known * there * there.narrow(1, 0, 1) * (of_wearers - of_wearers.narrow(1, 0, 1));
  const torch::Tensor read = torch::cat({features.flatten(1), differences.view({moments, -1})}, 1);
  const torch::Tensor hidden = torch::relu(use.linear(use.drop(read)));
  return use.linear(hidden).to(torch::kFloat).view({wearers, each, -1});
}

}  // namespace

Parameters fold_batch_norm(const model::Architecture& architecture, const Parameters& parameters,
                           const torch::Tensor& condition) {
  const at::NoGradGuard no_gradients;
  std::vector<ChannelStatistics> statistics;
  const Pass pass{.batch_norm = true};
  run_views(architecture, condition, Cursor(parameters, pass, &statistics));
  Parameters folded = parameters;
  auto found = statistics.begin();
  const std::vector<model::TensorSpec> specs = model::network_tensors(architecture);
  for (std::size_t i = 0; i + 1 < specs.size(); ++i) {
    if (specs[i].shape.size() != 4) continue;  // A convolution's weight; its bias follows.
    const torch::Tensor scale = (found->variance + kBatchNormEpsilon).rsqrt();
    folded[i] = parameters[i] * scale.view({-1, 1, 1, 1});
    folded[i + 1] = parameters[i + 1] - found->mean * scale;
    ++found;
  }
  return folded;
}

torch::Tensor predict_at_once(const model::Architecture& a, const Parameters& parameters,
                              const torch::Tensor& condition, const Pass& pass) {
  Cursor use(parameters, pass);
  if (a.kind == model::NetworkKind::views) return run_views(a, condition, use);
  torch::Tensor x = torch::relu(use.linear(condition.transpose(0, 1).contiguous())).to(torch::kFloat);
  for (std::size_t layer = 0; layer < a.layers; ++layer) x = x + use.recur(use.drop(x));
  return use.linear(x).to(torch::kFloat).transpose(0, 1);
}

torch::Tensor predict(const model::Architecture& a, const Parameters& parameters, const torch::Tensor& noisy,
                      const torch::Tensor& condition, const torch::Tensor& level, const Pass& pass) {
  const std::int64_t windows = noisy.size(0), tokens = noisy.size(1) + 1;
  const auto heads = static_cast<std::int64_t>(a.heads), d_head = static_cast<std::int64_t>(a.d_head);
  Cursor use(parameters, pass);

  const torch::Tensor frames = use.linear(torch::cat({noisy, condition}, 2));
  const torch::Tensor hidden = torch::gelu(use.linear(noise_sinusoids(level)));
  const torch::Tensor noise = use.linear(hidden).unsqueeze(1);
  torch::Tensor x = torch::cat({noise, frames}, 1);
  x = x + positions(static_cast<std::size_t>(tokens), a.d_model, noisy.device()).to(x.scalar_type());
  for (std::size_t layer = 0; layer < a.layers; ++layer) {
    const torch::Tensor projected =
        use.three_linears(x).view({windows, tokens, 3, heads, d_head}).permute({2, 0, 3, 1, 4});
    const torch::Tensor query = projected[0] * (1 / std::sqrt(static_cast<double>(d_head)));
    const torch::Tensor share =
        use.drop(torch::softmax(torch::matmul(query, projected[1].transpose(2, 3)), -1));
    const torch::Tensor mixed =
        torch::matmul(share, projected[2]).transpose(1, 2).reshape({windows, tokens, heads * d_head});
    x = use.normalise(use.drop(use.linear(mixed)) + x);
    const torch::Tensor inner = torch::relu(use.linear(x));
    x = use.normalise(use.drop(use.linear(inner)) + x);
  }
  return use.linear(x.slice(1, 1)).to(torch::kFloat);
}

}  // namespace mien::train
