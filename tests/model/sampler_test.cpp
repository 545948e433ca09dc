#include "mien/model/sampler.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/model/random_network.h"

namespace mien::model::sampler_test {
namespace {

const Architecture kSmall{.name = {},
                          .layers = 1,
                          .d_model = 32,
                          .heads = 1,
                          .d_head = 32,
                          .ffn = 32,
                          .window = 20,
                          .condition = 5,
                          .outputs = 4};

std::vector<float> smooth_condition(std::size_t frames) {
  std::vector<float> condition;
  for (std::size_t f = 0; f < frames; ++f)
    for (std::size_t i = 0; i < 5; ++i)
      condition.push_back(std::sin(0.07F * static_cast<float>(f) * static_cast<float>(i + 1)));
  return condition;
}

class Sampler : public testing::Test {
 protected:
  Denoiser denoiser_ = *Denoiser::create(kSmall, random_network(kSmall, 4));
  ScheduleSettings schedule_{.levels = 50};
};

TEST(Schedule, SignalFallsFromAlmostOneToAlmostZero) {
  const auto signal = cosine_signal({});
  ASSERT_EQ(signal.size(), 1000U);
  EXPECT_NEAR(signal.front(), 0.99996, 1e-5);
  EXPECT_NEAR(signal[499], 0.49384,
              1e-4);  // cos^2 of (0.5 + 0.008) / 1.008 of a right angle, over its start.
  EXPECT_LT(signal.back(), 1e-5);
  for (std::size_t t = 1; t < signal.size(); ++t) ASSERT_LT(signal[t], signal[t - 1]);
}

TEST(Schedule, SamplersVisitLevelsFromTheLast) {
  EXPECT_EQ(sampler_levels({.steps = 1}, 1000), (std::vector<std::size_t>{999}));
  EXPECT_EQ(sampler_levels({.steps = 4}, 1000), (std::vector<std::size_t>{999, 749, 499, 249}));
  const auto all = sampler_levels({.kind = SamplerKind::ddpm, .steps = 3}, 1000);
  ASSERT_EQ(all.size(), 1000U);
  EXPECT_EQ(all.back(), 0U);
}

TEST(Windows, CoverEveryFrame) {
  EXPECT_EQ(window_starts(1, 120), (std::vector<std::size_t>{0}));
  EXPECT_EQ(window_starts(120, 120), (std::vector<std::size_t>{0}));
  EXPECT_EQ(window_starts(121, 120), (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(window_starts(300, 120), (std::vector<std::size_t>{0, 60, 120, 180}));
  EXPECT_EQ(window_starts(310, 120), (std::vector<std::size_t>{0, 60, 120, 180, 190}));
}

TEST_F(Sampler, TheSameSeedGivesTheSameBits) {
  const auto condition = smooth_condition(53);
  for (const SamplerKind kind : {SamplerKind::ddim, SamplerKind::ddpm})
    for (const OverlapHold hold : {OverlapHold::clean, OverlapHold::noised}) {
      const SamplerSettings settings{.kind = kind, .steps = 5, .seed = 3, .hold = hold};
      const auto once = solve_windows(denoiser_, schedule_, condition, settings, no_progress);
      const auto again = solve_windows(denoiser_, schedule_, condition, settings, no_progress);
      ASSERT_TRUE(once) << once.error().message();
      EXPECT_EQ(*once, *again);
      ASSERT_EQ(once->size(), 53U * 4U);
      for (const float w : *once) ASSERT_TRUE(w >= 0 && w <= 1);
      SamplerSettings other = settings;
      other.seed = 4;
      EXPECT_NE(*once, *solve_windows(denoiser_, schedule_, condition, other, no_progress));
    }
}

TEST_F(Sampler, OneStepIsTheNetworksOwnAnswer) {
  const auto condition = smooth_condition(20);
  const auto solved = solve_windows(denoiser_, schedule_, condition, {.steps = 1, .seed = 3}, no_progress);
  ASSERT_TRUE(solved);
  Random noise = Random(3).fork("first noise");
  std::vector<float> noisy(80), clean(80);
  for (float& v : noisy) v = static_cast<float>(noise.normal());
  Denoiser::Workspace workspace(denoiser_);
  denoiser_.set_condition(condition, workspace);
  denoiser_.predict(noisy, 49, clean, workspace);
  for (std::size_t i = 0; i < clean.size(); ++i) EXPECT_EQ((*solved)[i], from_network(clean[i]));
}

TEST_F(Sampler, WithoutFirstNoiseTheSeedDoesNotMatter) {
  const auto condition = smooth_condition(53);
  SamplerSettings settings{.steps = 2, .seed = 3, .first_noise = 0};
  const auto one = solve_windows(denoiser_, schedule_, condition, settings, no_progress);
  settings.seed = 4;
  EXPECT_EQ(*one, *solve_windows(denoiser_, schedule_, condition, settings, no_progress));
  settings.first_noise = 1;
  EXPECT_NE(*one, *solve_windows(denoiser_, schedule_, condition, settings, no_progress));
  settings.kind = SamplerKind::ddpm;
  const auto published = solve_windows(denoiser_, schedule_, condition, settings, no_progress);
  settings.first_noise = 0;
  EXPECT_EQ(*published, *solve_windows(denoiser_, schedule_, condition, settings, no_progress));
}

TEST_F(Sampler, ShortTakesWork) {
  for (const std::size_t frames : {1U, 2U, 19U, 21U})
    EXPECT_TRUE(solve_windows(denoiser_, schedule_, smooth_condition(frames), {.steps = 3}, no_progress))
        << frames;
}

TEST_F(Sampler, ARefusalIsOneLine) {
  auto condition = smooth_condition(30);
  const auto code = [&](const SamplerSettings& settings) {
    const auto solved = solve_windows(denoiser_, schedule_, condition, settings, no_progress);
    return solved ? ErrorCode::internal : solved.error().code;
  };
  EXPECT_EQ(code({.steps = 0}), ErrorCode::bad_usage);
  EXPECT_EQ(code({.steps = 51}), ErrorCode::bad_usage);
  EXPECT_EQ(code({.first_noise = 2}), ErrorCode::bad_usage);
  EXPECT_EQ(code({.first_noise = NAN}), ErrorCode::bad_usage);
  condition[7] = NAN;
  EXPECT_EQ(code({}), ErrorCode::out_of_range);
  condition.resize(7);
  EXPECT_EQ(code({}), ErrorCode::bad_usage);
  condition.clear();
  EXPECT_EQ(code({}), ErrorCode::bad_usage);
  condition = smooth_condition(30);
  const auto stopped =
      solve_windows(denoiser_, schedule_, condition, {}, [](double, std::string_view) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

TEST_F(Sampler, WeightsMapBackAndForth) {
  for (const float w : {0.0F, 0.25F, 1.0F}) EXPECT_EQ(from_network(to_network(w)), w);
  EXPECT_EQ(to_network(1.5F), 1.0F);
  EXPECT_EQ(from_network(-3.0F), 0.0F);
}

}  // namespace
}  // namespace mien::model::sampler_test
