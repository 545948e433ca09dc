#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include "mien/core/random.h"

namespace mien::synthetic {

/// Sounds that are no speech, made by code; none is a recording.
enum class OtherSound : std::uint8_t {
  white,     ///< White noise.
  pink,      ///< Noise of 3 dB less an octave, as of traffic.
  hum,       ///< Of the mains, with its harmonics, or of a fan.
  music,     ///< Chords and a tune of plucked and bowed tones, with beats of noise.
  keyboard,  ///< Clicks of keys, in bursts.
  breath,    ///< Air through mouth and nose, in and out.
  cough,     ///< Bursts of noise, now and then.
};
inline constexpr std::array<std::string_view, 7> kOtherSoundNames = {
    "white noise", "pink noise", "hum", "music", "keyboard", "breath", "cough"};

/// So many samples at speech::kRateHz, of about 0.1 RMS while it sounds, -1 to 1.
[[nodiscard]] std::vector<float> make_other_sound(OtherSound kind, std::size_t samples, Random random);

/// Adds `other` to `sound`, repeated if it is shorter, such that the sound's power in its loud tenths of a
/// second lies `snr_db` above the other's mean.
void mix_at(double snr_db, const std::vector<float>& other, std::vector<float>& sound);

/// A room: reflections that die away by 60 dB in `decay_s`, together `direct_db` below what comes directly.
void put_in_room(double decay_s, double direct_db, Random random, std::vector<float>& sound);

/// What a telephone or a poor microphone leaves: Butterworth filters of second order at both ends, Hz.
void limit_band(double low_hz, double high_hz, std::vector<float>& sound);

/// Root mean square.
[[nodiscard]] double rms_of(const std::vector<float>& sound);

}  // namespace mien::synthetic
