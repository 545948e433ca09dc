#pragma once

#include "app/json_output.h"
#include "app/live/session_message.h"
#include "mien/session/report.h"

// How a session's calibrations are told on a terminal, and to programs.
namespace mien::app {

/// A table on stdout: each score with its verdict and its sentence.
void print_scores(const session::CalibrationVersion& version);

/// A table on stdout: each version with its age, its origin, whether it is in force, and its worst score;
/// below it how well rotations are known, where they drift.
void print_versions(const SessionStatus& status);

/// A table on stdout: the scores of two versions beside each other, those that only one has too.
void print_comparison(const session::CalibrationVersion& a, const session::CalibrationVersion& b);

/// {"version", "origin", "made_s", "scores": [{"name", "value", "unit", "pass", "sentence"}], "passed"};
/// `passed` is null where nothing was judged.
[[nodiscard]] Json version_json(const session::CalibrationVersion& version);

/// {"state", "sigma_deg": number or null, "in_force": id or null, "versions": [version_json's, "in_force"]}.
[[nodiscard]] Json versions_json(const SessionStatus& status);

/// {"versions": [a, b], "scores": [{"name", "unit", "values": [a, b], "pass": [a, b]}]}; null where one has
/// no such score.
[[nodiscard]] Json comparison_json(const session::CalibrationVersion& a,
                                   const session::CalibrationVersion& b);

}  // namespace mien::app
