#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mien/core/time.h"
#include "mien/face/profile.h"
#include "mien/session/consent.h"
#include "mien/take/take.h"

namespace mien::session {

/// A prompt that was shown to its end, as a take's event of the kind "prompt" tells of it. Texts are as they
/// stand there: whoever prints them makes them fit for it.
struct RecordedLine {
  DeviceTime begin, end;
  std::string name, text, block, emotion, language;  ///< As Prompt has them; empty: none.
  bool has_target = false;                           ///< A pose was asked for: `target`.
  face::BlendshapeWeights target;                    ///< 0 to 1.
  int attempt = 1;
  std::vector<std::string> poor;  ///< What was poor, a sentence each; empty: it is good.
};

/// What of a take is a dataset's: from its last consent on, until that was over. A take begins with its
/// session, and what was before is nobody's.
struct RecordedPart {
  Consent consent;
  DeviceTime begin;
  std::optional<DeviceTime> end;    ///< None: the take's end.
  std::vector<RecordedLine> lines;  ///< Of a block, that began in it, in the order in which they were over.
};

/// None: nobody consented.
[[nodiscard]] std::optional<RecordedPart> recorded_part(std::span<const take::Event> events);

/// Of several attempts at a line (one name) the one that counts: the last good one, else the last. In the
/// order in which names first came. Valid as long as the part.
[[nodiscard]] std::vector<const RecordedLine*> lines_that_count(const RecordedPart& part);

}  // namespace mien::session
