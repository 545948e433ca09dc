#include "mien/speech/phone_decoder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "mien/core/random.h"
#include "mien/speech/listeners.h"

namespace mien::speech::phone_decoder_test {
namespace {

using testing::HasSubstr;

/// Two vowels of a buzzing voice, two resonances each, with noise between them; 0.6 s, then silence.
std::vector<Block> babble() {
  Random random(3);
  std::vector<float> sound(3 * kRateHz / 2);
  for (std::size_t i = 0; i < sound.size(); ++i) {
    const double t = static_cast<double>(i) / kRateHz;
    const bool first = t < 0.25, noise = t >= 0.25 && t < 0.35, second = t >= 0.35 && t < 0.6;
    if (noise) sound[i] = static_cast<float>(0.05 * random.normal());
    if (!first && !second) continue;
    const double low = first ? 700 : 300, high = first ? 1'100 : 2'200;
    for (int h = 1; h < 30; ++h) {
      const double hz = 120.0 * h;
      const double gain =
          std::exp(-std::pow((hz - low) / 120, 2)) + 0.5 * std::exp(-std::pow((hz - high) / 160, 2));
      sound[i] += static_cast<float>(0.2 * gain * std::sin(2 * std::numbers::pi * hz * t));
    }
  }
  std::vector<Block> blocks;
  for (std::size_t at = 0; at + kBlockSamples <= sound.size(); at += kBlockSamples)
    for (std::size_t i = 0; i < kBlockSamples; ++i) {
      if (i == 0) blocks.emplace_back();
      blocks.back()[i] = static_cast<std::int16_t>(std::lround(20'000 * sound[at + i]));
    }
  return blocks;
}

std::vector<std::string> phones(PhoneDecoder& decoder, const std::vector<Block>& blocks) {
  std::vector<std::string> out;
  for (const Block& block : blocks) {
    out.emplace_back();
    std::uint64_t last = 0;
    for (const HeardPhone& phone : decoder.push(block)) {
      EXPECT_LT(phone.begin, phone.end);
      EXPECT_GE(phone.begin, last);
      last = phone.end;
      out.back() += std::string(phone.name()) + std::to_string(phone.begin) + " ";
    }
    EXPECT_LE(last, 2 * out.size()) << "nothing is heard before it is said";
  }
  return out;
}

TEST(PhoneDecoder, HearsTheSameEachTime) {
  auto decoder = PhoneDecoder::create();
  ASSERT_TRUE(decoder) << decoder.error().message();
  const std::vector<Block> blocks = babble();
  const auto first = phones(*decoder, blocks);
  EXPECT_NE(first.back(), "");
  auto other = PhoneDecoder::create();
  EXPECT_EQ(phones(*other, blocks), first);
}

/// The babble, so many times.
std::vector<Block> babbles(int times) {
  std::vector<Block> all;
  const std::vector<Block> once = babble();
  for (int i = 0; i < times; ++i) all.insert(all.end(), once.begin(), once.end());
  return all;
}

TEST(PhoneDecoder, SeveralUtterancesStandInOrder) {
  auto decoder = PhoneDecoder::create();
  ASSERT_TRUE(decoder) << decoder.error().message();
  const auto heard = phones(*decoder, babbles(3));  // phones() looks at their order.
  EXPECT_GT(std::ranges::count(heard.back(), ' '), std::ranges::count(heard[74], ' '));
}

TEST(PhoneDecoder, EndsAnUtteranceThatDoesNotEnd) {
  auto decoder = PhoneDecoder::create();
  ASSERT_TRUE(decoder) << decoder.error().message();
  // Without the pauses: 15 s of speech.
  std::vector<Block> blocks;
  const std::vector<Block> once = babble();
  while (blocks.size() < 750) blocks.insert(blocks.end(), once.begin(), once.begin() + 30);
  phones(*decoder, blocks);
  bool open = false;
  for (int i = 0; i < 100; ++i) {
    open = false;
    for (const HeardPhone& phone : decoder->push({})) open = open || phone.open;
  }
  EXPECT_FALSE(open);
}

TEST(PhoneDecoder, HearsNothingInSilence) {
  auto decoder = PhoneDecoder::create();
  ASSERT_TRUE(decoder) << decoder.error().message();
  for (const std::string& heard : phones(*decoder, std::vector<Block>(100))) EXPECT_EQ(heard, "");
}

TEST(PhoneDecoder, NamesThePackageOfItsModel) {
  const auto decoder = PhoneDecoder::create("/nowhere");
  ASSERT_FALSE(decoder);
  EXPECT_EQ(decoder.error().code, ErrorCode::not_found);
  EXPECT_THAT(decoder.error().message(), HasSubstr("pocketsphinx-en-us"));
  EXPECT_THAT(decoder.error().message(), HasSubstr("/nowhere"));
}

TEST(PhoneListener, AMouthThatWasCutOffCloses) {
  auto decoder = PhoneDecoder::create();
  ASSERT_TRUE(decoder) << decoder.error().message();
  PhoneListener listener(*std::move(decoder));
  // 12 s of speech end an utterance in the middle of a sound; then nobody speaks.
  const std::vector<Block> once = babble();
  DeviceTime time{};
  Heard heard;
  const auto push = [&](const Block& block) {
    heard = listener.push(time, block);
    time += kBlockDuration;
  };
  for (int i = 0; i < 596; ++i) push(once[static_cast<std::size_t>(i % 12)]);
  for (int i = 0; i < 100; ++i) push({});
  EXPECT_EQ(heard.voice, 0);
  EXPECT_LT(heard.weights[face::shape("jawOpen")], 0.01F);
}

TEST(PhoneListener, OpensTheMouthForAVowelAndClosesItInSilence) {
  auto decoder = PhoneDecoder::create();
  ASSERT_TRUE(decoder) << decoder.error().message();
  PhoneListener listener(*std::move(decoder));
  float most = 0;
  Heard heard;
  DeviceTime time{std::chrono::seconds(1)};
  for (const Block& block : babble()) {
    heard = listener.push(time, block);
    EXPECT_EQ(heard.time, time + std::chrono::milliseconds(20) - PhoneListener::kDelay);
    time += std::chrono::milliseconds(20);
    most = std::max(most, heard.weights[face::shape("jawOpen")]);
  }
  EXPECT_GT(most, 0.05F);
  EXPECT_LT(heard.weights[face::shape("jawOpen")], 0.02F);
  EXPECT_EQ(heard.voice, 0);
}

}  // namespace
}  // namespace mien::speech::phone_decoder_test
