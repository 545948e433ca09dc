#include "mien/train/batch_norm.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "mien/train/torch.h"

namespace mien::train {
namespace {

struct Case {
  std::int64_t pictures, channels, height, width;
};

/// What libtorch's own operations answer, one after the other, in fp64.
torch::Tensor by_definition(const torch::Tensor& x, const torch::Tensor& shift) {
  const std::vector<std::int64_t> over = {0, 2, 3};
  const torch::Tensor mean = x.mean(over, true), from_mean = x - mean;
  const torch::Tensor variance = from_mean.square().mean(over, true);
  return torch::relu(from_mean / (variance + kBatchNormEpsilon).sqrt() + shift.view({1, -1, 1, 1}));
}

TEST(BatchNorm, AnswersAndLearnsAsItsDefinition) {
  torch::manual_seed(3);
  for (const Case& c : {Case{5, 3, 7, 9}, Case{2, 1, 1, 3}, Case{16, 8, 24, 24}}) {
    SCOPED_TRACE(c.pictures);
    const torch::Tensor data = torch::randn({c.pictures, c.channels, c.height, c.width}) * 2 + 1.5;
    const torch::Tensor of_out = torch::randn_like(data);
    torch::Tensor x = data.clone().requires_grad_(), shift = torch::randn({c.channels}).requires_grad_();
    torch::Tensor exact = data.to(torch::kDouble).requires_grad_(),
                  exact_shift = shift.detach().to(torch::kDouble).requires_grad_();
    ChannelStatistics found;
    const torch::Tensor out = normalise_and_rectify(x, shift, &found),
                        same = by_definition(exact, exact_shift);
    EXPECT_LT((out - same).abs().max().item<double>(), 1e-5);
    const std::vector<std::int64_t> over = {0, 2, 3};
    EXPECT_LT((found.mean - exact.mean(over)).abs().max().item<double>(), 1e-5);
    EXPECT_LT((found.variance - exact.var(over, false)).abs().max().item<double>(), 1e-4);
    (out * of_out).sum().backward();
    (same * of_out.to(torch::kDouble)).sum().backward();
    EXPECT_LT((x.grad() - exact.grad()).abs().max().item<double>(), 1e-4);
    EXPECT_LT((shift.grad() - exact_shift.grad()).abs().max().item<double>(), 1e-3);
  }
}

TEST(BatchNorm, GivesTheSameStatisticsInOtherPrecisions) {
  torch::manual_seed(4);
  const torch::Tensor data = torch::randn({6, 3, 5, 5}) * 2 + 1.5, shift = torch::randn({3});
  ChannelStatistics fp32, bf16;
  const torch::Tensor exact = normalise_and_rectify(data, shift, &fp32);
  const torch::Tensor rough =
      normalise_and_rectify(data.to(torch::kBFloat16), shift.to(torch::kBFloat16), &bf16);
  EXPECT_LT((fp32.mean - bf16.mean).abs().max().item<double>(), 0.02);
  EXPECT_LT((fp32.variance - bf16.variance).abs().max().item<double>(), 0.03);
  EXPECT_LT((exact - rough.to(torch::kFloat)).abs().max().item<double>(), 0.05);
}

TEST(BatchNorm, LearnsTheSameWhereLibtorchNormalises) {
  torch::manual_seed(5);
  const torch::Tensor data = torch::randn({4, 3, 6, 5}) * 2 + 1.5, of_out = torch::randn_like(data);
  torch::Tensor ours = data.clone().requires_grad_(), theirs = data.to(torch::kDouble).requires_grad_();
  const torch::Tensor shift = torch::randn({3});
  ChannelStatistics of_ours, of_theirs;
  (normalise_and_rectify(ours, shift, &of_ours) * of_out).sum().backward();
  (normalise_and_rectify(theirs, shift.to(torch::kDouble), &of_theirs) * of_out.to(torch::kDouble))
      .sum()
      .backward();
  EXPECT_LT((ours.grad() - theirs.grad()).abs().max().item<double>(), 1e-4);
  EXPECT_LT((of_ours.variance - of_theirs.variance).abs().max().item<double>(), 1e-4);
}

TEST(BatchNorm, TakesEvenChannelsAndViewsThatAreNotContiguous) {
  const torch::Tensor even = torch::full({3, 2, 4, 4}, 7.0F).requires_grad_();
  const torch::Tensor shift = torch::tensor({0.5F, -0.5F}).requires_grad_();
  const torch::Tensor out = normalise_and_rectify(even, shift, nullptr);
  EXPECT_FLOAT_EQ(out[0][0][0][0].item<float>(), 0.5F);
  EXPECT_FLOAT_EQ(out[2][1][3][3].item<float>(), 0);
  out.sum().backward();
  EXPECT_TRUE(torch::isfinite(even.grad()).all().item<bool>());
  const torch::Tensor turned = torch::randn({3, 4, 5, 2}).permute({0, 3, 1, 2});
  EXPECT_TRUE(torch::equal(normalise_and_rectify(turned, shift, nullptr),
                           normalise_and_rectify(turned.contiguous(), shift, nullptr)));
}

}  // namespace
}  // namespace mien::train
