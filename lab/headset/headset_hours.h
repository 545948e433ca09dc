#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/headset/headset_model.h"
#include "mien/sensor/rig.h"

namespace mien::lab {

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
