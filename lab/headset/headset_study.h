#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/face.h"
#include "mien/face/motion.h"
#include "mien/headset/headset_model.h"
#include "mien/sensor/rig.h"
#include "mien/solve/reliability.h"

namespace mien::lab {

/// Wearers whom nothing learnt from, each seen by a headset of their own, through the session's own tracker
/// after a neutral.
struct HeadsetStudyRequest {
  int wearers = 30;
  double seconds = 8;  ///< Of motion a wearer, after the neutral.
  std::uint64_t seed = 1;
  std::optional<face::Motion> motion;  ///< What everybody performs; none: a script of each one's own.
  /// The face that everybody has, with looks and a headset of their own; none: identities of the built-in
  /// one.
  std::optional<face::Face> face;
  unsigned threads = 0;  ///< 0: one a core.
};

/// How a take differs from one as worn.
enum class HeadsetCondition : std::uint8_t {
  as_worn,
  no_neutral,   ///< Nothing is known of the face at rest.
  put_on_anew,  ///< 4 mm and 4 degrees off where it was fitted, with a neutral of its own.
  slipped,      ///< The same without one: the neutral was taken before.
  slow,         ///< Cameras at 15 Hz.
  lossy,        ///< A tenth of the frames lost, in bursts.
  mouth_lost,   ///< The camera of the mouth's left half is missing.
  eye_lost,     ///< The left eye's is.
  hidden,       ///< From a third of the motion on by what training never saw (test_failures()).
  gaze_taught,  ///< As worn, after five targets were looked at (gaze_targets_motion()).
};
inline constexpr std::size_t kHeadsetConditions = 10;
[[nodiscard]] std::string_view condition_name(HeadsetCondition condition);

/// All wearers of one condition. Squared errors are of weights, means over frames and shapes.
struct HeadsetScore {
  HeadsetCondition condition = HeadsetCondition::as_worn;
  double mse = 0;
  double mean_pose_mse = 0;                                   ///< Of the model's mean answer.
  double left_eye_mse = 0, right_eye_mse = 0, mouth_mse = 0;  ///< Lids and brows of a side; mouth and jaw.
  double pve_mm = 0;
  double jitter_ratio = 0;  ///< Third difference of the landmarks over the truth's.
  std::optional<double> blink_f1;
  /// Frames whose eye is open less than a quarter of its rest. None of a face without landmarks.
  std::optional<double> closed_f1;
  /// measure::wink_f1: winks told from blinks. None where nobody winks, nor is said to.
  std::optional<double> wink_f1;
  /// Frames whose lips are less than EyesAndLipsMeter::kClosedLips_mm apart. None of a face without
  /// landmarks.
  std::optional<double> lips_f1;
  double gaze_median_deg = 0, gaze_p90_deg = 0;  ///< Of open eyes.
  /// Of the regions of the upper face (brows, eyes), of the lower face (cheeks, mouth, jaw), and of the eyes'
  /// directions: whether nothing hides it and the mean absolute error is at most 0.1 (of angles, rad).
  std::array<solve::Reliability, 3> reliability;
  std::array<solve::RocArea, 3> roc;
};

/// Errors: those of wearers and tracker; out_of_range (no wearers, no time); cancelled. The same on any
/// number of threads.
[[nodiscard]] Result<std::vector<HeadsetScore>> study_headset(
    const HeadsetStudyRequest& request, const sensor::Rig& rig,
    const std::shared_ptr<const headset::HeadsetModel>& model, const std::vector<float>& mean_answer,
    const Progress& progress);

/// Wearers unseen in training keep a headset on for hours after one neutral, and it slips as the rig's faults
/// say. Pictures are rendered in each ten minutes for two and a half seconds at rest and some of
/// motion.
struct HeadsetHoursRequest {
  int wearers = 2;
  double minutes = 180;  ///< 10 to 600.
  double seconds = 8;    ///< Of motion that is seen in each ten minutes, 1 to 60.
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
};

/// Ten minutes of one wearer. Squared errors are of weights, both sides clipped to [0, 1], means over frames
/// and shapes.
struct HeadsetHoursPiece {
  double begin_s = 0;
  double mse = 0;
  double still_mse = 0;      ///< Of the same motion in a headset that never slips.
  double recentred_mse = 0;  ///< As worn, re-centred by two seconds of rest in each piece.
  double mean_pose_mse = 0;  ///< Of the model's mean answer.
  /// `mse` over `still_mse`, divided by the same of the first piece; and that of `recentred_mse`.
  double ratio = 1, recentred_ratio = 1;
  /// The shape whose mean error differs most from that without slip, less the first piece's difference.
  std::size_t worst_shape = 0;
  double worst_bias = 0;  ///< Difference of absolute values.
};

/// By wearer and piece. `mean_answer`: as ViewsFile has it. Errors: out_of_range (nobody, no such minutes or
/// seconds), internal (a neutral or a rest that fails), those of wearers and tracker; cancelled. The same on
/// any number of threads. Memory: 2.2 MB a rendered second and thread.
[[nodiscard]] Result<std::vector<std::vector<HeadsetHoursPiece>>> study_headset_hours(
    const HeadsetHoursRequest& request, const sensor::Rig& rig,
    const std::shared_ptr<const headset::HeadsetModel>& model, const std::vector<float>& mean_answer,
    const Progress& progress);

}  // namespace mien::lab
