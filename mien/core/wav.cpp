#include "mien/core/wav.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "mien/core/bytes.h"

namespace mien {
namespace {

constexpr std::uint16_t kInteger = 1, kFloating = 3, kExtensible = 0xFFFE;

/// What a data chunk promises whose writer did not know how much would come.
constexpr std::size_t kUnknownSize = 0xFFFF'FFFF;

bool is_tag(std::span<const std::byte> bytes, std::string_view tag) {
  return std::ranges::equal(bytes, std::as_bytes(std::span(tag)));
}

struct Coding {
  std::uint16_t kind = 0;
  std::uint16_t channels = 0;
  std::uint32_t rate_hz = 0;
  std::uint16_t bits = 0;
};

}  // namespace

Result<Sound> parse_wav(std::span<const std::byte> bytes, std::string_view name) {
  const std::string where(name);
  ByteReader file(bytes);
  const auto riff = file.take(4);
  file.little<std::uint32_t>();
  const auto wave = file.take(4);
  if (!file.ok() || !is_tag(riff, "RIFF") || !is_tag(wave, "WAVE"))
    return fail(ErrorCode::malformed, "this is no RIFF WAVE file", where);

  Coding coding;
  while (file.left() >= 8) {
    const auto tag = file.take(4);
    const std::size_t promised = file.little<std::uint32_t>();
    const std::size_t size = std::min(promised, file.left());
    ByteReader chunk(file.take(size));
    if (promised % 2 == 1 && file.left() > 0) (void)file.take(1);
    if (is_tag(tag, "fmt ")) {
      coding.kind = chunk.little<std::uint16_t>();
      coding.channels = chunk.little<std::uint16_t>();
      coding.rate_hz = chunk.little<std::uint32_t>();
      (void)chunk.take(6);  // Bytes a second and a frame, which follow from the rest.
      coding.bits = chunk.little<std::uint16_t>();
      if (!chunk.ok()) return fail(ErrorCode::truncated, "the format chunk is cut short", where);
      if (coding.kind == kExtensible) {
        (void)chunk.take(8);
        coding.kind = chunk.little<std::uint16_t>();
        if (!chunk.ok()) return fail(ErrorCode::truncated, "the format chunk is cut short", where);
      }
    } else if (is_tag(tag, "data")) {
      if (coding.channels == 0) return fail(ErrorCode::malformed, "sound stands before its format", where);
      if (coding.rate_hz < 1000 || coding.rate_hz > 768'000)
        return fail(ErrorCode::out_of_range, fmt::format("a rate of {} Hz", coding.rate_hz), where);
      const bool integers = coding.kind == kInteger && coding.bits == 16;
      if (!integers && !(coding.kind == kFloating && coding.bits == 32))
        return fail(ErrorCode::unsupported,
                    fmt::format("sound of coding {} with {} bits", coding.kind, coding.bits), where,
                    "convert it to 16-bit PCM");
      Sound sound{.rate_hz = coding.rate_hz, .samples = {}};
      const std::size_t frame_bytes = std::size_t{coding.channels} * coding.bits / 8;
      const std::size_t frames = size / frame_bytes;
      if (promised != kUnknownSize) sound.missing = promised / frame_bytes - frames;
      sound.samples.reserve(frames);
      for (std::size_t i = 0; i < frames; ++i) {
        float sum = 0;
        for (int c = 0; c < coding.channels; ++c)
          sum +=
              integers ? static_cast<float>(chunk.little<std::int16_t>()) / 32768.0F : chunk.little<float>();
        if (!std::isfinite(sum))
          return fail(ErrorCode::out_of_range, fmt::format("sample {} is not finite", i), where);
        sound.samples.push_back(sum / static_cast<float>(coding.channels));
      }
      return sound;
    }
  }
  return fail(ErrorCode::truncated, "there is no sound in this file", where);
}

std::vector<std::byte> format_wav(const Sound& sound) {
  ByteWriter file;
  const auto size = static_cast<std::uint32_t>(2 * sound.samples.size());
  file.append("RIFF");
  file.little(36 + size);
  file.append("WAVEfmt ");
  file.little(std::uint32_t{16});
  file.little(kInteger);
  file.little(std::uint16_t{1});
  file.little(sound.rate_hz);
  file.little(2 * sound.rate_hz);
  file.little(std::uint16_t{2});
  file.little(std::uint16_t{16});
  file.append("data");
  file.little(size);
  for (const float s : sound.samples)
    file.little(static_cast<std::int16_t>(std::lround(std::clamp(s * 32768.0F, -32768.0F, 32767.0F))));
  return file.release();
}

}  // namespace mien
