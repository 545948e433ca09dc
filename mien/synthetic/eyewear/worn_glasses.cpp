#include "mien/synthetic/eyewear/worn_glasses.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mien/core/time.h"
#include "mien/performer/canvas.h"
#include "mien/performer/mimic.h"

namespace mien::synthetic {
namespace {

using performer::pose_of;

constexpr double kPoseS = 3;
/// Light is traced once in so many pairs: 52 ms.
constexpr int kPairs = 12;
/// Nobody is neutral from the first moment on.
constexpr double kSettleS = 0.5;

std::vector<performer::Pose> range_poses() {
  return {pose_of({{"browInnerUp", 1.0F}, {"browOuterUp", 1.0F}}),
          pose_of({{"browDown", 1.0F}}),
          pose_of({{"eyeBlink", 1.0F}}),
          pose_of({{"eyeSquint", 1.0F}, {"cheekSquint", 1.0F}}),
          pose_of({{"noseSneer", 1.0F}, {"mouthUpperUp", 0.6F}}),
          pose_of({{"mouthSmile", 1.0F}, {"cheekSquint", 0.5F}}),
          pose_of({{"mouthFrown", 1.0F}, {"mouthShrugLower", 0.5F}}),
          pose_of({{"mouthPucker", 1.0F}}),
          pose_of({{"mouthStretch", 1.0F}}),
          pose_of({{"jawOpen", 0.5F}}),
          pose_of({{"jawOpen", 1.0F}}),
          pose_of({{"jawLeft", 1.0F}}),
          pose_of({{"jawRight", 1.0F}}),
          pose_of({{"cheekPuff", 1.0F}}),
          pose_of({{"mouthLeft", 1.0F}}),
          pose_of({{"mouthRight", 1.0F}})};
}

}  // namespace

face::Motion range_of_motion(const Random& random) {
  std::vector<performer::PoseCue> cues;
  for (const performer::Pose& pose : range_poses()) {
    performer::PoseCue& cue = cues.emplace_back();
    cue.begin_s = kPoseS * static_cast<double>(cues.size() - 1);
    for (const performer::PosePart& part : pose) cue.target[part.shape] = part.weight;
  }
  cues.push_back({kPoseS * static_cast<double>(cues.size()), {}});
  return performer::mimic(cues, kRangeS, {}, random);
}

WornGlasses::WornGlasses(virt::EyewearSimulator& simulator, const sensor::Rig& rig)
    : simulator_(&simulator), rig_(rig), lines_(rig.sensors.size(), rig.find(rig.reference)), grid_(rig) {}

void WornGlasses::play(const face::Motion& motion, double seconds, const See& see) {
  const face::MotionCurve curve(motion);
  const double window_s = kPairs * simulator_->pair_period_s();
  const auto frames = static_cast<std::int64_t>(std::llround(seconds * kFrameRateHz));
  std::int64_t frame = 0;
  const auto frame_s = [&] { return static_cast<double>(frame) / kFrameRateHz; };
  const auto look_until = [&](DeviceTime received) {
    for (; frame < frames && simulator_->clock().device(now_s_ + frame_s()) <= received; ++frame) {
      grid_.tick(simulator_->clock().device(now_s_ + frame_s()), lines_, light_);
      if (see) see(light_, curve.at(frame_s()).weights);
    }
  };
  const auto receive = [&](const std::vector<sensor::Sample>& samples) {
    for (const sensor::Sample& sample : samples) {
      look_until(sample.time);
      lines_.add(HostTime(sample.time.time_since_epoch()), sample);
      grid_.add(sample);
    }
  };
  std::vector<sensor::Sample> all;
  for (double at_s = 0; at_s < seconds; at_s += window_s) {
    const double end_s = std::min(at_s + window_s, seconds);
    const std::vector<sensor::Sample> samples =
        simulator_->play(now_s_ + at_s, kPairs, curve.at(at_s).weights, curve.at(end_s).weights);
    if (spoil_)
      all.insert(all.end(), samples.begin(), samples.end());
    else
      receive(samples);
  }
  if (spoil_) spoil_(all);
  receive(all);
  look_until(simulator_->clock().device(now_s_ + seconds));
  now_s_ += seconds;
}

eyewear::Normalisation WornGlasses::first_minute(const Random& random, const See& see) {
  eyewear::NormalisationMaker maker(rig_);
  maker.begin(eyewear::StretchKind::neutral);
  double since_s = 0;
  play(performer::mimic({}, kHoldS, {}, random.fork("hold")), kHoldS,
       [&](const eyewear::GridLight& light, const face::BlendshapeWeights& weights) {
         if ((since_s += 1 / kFrameRateHz) > kSettleS) maker.add(eyewear::StretchKind::neutral, light);
         if (see) see(light, weights);
       });
  maker.begin(eyewear::StretchKind::range);
  play(range_of_motion(random.fork("range")), kRangeS,
       [&](const eyewear::GridLight& light, const face::BlendshapeWeights& weights) {
         maker.add(eyewear::StretchKind::range, light);
         if (see) see(light, weights);
       });
  return maker.solve({});
}

eyewear::Normalisation WornGlasses::hold_neutral(const eyewear::Normalisation& before, const Random& random) {
  eyewear::NormalisationMaker maker(rig_);
  maker.begin(eyewear::StretchKind::neutral);
  play(performer::mimic({}, kRemountS, {}, random), kRemountS,
       [&](const eyewear::GridLight& light, const face::BlendshapeWeights&) {
         maker.add(eyewear::StretchKind::neutral, light);
       });
  return maker.solve(before);
}

}  // namespace mien::synthetic
