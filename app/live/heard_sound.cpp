#include "app/live/heard_sound.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "mien/core/time.h"
#include "mien/speech/sound_block.h"

namespace mien::app {
namespace {

/// Below it for so long a microphone is told to be silent: a quiet room is louder.
constexpr float kSilence = 3e-4F;
/// Over about so long a stream's lateness becomes the usual one.
constexpr double kDrift_s = 10;

double seconds_between(HeardSound::Clock::time_point from, HeardSound::Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

double Lateness::behind_s(double position_s, Clock::time_point now) const {
  return seconds_between(begun_, now) - position_s;
}

double Lateness::at(double position_s, Clock::time_point now) const {
  return behind_s(position_s, now) - usual_s_;
}

void Lateness::follow(double position_s, Clock::time_point now) {
  const double share = std::min(seconds_between(newest_, now) / kDrift_s, 1.0);
  newest_ = now;
  usual_s_ += share * (behind_s(position_s, now) - usual_s_);
}

Result<void> HeardSound::begin(int rate_hz, Clock::time_point now) {
  MIEN_TRY_ASSIGN(maker_, speech::BlockMaker::create(rate_hz));
  rate_hz_ = static_cast<std::uint64_t>(rate_hz);
  first_ = true;
  silent_.clear();
  publish();
  quiet_since_ = now;
  return {};
}

void HeardSound::push(std::span<const float> samples, Clock::time_point now) {
  watch_silence(samples, now);
  maker_->push(samples, [this, now](const speech::Block& block) { hand_over(block, now); });
}

void HeardSound::skip(std::uint64_t samples, Clock::time_point now) {
  constexpr std::uint64_t kBlocksPerSecond = speech::kRateHz / speech::kBlockSamples;
  const std::uint64_t blocks = samples * kBlocksPerSecond / rate_hz_;
  next_block_ += blocks;
  const std::vector<float> silence(samples - blocks * rate_hz_ / kBlocksPerSecond);
  maker_->push(silence, [this, now](const speech::Block& block) { hand_over(block, now); });
}

void HeardSound::catch_up(Clock::time_point now) {
  next_block_ = std::max(next_block_, block_at(now));
}

void HeardSound::watch_silence(std::span<const float> samples, Clock::time_point now) {
  if (std::ranges::any_of(samples, [](float s) { return std::abs(s) > kSilence; })) {
    if (!silent_.empty()) {
      port_.tell("microphone_heard", name_ + " is heard");
      silent_.clear();
      publish();
    }
    quiet_since_ = now;
  } else if (silent_.empty() && now - quiet_since_ >= kSilent) {
    silent_ = name_ +
              " has been silent for 5 s: see that it is switched on and not muted, and that the system lets "
              "it be heard";
    port_.tell("microphone_silent", silent_);
    publish();
  }
}

void HeardSound::trouble(std::string text) {
  other_ = std::move(text);
  publish();
}

void HeardSound::over() {
  silent_.clear();
  other_.clear();
  publish();
}

void HeardSound::publish() {
  port_.trouble(other_.empty() ? silent_ : other_);
}

std::uint64_t HeardSound::block_at(Clock::time_point now) const {
  // What came in before the feed's thread began is of its first block.
  return static_cast<std::uint64_t>(std::max(now - begun_, Clock::duration::zero()) / speech::kBlockDuration);
}

void HeardSound::hand_over(const speech::Block& block, Clock::time_point now) {
  if (first_) catch_up(now);
  first_ = false;
  if (const auto header = speech::encode_header({.device = device_, .block = next_block_}))
    port_.hand_over(*header, speech::payload_of(block));
  ++next_block_;
}

}  // namespace mien::app
