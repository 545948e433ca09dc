#pragma once

#include <array>
#include <cstddef>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/headset/answer.h"
#include "mien/headset/moment_features.h"
#include "mien/sensor/calibration.h"

namespace mien::headset {

/// A wearer who looks ahead with a relaxed face: what a network finds there, which it reads later views
/// against, and what it still answers of that itself: all of it is taken off near rest, elsewhere what of it
/// is unusual.
struct NeutralFace {
  /// What a weight can be at rest at most. Where the network takes a face at rest for more, what it says is
  /// hardly worth a stretch: raising would let a tenth of a shape look like half of it.
  static constexpr float kMostAtRest = 0.6F;
  static constexpr float kLeastOpenness = 0.3F;
  /// Up to this much of an answer of a face at rest is usual, and taken off only near rest. A network leans
  /// towards its mean there, and not where the face moves: what is taken off at rest would be missing in
  /// motion. Raising: a face shows more of what is not there; lowering: a moving one less of what is. Chosen
  /// on wearers whom no page reports (docs/experiments/headset.md, "What is taken off at rest").
  static constexpr float kUsualAtRest = 0.1F;
  static constexpr float kUsualGaze_rad = 3 * std::numbers::pi_v<float> / 180;
  /// How near to rest that is: the root mean square of the weights' distance from those at rest, at which 1/e
  /// of the usual part is taken off; with the distance that falls as a normal density does. Raising: small
  /// expressions lose what the face at rest is taken for; lowering: a face at rest shows it once it trembles.
  static constexpr float kNearRest = 0.05F;

  std::vector<std::string> cameras;     ///< Of the rig, by name.
  face::BlendshapeWeights weights;      ///< 0 to kMostAtRest.
  float tongue_out = 0;                 ///< The same.
  std::array<float, 4> gaze_rad{};      ///< As Answer::gaze_rad.
  std::array<float, 2> openness{1, 1};  ///< kLeastOpenness to 1.5.
  RestFeatures rest;
  std::string network;  ///< HeadsetModel::hash() of what found them.
  std::vector<sensor::Score> scores;
  bool operator==(const NeutralFace&) const = default;

  /// The answer as the wearer means it: of each weight the way to 1 from what of it is unusual at rest, and
  /// near rest from all that it is there; gaze less the same; openness as a share of that at rest, to 1.5.
  void correct(Answer& answer) const;
  /// What it corrects by: the answer of the face at rest, each held to what it can be.
  void correct_by(const Answer& at_rest);
};

/// JSON; parse_neutral_face takes it back. Errors: malformed, out_of_range.
[[nodiscard]] std::string write_neutral_face(const NeutralFace& neutral);
[[nodiscard]] Result<NeutralFace> parse_neutral_face(std::string_view json, const std::string& where);

/// Gathers what is found, and what is answered of it, while a wearer holds still: in a calibration without a
/// face at rest, in a later rest against the one before. No allocation in add(). A pure function of the
/// calls.
class NeutralMaker {
 public:
  /// `features`: of each view.
  explicit NeutralMaker(std::size_t features) : features_(model::kViews * features) {}
  void begin();
  void add(const MomentFeatures& moment, const Answer& answer);
  /// How many were added.
  [[nodiscard]] std::size_t frames() const { return frames_; }
  /// How many of them had a view.
  [[nodiscard]] std::size_t frames_with(std::size_t view) const { return seen_[view]; }
  /// Of each view how old it was in the mean; 0 of one that was never there.
  [[nodiscard]] std::array<float, model::kViews> mean_age_s() const;
  /// Their mean, judged. There are some. Corrects by the mean answer. The first score is of how still the
  /// face was.
  [[nodiscard]] NeutralFace make(std::vector<std::string> cameras) const;

 private:
  std::size_t frames_ = 0;
  std::vector<double> features_;                   ///< Sums, as MomentFeatures has them.
  std::array<std::size_t, model::kViews> seen_{};  ///< Frames that have each view.
  std::array<double, model::kViews> ages_s_{};     ///< Sums over these.
  std::array<double, kAnswerOutputs> sum_{};
  std::array<double, kAnswerOutputs> squares_{};
};

}  // namespace mien::headset
