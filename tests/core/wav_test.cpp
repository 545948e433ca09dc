#include "mien/core/wav.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "mien/core/bytes.h"

namespace mien::wav_test {
namespace {

std::vector<std::byte> wav_of(std::uint16_t kind, std::uint16_t channels, std::uint32_t rate_hz,
                              std::uint16_t bits, std::span<const std::byte> data, std::uint32_t promised) {
  ByteWriter file;
  file.append("RIFF");
  file.little(std::uint32_t{0});
  file.append("WAVELIST");
  file.little(std::uint32_t{3});
  file.append("abc");
  file.little(std::uint8_t{0});
  file.append("fmt ");
  file.little(std::uint32_t{16});
  file.little(kind);
  file.little(channels);
  file.little(rate_hz);
  file.little(std::uint32_t{0});
  file.little(std::uint16_t{0});
  file.little(bits);
  file.append("data");
  file.little(promised);
  file.append(data);
  return file.release();
}

TEST(Wav, ComesBackToTheLastBit) {
  Sound sound{.rate_hz = 22050, .samples = {}};
  for (int i = -32768; i < 32768; i += 77) sound.samples.push_back(static_cast<float>(i) / 32768.0F);
  const auto back = parse_wav(format_wav(sound), "x.wav");
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->rate_hz, 22050U);
  EXPECT_EQ(back->samples, sound.samples);
  EXPECT_DOUBLE_EQ(back->duration_s(), static_cast<double>(sound.samples.size()) / 22050);
}

TEST(Wav, ClipsWhatIsTooLoud) {
  const auto back = parse_wav(format_wav({.rate_hz = 8000, .samples = {7, -7}}), "x.wav");
  EXPECT_FLOAT_EQ(back->samples[0], 32767.0F / 32768.0F);
  EXPECT_FLOAT_EQ(back->samples[1], -1);
}

TEST(Wav, ReadsFloatsAndMixesChannels) {
  ByteWriter data;
  for (const float s : {0.5F, 0.25F, -1.0F, 1.0F}) data.little(s);
  const auto sound = parse_wav(wav_of(3, 2, 48000, 32, data.bytes(), 16), "x.wav");
  ASSERT_TRUE(sound.has_value()) << sound.error().message();
  ASSERT_EQ(sound->samples.size(), 2U);
  EXPECT_FLOAT_EQ(sound->samples[0], 0.375F);
  EXPECT_FLOAT_EQ(sound->samples[1], 0);
}

TEST(Wav, BelievesNoPromisedSize) {
  ByteWriter data;
  for (int i = 0; i < 5; ++i) data.little(std::int16_t{16384});
  const auto sound = parse_wav(wav_of(1, 1, 16000, 16, data.bytes(), 0xFFFFFFFF), "x.wav");
  ASSERT_TRUE(sound.has_value());
  EXPECT_EQ(sound->samples, std::vector<float>(5, 0.5F));
  EXPECT_EQ(sound->missing, 0U) << "who wrote it did not know";
}

TEST(Wav, TellsWhatIsMissingOfOneThatIsCutShort) {
  ByteWriter data;
  for (int i = 0; i < 6; ++i) data.little(std::int16_t{16384});
  const auto cut = parse_wav(wav_of(1, 2, 16000, 16, data.bytes(), 40), "x.wav");
  ASSERT_TRUE(cut.has_value());
  EXPECT_EQ(cut->samples.size(), 3U);
  EXPECT_EQ(cut->missing, 7U);
  EXPECT_EQ(parse_wav(wav_of(1, 2, 16000, 16, data.bytes(), 12), "x.wav")->missing, 0U);
}

TEST(Wav, GoesThroughAListThatPromisesMoreThanIsThere) {
  // 52 bytes: an item of 4 GB in a list of 1 GB. There are readers that take minutes over them.
  ByteWriter file;
  file.append("RIFF");
  file.little(std::uint32_t{0});
  file.append("WAVEfmt ");
  file.little(std::uint32_t{16});
  file.little(std::uint16_t{1});
  file.little(std::uint16_t{1});
  file.little(std::uint32_t{16000});
  file.little(std::uint32_t{32000});
  file.little(std::uint16_t{2});
  file.little(std::uint16_t{16});
  file.append("LIST");
  file.little(std::uint32_t{0x40000000});
  file.little(std::uint32_t{0xFFFFFF00});
  file.little(std::uint32_t{0xFFFFFFF7});
  EXPECT_EQ(parse_wav(file.bytes(), "x.wav").error().code, ErrorCode::truncated);
}

TEST(Wav, RefusesEachFaultAlone) {
  ByteWriter data;
  data.little(std::numeric_limits<float>::quiet_NaN());
  const auto code = [](const std::vector<std::byte>& bytes) {
    return parse_wav(bytes, "x.wav").error().code;
  };
  EXPECT_EQ(code({}), ErrorCode::malformed);
  EXPECT_EQ(code(wav_of(3, 1, 48000, 32, data.bytes(), 4)), ErrorCode::out_of_range);
  EXPECT_EQ(code(wav_of(1, 1, 10, 16, data.bytes(), 4)), ErrorCode::out_of_range);
  EXPECT_EQ(code(wav_of(1, 1, 48000, 24, data.bytes(), 4)), ErrorCode::unsupported);
  EXPECT_EQ(code(wav_of(2, 1, 48000, 16, data.bytes(), 4)), ErrorCode::unsupported);
  EXPECT_EQ(code(wav_of(1, 0, 48000, 16, data.bytes(), 4)), ErrorCode::malformed);
  const auto whole = format_wav({.rate_hz = 8000, .samples = {0.5F}});
  for (std::size_t size = 0; size < 44; ++size) {
    const std::vector<std::byte> part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(parse_wav(part, "x.wav").has_value() && size < 44) << size;
  }
}

}  // namespace
}  // namespace mien::wav_test
