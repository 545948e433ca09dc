#include "mien/solve/learn_from_phone.h"

#include "mien/solve/trace_features.h"

namespace mien::solve {

Result<LearntFromPhone> learn_from_phone(const take::Take& take,
                                         std::span<const model::FeatureFrame> features,
                                         const PhoneTrack& track, const face::Face& face,
                                         model::ModelFile& file, const Progress& progress) {
  MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
  MIEN_TRY_ASSIGN(const PhoneTruth truth, phone_truth(events, features, track));
  LearntFromPhone lesson{.alignment = truth.alignment, .learnt = {}};
  MIEN_TRY_ASSIGN(lesson.learnt,
                  tracker::learn_correction(features, taught_by(truth), traced_sensor_names(take.rig()), face,
                                            file, progress));
  return lesson;
}

}  // namespace mien::solve
