#include "app/take_sound.h"

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "mien/speech/sound_block.h"

namespace mien::app {
namespace {

/// Blocks of a gap that is kept as silence: a minute.
constexpr std::uint64_t kLongestGap = 60 * speech::kRateHz / speech::kBlockSamples;

/// Blocks of a device that was started anew are counted from below this: a second.
constexpr std::uint64_t kRestart = speech::kRateHz / speech::kBlockSamples;

/// Appends block after block of one device.
class Gathered {
 public:
  void add(const speech::BlockHeader& header, const speech::Block& block) {
    if (device_ && *device_ != header.device) return;
    device_ = header.device;
    // Doubled, late, or of another who sends as this device; a device that restarts counts from 0.
    if (next_ && header.block < *next_ && header.block > kRestart) return;
    if (next_ && header.block > *next_ && header.block - *next_ <= kLongestGap)
      sound_.samples.resize(sound_.samples.size() + (header.block - *next_) * speech::kBlockSamples);
    for (const std::int16_t sample : block)
      sound_.samples.push_back(static_cast<float>(sample) / speech::kFullScale);
    next_ = header.block + 1;
  }
  [[nodiscard]] bool any() const { return device_.has_value(); }
  [[nodiscard]] Sound take() { return std::move(sound_); }

 private:
  Sound sound_{.rate_hz = speech::kRateHz, .samples = {}};
  std::optional<std::uint64_t> device_;
  std::optional<std::uint64_t> next_;
};

}  // namespace

Result<Sound> sound_of(const take::Take& take) {
  MIEN_TRY_ASSIGN(const std::vector<take::LogEntry> entries, take.entries());
  MIEN_TRY_ASSIGN(take::PayloadReader payloads, take.payloads());
  Gathered gathered;
  for (const take::LogEntry& entry : entries) {
    if (!speech::is_block(entry.bytes) && !speech::is_packet(entry.bytes)) continue;
    MIEN_TRY_ASSIGN(const sensor::Payload payload, payloads.of(entry.id));
    if (const auto logged = speech::logged_block(entry.bytes, payload.bytes))
      gathered.add(logged->header, logged->block);
  }
  if (gathered.any()) return gathered.take();
  MIEN_TRY_ASSIGN(std::optional<take::Audio> audio, take.audio());
  if (!audio)
    return fail(ErrorCode::not_found, "the take has no sound", take.path().string(),
                "record one with --audio, or perform one with a voice");
  return Sound{.rate_hz = static_cast<std::uint32_t>(audio->rate_hz), .samples = std::move(audio->samples)};
}

}  // namespace mien::app
