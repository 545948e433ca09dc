#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/headset/answer.h"
#include "mien/sensor/calibration.h"

namespace mien::headset {

/// What a network answers of a wearer who looks ahead with a relaxed face: an answer is read against this.
struct NeutralFace {
  /// What a weight can be at rest at most. Where the network takes a face at rest for more, what it says is
  /// hardly worth a stretch: raising would let a tenth of a shape look like half of it.
  static constexpr float kMostAtRest = 0.6F;
  static constexpr float kLeastOpenness = 0.3F;

  std::vector<std::string> cameras;     ///< Of the rig, by name.
  face::BlendshapeWeights weights;      ///< 0 to kMostAtRest.
  float tongue_out = 0;                 ///< The same.
  std::array<float, 4> gaze_rad{};      ///< As Answer::gaze_rad.
  std::array<float, 2> openness{1, 1};  ///< kLeastOpenness to 1.5.
  std::vector<sensor::Score> scores;
  bool operator==(const NeutralFace&) const = default;

  /// The answer as the wearer means it: of each weight the way from rest to 1, gaze less its own at rest,
  /// openness as a share of that at rest, to 1.5.
  void correct(Answer& answer) const;
};

/// JSON; parse_neutral_face takes it back. Errors: malformed, out_of_range.
[[nodiscard]] std::string write_neutral_face(const NeutralFace& neutral);
[[nodiscard]] Result<NeutralFace> parse_neutral_face(std::string_view json, const std::string& where);

/// Gathers answers while a wearer holds still. No allocation in add(). A pure function of the calls.
class NeutralMaker {
 public:
  void begin() { *this = {}; }
  void add(const Answer& answer);
  /// How many were added.
  [[nodiscard]] std::size_t frames() const { return frames_; }
  /// Their mean, judged. There are some.
  [[nodiscard]] NeutralFace make(std::vector<std::string> cameras) const;

 private:
  std::size_t frames_ = 0;
  std::array<double, kAnswerOutputs> sum_{};
  std::array<double, kAnswerOutputs> squares_{};
};

}  // namespace mien::headset
