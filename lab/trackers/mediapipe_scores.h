#pragma once

#include <array>
#include <string>
#include <string_view>

#include "lab/trackers/tracker_curves.h"
#include "mien/core/error.h"

namespace mien::lab {

/// Columns that a table of scores may have for its time: seconds, then milliseconds.
inline constexpr std::array<std::string_view, 3> kScoreTimeColumns = {"time_s", "timestamp_ms",
                                                                      "timestampMs"};

/// MediaPipe's FaceLandmarker results as JSON Lines, one frame a line: a time (`timestamp_ms`, `timestampMs`
/// or `time_s`) and `face_blendshapes` or `faceBlendshapes`, a list of faces of which the first counts. A
/// face is a list of {category_name, score}, an object with such a list as `categories`, or an object of
/// names and scores; `categoryName` is taken too. An empty list, or null, is a gap. Other members are passed
/// over. Every frame with a face has the same names. Errors: truncated (no frame), malformed (a line that is
/// no such object, an unknown name, a name twice, other names than before, times that do not rise),
/// out_of_range (a line longer than kMaxTrackerLine, a score that is not finite or beyond kMostTrackerWeight,
/// too many rows). A malformed last line without a line end was cut short: it is left out, with a warning.
[[nodiscard]] Result<TrackerCurves> parse_mediapipe_lines(std::string_view text, const std::string& name);

/// A table of scores: a header with one column of time and columns named after shapes, commas between;
/// columns `frame` and `_neutral` are passed over. A row whose scores are all empty is a gap. Errors: as
/// above, and malformed (no column of time, or two, no shape, a row of another length).
[[nodiscard]] Result<TrackerCurves> parse_scores_csv(std::string_view text, const std::string& name);

/// The curves as such a table: time_s, then the told shapes by our names. What was written so comes back to
/// the bit.
[[nodiscard]] std::string format_scores_csv(const TrackerCurves& curves);

}  // namespace mien::lab
