#include "mien/speech/heard_track.h"

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

}  // namespace mien::speech
