#pragma once

#include <string>
#include <vector>

namespace mien::sensor {

/// One judged property of a calibration, as a person reads it. Every modality judges its own calibrations in
/// this form, so that the page and the reports show them alike.
struct Score {
  std::string name;      ///< "nod", "heading zygomaticus_upper_L".
  double value = 0;      ///< What was measured; finite.
  std::string unit;      ///< "deg", "dps", "" for a share in [0, 1].
  bool pass = false;     ///< False: the step should be done again.
  std::string sentence;  ///< What the value means, and what to do when it does not pass.
  bool operator==(const Score&) const = default;
};

/// True when none failed; an empty list has judged nothing and does not pass.
[[nodiscard]] inline bool all_pass(const std::vector<Score>& scores) {
  for (const Score& score : scores)
    if (!score.pass) return false;
  return !scores.empty();
}

}  // namespace mien::sensor
