#include "mien/train/optimiser.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "mien/train/recipe.h"
#include "mien/train/torch.h"

namespace mien::train::optimiser_test {
namespace {

/// By how much one step changes a parameter whose gradient is this.
torch::Tensor step_by(const torch::Tensor& gradient, bool muon, double rate) {
  Parameters parameters = {torch::zeros_like(gradient).requires_grad_()};
  parameters[0].mutable_grad() = gradient.clone();
  Adam adam(parameters, {muon});
  adam.step(parameters, rate, 0);
  return parameters[0].detach();
}

TEST(Adam, AFirstStepIsAsLongAsTheRateInEveryNumber) {
  const torch::Tensor step = step_by(torch::tensor({{3.0F, -0.2F}, {0.01F, -7.0F}}), false, 0.1);
  EXPECT_LT((step - torch::tensor({{-0.1F, 0.1F}, {-0.1F, 0.1F}})).abs().max().item<double>(), 1e-5);
}

TEST(Muon, StepsAlikeInEveryDirectionOfAMatrix) {
  torch::manual_seed(1);
  for (const auto& [rows, columns] : {std::pair(4, 9), std::pair(9, 4), std::pair(16, 16)}) {
    // Singular values from 1 to 1/50, all of which a step brings to about the same.
    const torch::Tensor left = std::get<0>(torch::linalg_qr(torch::randn({rows, rows}))),
                        right = std::get<0>(torch::linalg_qr(torch::randn({columns, columns})));
    const std::int64_t least = std::min(rows, columns);
    const torch::Tensor values = torch::logspace(0, -std::log10(50.0), least);
    const torch::Tensor gradient =
        torch::mm(left.narrow(1, 0, least) * values, right.narrow(1, 0, least).t());
    const double rate = 0.1, length = rate * 0.2 * std::sqrt(std::max(rows, columns));
    const torch::Tensor of_step = torch::linalg_svdvals(-step_by(gradient, true, rate)) / length;
    EXPECT_GT(of_step.min().item<double>(), 0.3) << rows;
    EXPECT_LT(of_step.max().item<double>(), 1.3) << rows;
    EXPECT_GT((step_by(gradient, true, rate) * gradient).sum().item<double>() * -1, 0) << "downhill";
  }
}

TEST(Muon, AConvolutionIsAMatrixOfOutputsByInputs) {
  torch::manual_seed(2);
  const torch::Tensor gradient = torch::randn({8, 3, 3, 3});
  const torch::Tensor step = step_by(gradient, true, 0.1);
  EXPECT_EQ(step.sizes(), gradient.sizes());
  EXPECT_TRUE(torch::equal(step.flatten(1), step_by(gradient.flatten(1), true, 0.1)));
}

TEST(Muon, StepsTheBackbonesMatricesAlone) {
  const auto recipe = parse_recipe(
      "[network]\narchitecture = \"views\"\n[optimiser]\nmuon = true\n[budget]\nsteps = 1\n", "test");
  ASSERT_TRUE(recipe) << recipe.error().message();
  EXPECT_TRUE(recipe->muon);
  model::Architecture architecture = recipe->architecture;
  architecture.outputs = 5;
  const auto specs = model::network_tensors(architecture);
  const std::vector<bool> which = matrices_of_backbones(architecture);
  ASSERT_EQ(which.size(), specs.size());
  std::size_t matrices = 0;
  for (std::size_t i = 0; i < specs.size(); ++i) {
    EXPECT_FALSE(which[i] && specs[i].shape.size() < 2) << specs[i].name;
    EXPECT_FALSE(which[i] && specs[i].name.starts_with("hidden")) << specs[i].name;
    matrices += which[i] ? 1 : 0;
  }
  EXPECT_EQ(matrices, 2 * (architecture.layers + 1)) << "two backbones";
}

}  // namespace
}  // namespace mien::train::optimiser_test
