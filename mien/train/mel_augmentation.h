#pragma once

#include <span>

#include "mien/core/random.h"
#include "mien/speech/log_mel.h"

namespace mien::train {

/// What a window of log-mel frames would be through another throat, room and microphone, with other sounds
/// about: all of it in the bands' powers, so that a window costs well under a millisecond. In order: a tract
/// that is longer or shorter (bands stretched by up to 14 %), an equaliser and a tilt, reflections of a room,
/// other sounds 3 to 40 dB below (in three windows of four), a gain of -30 to 20 dB, and in one of five the
/// band of a telephone. Each is drawn anew for every window.
/// `frames`: kMelBands numbers each, natural logarithms; `other`: as many of what is about, at any level, or
/// empty.
void augment_mel(std::span<float> frames, std::span<const float> other, Random& random);

}  // namespace mien::train
