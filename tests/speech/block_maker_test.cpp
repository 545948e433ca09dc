#include "mien/speech/block_maker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace mien::speech::block_maker_test {
namespace {

std::vector<std::int16_t> through(int rate_hz, std::span<const float> sound, std::size_t piece) {
  BlockMaker maker = BlockMaker::create(rate_hz).value();
  std::vector<std::int16_t> out;
  const auto take = [&](const Block& block) { out.insert(out.end(), block.begin(), block.end()); };
  for (std::size_t at = 0; at < sound.size(); at += piece)
    maker.push(sound.subspan(at, std::min(piece, sound.size() - at)), take);
  maker.finish(take);
  return out;
}

std::vector<float> sine(int rate_hz, double hz, double seconds) {
  std::vector<float> out(static_cast<std::size_t>(seconds * rate_hz));
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = static_cast<float>(0.5 * std::sin(2 * std::numbers::pi * hz * static_cast<double>(i) / rate_hz));
  return out;
}

/// Root mean square from a tenth of a second on, without the last.
double loudness(const std::vector<std::int16_t>& sound) {
  double sum = 0, count = 0;
  for (std::size_t i = 1'600; i + 1'600 < sound.size(); ++i, count += 1)
    sum += static_cast<double>(sound[i]) * sound[i];
  return std::sqrt(sum / count) / kFullScale;
}

TEST(BlockMaker, OwnRateComesAsItIs) {
  std::vector<float> sound(1'000);
  for (std::size_t i = 0; i < sound.size(); ++i) sound[i] = static_cast<float>(i) / kFullScale;
  const auto out = through(kRateHz, sound, 77);
  ASSERT_EQ(out.size(), 4 * kBlockSamples) << "the last block is filled up";
  for (std::size_t i = 0; i < out.size(); ++i)
    EXPECT_EQ(out[i], i < 1'000 ? static_cast<std::int16_t>(i) : 0);
}

TEST(BlockMaker, OtherRatesKeepPitchAndLoudness) {
  for (const int rate_hz : {8'000, 22'050, 44'100, 48'000, 96'000}) {
    const auto out = through(rate_hz, sine(rate_hz, 1'000, 1), 441);
    EXPECT_NEAR(static_cast<double>(out.size()), kRateHz, 2 * kBlockSamples) << rate_hz;
    EXPECT_NEAR(loudness(out), 0.5 / std::numbers::sqrt2, 0.005) << rate_hz;
    int crossings = 0;
    for (std::size_t i = 1'601; i + 1'600 < out.size(); ++i)
      crossings += out[i - 1] < 0 && out[i] >= 0 ? 1 : 0;
    EXPECT_NEAR(crossings, 1'000 * static_cast<double>(out.size() - 3'200) / kRateHz, 2) << rate_hz;
  }
}

TEST(BlockMaker, WhatWouldFoldBackIsGone) {
  EXPECT_LT(loudness(through(48'000, sine(48'000, 12'000, 1), 480)), 0.002) << "it would be heard as 4 kHz";
}

TEST(BlockMaker, NothingMovesInTime) {
  for (const int rate_hz : {8'000, 22'050, 48'000}) {
    std::vector<float> click(static_cast<std::size_t>(rate_hz));
    click[static_cast<std::size_t>(rate_hz) / 2] = 0.9F;
    const auto out = through(rate_hz, click, 100);
    const auto loudest = std::ranges::max_element(out) - out.begin();
    EXPECT_NEAR(static_cast<double>(loudest), kRateHz / 2.0, 2) << rate_hz;
  }
}

TEST(BlockMaker, PiecesDoNotMatter) {
  const auto sound = sine(44'100, 300, 0.5);
  EXPECT_EQ(through(44'100, sound, 1), through(44'100, sound, 10'000));
}

TEST(BlockMaker, WhatIsNoSoundIsSilence) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (const int rate_hz : {kRateHz, 44'100})
    for (const std::int16_t sample : through(rate_hz, std::vector<float>{nan, inf, -inf, nan, nan}, 5))
      EXPECT_EQ(sample, 0);
  // And what is too loud is clipped.
  const auto loud = through(kRateHz, std::vector<float>{9, -9, 1e30F}, 3);
  EXPECT_EQ(loud[0], 32'767);
  EXPECT_EQ(loud[1], -32'768);
  EXPECT_EQ(loud[2], 32'767);
}

TEST(BlockMaker, RefusesRatesThatNobodyHas) {
  for (const int rate_hz : {0, -1, 1, 999, 768'001})
    EXPECT_EQ(BlockMaker::create(rate_hz).error().code, ErrorCode::out_of_range) << rate_hz;
}

}  // namespace
}  // namespace mien::speech::block_maker_test
