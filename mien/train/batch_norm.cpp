#include "mien/train/batch_norm.h"

#include <ATen/Parallel.h>
#include <torch/csrc/autograd/custom_function.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace mien::train {
namespace {

using torch::autograd::AutogradContext;
using Tensors = torch::autograd::variable_list;
using Plane = Eigen::Map<const Eigen::ArrayXf>;
using PlaneOut = Eigen::Map<Eigen::ArrayXf>;

/// What is multiplied by it and held to [0, 1] is a step, 0 up to zero: unlike a comparison, that is
/// vectorised.
constexpr float kSteep = 1e38F;

/// Runs `one(channel)` for each channel, on libtorch's threads.
template <class One>
void for_each_channel(const torch::Tensor& x, const One& one) {
  at::parallel_for(0, x.size(1), 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t channel = begin; channel < end; ++channel) one(channel);
  });
}

/// [n, channels, height, width], contiguous: where each picture's plane of a channel begins.
struct Planes {
  explicit Planes(const torch::Tensor& x)
      : pictures(x.size(0)), channels(x.size(1)), pixels(x.size(2) * x.size(3)) {}
  [[nodiscard]] std::int64_t at(std::int64_t picture, std::int64_t channel) const {
    return (picture * channels + channel) * pixels;
  }
  [[nodiscard]] double values() const { return static_cast<double>(pictures * pixels); }
  std::int64_t pictures, channels, pixels;
};

class NormaliseAndRectify : public torch::autograd::Function<NormaliseAndRectify> {
 public:
  // The signatures are libtorch's to give: it looks for a static forward and backward.
  /// `mean`, `variance`: [channels], written.
  static torch::Tensor forward(AutogradContext* context, const torch::Tensor& input,
                               const torch::Tensor& shift, torch::Tensor mean, torch::Tensor variance) {
    const torch::Tensor x = input.contiguous();
    torch::Tensor scale = torch::empty_like(mean), out = torch::empty_like(x);
    const Planes planes(x);
    const auto *from = x.data_ptr<float>(), *shifts = shift.data_ptr<float>();
    auto *to = out.data_ptr<float>(), *means = mean.data_ptr<float>(),
         *variances = variance.data_ptr<float>(), *scales = scale.data_ptr<float>();
    for_each_channel(x, [&](std::int64_t c) {
      double sum = 0, squares = 0;
      for (std::int64_t n = 0; n < planes.pictures; ++n) {
        const Plane plane(from + planes.at(n, c), planes.pixels);
        sum += double{plane.sum()};
        squares += double{plane.square().sum()};
      }
      const double middle = sum / planes.values();
      const double spread = std::max(0.0, squares / planes.values() - middle * middle);
      means[c] = static_cast<float>(middle);
      variances[c] = static_cast<float>(spread);
      scales[c] = static_cast<float>(1 / std::sqrt(spread + kBatchNormEpsilon));
      const float by = scales[c], plus = shifts[c] - means[c] * by;
      for (std::int64_t n = 0; n < planes.pictures; ++n)
        PlaneOut(to + planes.at(n, c), planes.pixels) =
            (Plane(from + planes.at(n, c), planes.pixels) * by + plus).max(0.0F);
    });
    context->save_for_backward({x, shift, mean, scale});
    return out;
  }

  static Tensors backward(AutogradContext* context, Tensors gradients) {
    const Tensors saved = context->get_saved_variables();
    const torch::Tensor& x = saved[0];
    const torch::Tensor asked = gradients[0].contiguous();
    torch::Tensor of_x = torch::empty_like(x), of_shift = torch::empty_like(saved[1]);
    const Planes planes(x);
    const auto *from = x.data_ptr<float>(), *wanted = asked.data_ptr<float>(),
               *shifts = saved[1].data_ptr<float>(), *means = saved[2].data_ptr<float>(),
               *scales = saved[3].data_ptr<float>();
    auto *to = of_x.data_ptr<float>(), *to_shift = of_shift.data_ptr<float>();
    for_each_channel(x, [&](std::int64_t c) {
      const float by = scales[c], plus = shifts[c] - means[c] * by;
      double sum = 0, product = 0;  // Of what is asked behind the ReLU; that times what was read.
      for (std::int64_t n = 0; n < planes.pictures; ++n) {
        const Plane plane(from + planes.at(n, c), planes.pixels);
        PlaneOut passed(to + planes.at(n, c), planes.pixels);
        passed = Plane(wanted + planes.at(n, c), planes.pixels) *
                 ((plane * by + plus) * kSteep).max(0.0F).min(1.0F);
        sum += double{passed.sum()};
        product += double{(passed * plane).sum()};
      }
      to_shift[c] = static_cast<float>(sum);
      // By the chain rule the mean and the variance take back what would change them.
      const double middle = double{means[c]}, along = double{by} * double{by} * (product - middle * sum);
      const auto slope = static_cast<float>(along / planes.values()),
                 level = static_cast<float>((sum - middle * along) / planes.values());
      for (std::int64_t n = 0; n < planes.pictures; ++n) {
        PlaneOut write(to + planes.at(n, c), planes.pixels);
        write = by * (write - level - slope * Plane(from + planes.at(n, c), planes.pixels));
      }
    });
    return {of_x, of_shift, torch::Tensor(), torch::Tensor()};
  }
};

}  // namespace

torch::Tensor normalise_and_rectify(const torch::Tensor& x, const torch::Tensor& shift,
                                    ChannelStatistics* statistics) {
  ChannelStatistics found{torch::zeros({x.size(1)}, shift.options().requires_grad(false)),
                          torch::zeros({x.size(1)}, shift.options().requires_grad(false))};
  torch::Tensor out;
  if (x.device().is_cpu() && x.scalar_type() == torch::kFloat) {
    out = NormaliseAndRectify::apply(x, shift, found.mean, found.variance);
  } else {
    // A momentum of 1 leaves this batch's statistics alone, the variance as that of a sample.
    out = torch::relu(torch::batch_norm(x, torch::ones_like(shift), shift, found.mean, found.variance, true,
                                        1, kBatchNormEpsilon, false));
    const auto values = static_cast<double>(x.numel() / x.size(1));
    found.variance = found.variance * ((values - 1) / values);  // Going back needs the one it was given.
  }
  if (statistics != nullptr) *statistics = {found.mean.to(torch::kFloat), found.variance.to(torch::kFloat)};
  return out;
}

}  // namespace mien::train
