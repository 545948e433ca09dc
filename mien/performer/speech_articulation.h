#pragma once

#include "mien/performer/canvas.h"
#include "mien/performer/speech.h"
#include "mien/performer/style.h"

namespace mien::performer {

/// Manner of speech.
struct Manner {
  double loudness = 1;      ///< Scales jaw opening; around 1. Raising: larger.
  double articulation = 1;  ///< Scales how fully lips reach their targets; around 1. Lowering: mumbling.
  double prosody = 1;       ///< Scales brow and head accents; around 1. Raising: livelier.
};

/// Adds an utterance from the canvas's start: lips, jaw, tongue, closure, brow and head accents, and its
/// pauses as cues for blinks. Coarticulation: Cohen and Massaro 1993.
void perform_speech(Canvas& canvas, const Utterance& utterance, const Manner& manner, const Style& style,
                    Random random);

}  // namespace mien::performer
