#include "mien/train/recurrent.h"

#include <gtest/gtest.h>
#include <torch/csrc/autograd/autograd.h>

namespace mien::train::recurrent_test {
namespace {

/// The same layer an operation at a time, with libtorch's own gradients.
torch::Tensor plainly(const torch::Tensor& from_input, const torch::Tensor& weight,
                      const torch::Tensor& bias) {
  torch::Tensor state = torch::zeros({from_input.size(1), weight.size(1)}, from_input.options());
  std::vector<torch::Tensor> states;
  for (std::int64_t t = 0; t < from_input.size(0); ++t) {
    const auto input = from_input[t].chunk(3, 1), carried = torch::linear(state, weight, bias).chunk(3, 1);
    const torch::Tensor reset = torch::sigmoid(input[0] + carried[0]);
    const torch::Tensor update = torch::sigmoid(input[1] + carried[1]);
    const torch::Tensor fresh = torch::tanh(input[2] + reset * carried[2]);
    state = (1 - update) * fresh + update * state;
    states.push_back(state);
  }
  return torch::stack(states);
}

class Recurrent : public testing::Test {
 protected:
  void SetUp() override { torch::manual_seed(7); }
  static torch::Tensor random(at::IntArrayRef shape, double size) {
    return (torch::randn(shape) * size).requires_grad_();
  }
  torch::Tensor from_input_ = random({25, 4, 3 * 32}, 1), weight_ = random({3 * 32, 32}, 0.3),
                bias_ = random({3 * 32}, 0.3);
  torch::Tensor wanted_ = torch::randn({25, 4, 32});
};

TEST_F(Recurrent, GivesTheStatesOfTheLayer) {
  const torch::Tensor states = run_recurrent(from_input_, weight_, bias_, false);
  EXPECT_TRUE(torch::allclose(states, plainly(from_input_, weight_, bias_), 1e-5, 1e-6));
}

TEST_F(Recurrent, ItsGradientsAreLibtorchs) {
  const auto gradients = [&](const torch::Tensor& states) {
    const torch::Tensor error = (states - wanted_).square().sum();
    return torch::autograd::grad({error}, {from_input_, weight_, bias_});
  };
  const auto expected = gradients(plainly(from_input_, weight_, bias_));
  const auto exact = gradients(run_recurrent(from_input_, weight_, bias_, false));
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_TRUE(torch::allclose(exact[i], expected[i], 1e-4, 1e-4)) << i;
  const auto rough = gradients(run_recurrent(from_input_, weight_, bias_, true));
  // bf16 keeps 8 bits; where the CPU has no instruction for it, libtorch rounds every product's result to
  // them too.
  EXPECT_LT((rough[1] - expected[1]).norm().item<double>(), 0.02 * expected[1].norm().item<double>());
}

}  // namespace
}  // namespace mien::train::recurrent_test
