#pragma once

#include "mien/performer/canvas.h"
#include "mien/performer/speech.h"
#include "mien/performer/style.h"

namespace mien::performer {

/// How something is said.
struct Manner {
  double loudness = 1;      ///< Opening of the jaw; around 1.
  double articulation = 1;  ///< How fully lips reach their targets; around 1.
  double prosody = 1;       ///< Size of brow and head accents; around 1.
};

/// Adds an utterance that begins at the canvas's start: lips, jaw, tongue, closure, accents of brows and
/// head, and its pauses as places to blink.
void perform_speech(Canvas& canvas, const Utterance& utterance, const Manner& manner, const Style& style,
                    Random random);

}  // namespace mien::performer
