#pragma once

#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/synthetic/speech/spoken_passage.h"

namespace mien::lab {

/// When the lips meet in a recording, from the times of its phones: every P, B and M. Reads HTK's label files
/// (begin, end in 100 ns, label; of full-context labels the phone between "-" and "+") and the alignments of
/// SoundSwallower (nested objects of "b", "d" seconds, "t" text and "w" parts). Errors: malformed,
/// out_of_range (times that are not finite, negative, out of order, beyond an hour).
[[nodiscard]] Result<std::vector<synthetic::Closure>> parse_phone_labels(std::string_view text,
                                                                         std::string_view where);

}  // namespace mien::lab
