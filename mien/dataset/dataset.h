#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mien/face/profile.h"
#include "mien/model/features.h"

namespace mien::dataset {

/// One performance as the network sees it. Arrays are frame-major, 60 frames a second.
struct Sequence {
  std::uint32_t performer = 0;
  /// Lab profile: rotations here are free of noise; the trainer adds 1 degree of white noise an axis anew
  /// each time.
  bool lab = false;
  bool from_take = false;  ///< Of a person's take, who wore real sensors; else of a virtual performer.
  std::size_t frames = 0;
  /// frames x 7n: acceleration xyz (m/s^2), then rotation wxyz, for each sensor, as model::SensorFeature.
  std::vector<float> values;
  /// frames x 2n: whether the rotation is there, a sensor each, then whether the acceleration is there; 0
  /// or 1.
  std::vector<std::uint8_t> present;
  /// 3n x 53: how the performer's skin turns under each sensor (model::Skin), of the shapes that a full
  /// prologue asks for; of the others how everybody's does. Empty: unknown.
  std::vector<float> slopes;
  std::vector<float> weights;  ///< frames x 53, the truth, in the ICT profile's order.
};

/// One more frame. `sensors`: as many as in its frames before. `weights`: held to 0 to 1.
void append_frame(std::span<const model::SensorFeature> sensors, const face::BlendshapeWeights& weights,
                  Sequence& out);

/// What a network is trained on or measured on.
struct Dataset {
  std::vector<std::string> sensors;  ///< Names of the n sensors, in the order of the values.
  std::vector<float>
      standard_slopes;  ///< 3n x 53: of the skin that everybody's is drawn around; may be empty.
  std::vector<Sequence> sequences;
};
struct TrainingData {
  Dataset train;
  Dataset validation;
};

}  // namespace mien::dataset
