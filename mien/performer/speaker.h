#pragma once

#include <functional>
#include <string>

#include "mien/core/error.h"
#include "mien/core/wav.h"
#include "mien/performer/speech.h"

namespace mien::performer {

/// A text as a machine reads it.
struct SpokenLine {
  Utterance utterance;  ///< What is said when; time 0 is the sound's first sample.
  Sound sound;
};

/// Has a text read by a voice as `mien-media speak` names them ("de+f3", "flite:slt"), at so many words a
/// minute. The same words give the same bits with the same voices installed. Thread-safe. Errors: those of
/// whatever speaks.
using Speaker = std::function<Result<SpokenLine>(const std::string& voice, const std::string& text,
                                                 int words_per_minute)>;

}  // namespace mien::performer
