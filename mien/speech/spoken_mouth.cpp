#include "mien/speech/spoken_mouth.h"

#include <algorithm>
#include <cmath>

namespace mien::speech {

std::optional<Heard> HeardTrack::at(DeviceTime time) const {
  for (std::size_t back = 0; back < heard_.size(); ++back) {
    const Heard& before = heard_[back];
    if (before.time > time) continue;
    if (back == 0) return before;
    const Heard& after = heard_[back - 1];
    const auto share =
        static_cast<float>(to_seconds(time - before.time) / to_seconds(after.time - before.time));
    Heard between = before;
    between.time = time;
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      between.weights[k] += share * (after.weights[k] - before.weights[k]);
    between.tongue += share * (after.tongue - before.tongue);
    between.closure += share * (after.closure - before.closure);
    between.voice += share * (after.voice - before.voice);
    return between;
  }
  return std::nullopt;
}

bool VoiceGate::step(DeviceTime time, float voice) {
  if (voice >= kSpeaks) speaks_ = true;
  if (voice >= kSilent)
    quiet_since_.reset();
  else if (!quiet_since_)
    quiet_since_ = time;
  if (quiet_since_ && time - *quiet_since_ >= kPause) speaks_ = false;
  return speaks_;
}

void VoiceGate::reset() {
  speaks_ = false;
  quiet_since_.reset();
}

void SpokenMouth::Follower::step(float target, double rate, double seconds) {
  if (rate <= 0) {
    value = target;
    return;
  }
  // Exact for a target that stands still meanwhile.
  const double keep = std::exp(-rate * seconds);
  const double off = double{value} - double{target};
  const double pull = double{speed} + rate * off;
  value = static_cast<float>(double{target} + (off + pull * seconds) * keep);
  speed = static_cast<float>((double{speed} - rate * pull * seconds) * keep);
}

std::optional<Heard> SpokenMouth::tick(DeviceTime time) {
  // A frame after a gap begins anew.
  constexpr double kLongest_s = 0.5;
  const double seconds = last_ ? std::clamp(to_seconds(time - *last_), 0.0, kLongest_s) : 0;
  last_ = time;
  std::optional<Heard> heard = track_.at(time);
  if (!heard || !gate_.step(time, heard->voice)) {
    if (!heard) gate_.reset();
    weights_ = {};
    tongue_ = closure_ = {};
    return std::nullopt;
  }
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    weights_[k].step(heard->weights[k], rate_, seconds);
    heard->weights[k] = std::clamp(weights_[k].value, 0.0F, 1.0F);
  }
  tongue_.step(heard->tongue, rate_, seconds);
  closure_.step(heard->closure, rate_, seconds);
  heard->tongue = tongue_.value;
  heard->closure = closure_.value;
  return heard;
}

void SpokenMouth::reset() {
  track_.clear();
  gate_.reset();
  weights_ = {};
  tongue_ = closure_ = {};
  last_.reset();
}

}  // namespace mien::speech
