#include "mien/speech/sound_message.h"

#include <fmt/format.h>

#include <string_view>

#include "mien/core/bytes.h"

namespace mien::speech {
namespace {

constexpr std::string_view kMagic = "MSND";
constexpr std::uint8_t kMessageVersion = 1;
const char* const kSoundMessage = "sound of the page";
/// A page of this program's own version sends none of it.
const char* const kLoadAnew = "load the page anew";

}  // namespace

Result<SoundMessage> parse_message(std::span<const std::byte> bytes) {
  if (bytes.size() < kMessageHeadBytes + sizeof(std::int16_t))
    return fail(ErrorCode::truncated, fmt::format("{} bytes", bytes.size()), kSoundMessage, kLoadAnew);
  ByteReader reader(bytes);
  for (const char letter : kMagic)
    if (reader.little<std::uint8_t>() != static_cast<std::uint8_t>(letter))
      return fail(ErrorCode::malformed, "it does not begin as sound", kSoundMessage, kLoadAnew);
  if (const auto version = reader.little<std::uint8_t>(); version != kMessageVersion)
    return fail(ErrorCode::unsupported, fmt::format("version {}", version), kSoundMessage, kLoadAnew);
  bool reserved = reader.little<std::uint8_t>() != 0;
  reserved = reader.little<std::uint16_t>() != 0 || reserved;
  if (reserved) return fail(ErrorCode::malformed, "a reserved byte is set", kSoundMessage, kLoadAnew);
  const auto rate_hz = reader.little<std::uint32_t>();
  if (rate_hz < kLowestRateHz || rate_hz > kHighestRateHz)
    return fail(ErrorCode::out_of_range, fmt::format("sound of {} Hz", rate_hz), kSoundMessage,
                fmt::format("let the browser's machine use a rate that is heard, {} to {} Hz", kLowestRateHz,
                            kHighestRateHz));
  SoundMessage message;
  message.rate_hz = static_cast<int>(rate_hz);
  message.count = reader.little<std::uint64_t>();
  if (message.count >= kMostSamples)
    return fail(ErrorCode::out_of_range, fmt::format("{} samples before it", message.count), kSoundMessage,
                kLoadAnew);
  if (reader.left() % sizeof(std::int16_t) != 0)
    return fail(ErrorCode::malformed, "it ends in half a sample", kSoundMessage, kLoadAnew);
  const std::size_t samples = reader.left() / sizeof(std::int16_t);
  if (samples > rate_hz / kMessagesPerSecond)
    return fail(ErrorCode::malformed, "more than a tenth of a second in one message", kSoundMessage,
                kLoadAnew);
  message.samples.resize(samples);
  for (std::int16_t& sample : message.samples) sample = reader.little<std::int16_t>();
  return message;
}

std::vector<std::byte> encode_message(const SoundMessage& message) {
  ByteWriter writer;
  writer.append(kMagic);
  writer.little(kMessageVersion);
  writer.little(std::uint8_t{0});
  writer.little(std::uint16_t{0});
  writer.little(static_cast<std::uint32_t>(message.rate_hz));
  writer.little(message.count);
  for (const std::int16_t sample : message.samples) writer.little(sample);
  return writer.release();
}

}  // namespace mien::speech
