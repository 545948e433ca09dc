#pragma once

#include <cmath>
#include <numbers>

#include "mien/performer/speaker.h"

namespace mien::synthetic::test {

/// Says every letter for 80 ms, at 16 kHz: vowels as a tone each, P, B and M as silence, all else as a hiss.
inline performer::Speaker letter_speaker() {
  return [](const std::string& voice, const std::string& text, int) -> Result<performer::SpokenLine> {
    constexpr int kRate = 16'000, kLetter = 1'280;
    performer::SpokenLine line;
    line.utterance.language = "en";
    line.sound.rate_hz = kRate;
    Random random = Random(1).fork(voice);
    for (const char letter : text) {
      const bool blank = letter == ' ' || letter == '.' || letter == ',' || letter == '?';
      const bool closed = letter == 'p' || letter == 'b' || letter == 'm';
      const std::size_t vowel = std::string_view("aeiou").find(letter);
      const double begin_s = line.sound.duration_s();
      for (int i = 0; i < kLetter; ++i) {
        const double t = static_cast<double>(i) / kRate;
        double sample = 0;
        if (vowel != std::string_view::npos)
          sample = 0.3 * std::sin(2 * std::numbers::pi * (200 + 150 * static_cast<double>(vowel)) * t);
        else if (!blank && !closed)
          sample = 0.03 * random.normal();
        line.sound.samples.push_back(static_cast<float>(sample));
      }
      if (static_cast<unsigned char>(letter) < 0x80)
        line.utterance.phonemes.push_back(
            {blank ? "" : std::string(1, letter), begin_s, line.sound.duration_s()});
    }
    line.utterance.duration_s = line.sound.duration_s();
    return line;
  };
}

}  // namespace mien::synthetic::test
