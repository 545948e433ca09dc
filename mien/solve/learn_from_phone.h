#pragma once

#include <span>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/face.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"
#include "mien/phone/time_alignment.h"
#include "mien/solve/phone_truth.h"
#include "mien/take/take.h"
#include "mien/tracker/learn_correction.h"

namespace mien::solve {

/// What a phone taught of one wearer.
struct LearntFromPhone {
  phone::TimeAlignment alignment;
  tracker::LearntCorrection learnt;
};

/// Learns what a live model's answers lack for a take's wearer (tracker::learn_correction) from what a phone
/// told meanwhile, and stores it in `file` where it helps. `features`: what take_features() gave. `face`:
/// whose skin counts. Errors: the take's, phone_truth's and learn_correction's.
[[nodiscard]] Result<LearntFromPhone> learn_from_phone(const take::Take& take,
                                                       std::span<const model::FeatureFrame> features,
                                                       const PhoneTrack& track, const face::Face& face,
                                                       model::ModelFile& file, const Progress& progress);

}  // namespace mien::solve
