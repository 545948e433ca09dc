#include "mien/speech/listeners.h"

#include <algorithm>

namespace mien::speech {
namespace {

constexpr double kPhoneFrame_s = 0.01;

}  // namespace

Heard LearnedListener::push(DeviceTime time, const Block& block) {
  network_.step(mel_.push(block), mouth_);
  Heard heard;
  heard.time =
      time + kBlockDuration / 2 - kBlockDuration * static_cast<std::int64_t>(network_.file().look_ahead);
  heard.weights = mouth_.weights;
  heard.closure = std::min(1.0F, mouth_.closure / kClosed);
  close_lips(heard.closure, heard.weights);
  heard.voice = mouth_.voice;
  return heard;
}

void LearnedListener::reset() {
  mel_.reset();
  network_.reset();
}

Heard PhoneListener::push(DeviceTime time, const Block& block) {
  const std::span<const HeardPhone> phones = decoder_.push(block);
  ++blocks_;
  const double now_s = to_seconds(kBlockDuration) * static_cast<double>(blocks_);
  const double newest_s = now_s - to_seconds(kDelay);
  sounds_.clear();
  bool voice = false;
  for (const HeardPhone& phone : phones) {
    TimedSound sound{Visemes::standard().of_arpabet(phone.name()),
                     kPhoneFrame_s * static_cast<double>(phone.begin),
                     kPhoneFrame_s * static_cast<double>(phone.end)};
    // The newest one of what is being said goes on, as far as anybody knows.
    if (&phone == &phones.back() && phone.open) sound.end_s = std::max(sound.end_s, newest_s);
    voice = voice || (!sound.parts.empty() && sound.end_s > newest_s - to_seconds(kDelay));
    sounds_.push_back(sound);
  }
  const Mouth mouth = articulator_.at(newest_s, sounds_);
  return {.time = time + kBlockDuration - kDelay,
          .weights = mouth.weights,
          .tongue = mouth.tongue,
          .closure = mouth.closure,
          .voice = voice ? 1.0F : 0.0F};
}

void PhoneListener::reset() {
  decoder_.reset();
  blocks_ = 0;
}

}  // namespace mien::speech
