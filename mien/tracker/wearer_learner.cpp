#include "mien/tracker/wearer_learner.h"

#include <utility>

#include "mien/tracker/personalise.h"
#include "mien/tracker/tracker.h"

namespace mien::tracker {
namespace {

std::string why_not(const Error& error) {
  if (error.code == ErrorCode::not_found)
    return "too few expressions were measured to learn your skin; check the sensors and calibrate again";
  return error.what;
}

WearerLearner::Learnt learn_wearer(const std::vector<model::FeatureFrame>& seen,
                                   const std::vector<PromptedExpression>& asked,
                                   const std::vector<std::string>& rig_sensors, model::ModelFile file) {
  WearerLearner::Learnt out;
  out.score = {.name = "wearer", .value = 0, .unit = "nats", .pass = false, .sentence = {}};
  const Result<Personalisation> learnt = personalise(seen, asked, rig_sensors, file);
  if (!learnt) {
    out.score.sentence = why_not(learnt.error());
    return out;
  }
  out.score.pass = true;
  if (learnt->taken) {
    out.score.value = learnt->surprise_before - learnt->surprise_after;
    out.score.sentence = "your skin was learnt, and foretells expressions better that it was not learnt from";
    out.slopes = std::move(file.skin->wearer);
  } else {
    out.score.sentence = "the standard skin fits you as well as what was learnt, and is in force";
    out.slopes = file.skin->standard;
  }
  for (float& slope : out.slopes) slope = static_cast<float>(model::in_millionths(slope));
  return out;
}

}  // namespace

void WearerLearner::expect(const PromptedExpression& asked) {
  asked_.push_back(asked);
}

void WearerLearner::cancel() {
  asked_.clear();
  seen_.clear();
  if (running_.valid()) abandoned_ = std::move(running_);
}

std::optional<WearerLearner::Learnt> WearerLearner::add(const model::FeatureFrame& features,
                                                        const model::ModelFile& file) {
  if (asked_.empty() || features.time < asked_.front().begin) return std::nullopt;
  const DeviceTime end = asked_.back().end;
  if (running_.valid()) {
    if (features.time < end + kWearerLearnt) return std::nullopt;
    Learnt learnt = running_.get();
    asked_.clear();
    return learnt;
  }
  if (features.time < end + from_seconds(kLatestAnswer_s)) {
    seen_.push_back(features);
    return std::nullopt;
  }
  model::ModelFile reduced;  // The part that personalise() reads.
  reduced.features = file.features;
  reduced.shapes = file.shapes;
  reduced.skin = file.skin;
  running_ = std::async(std::launch::async, learn_wearer, std::exchange(seen_, {}), asked_, rig_sensors_,
                        std::move(reduced));
  return std::nullopt;
}

}  // namespace mien::tracker
