#pragma once

#include <cmath>
#include <string>

#include "mien/core/random.h"
#include "mien/core/rotation.h"
#include "mien/dataset/dataset.h"
#include "mien/face/profile.h"
#include "mien/train/recipe.h"

namespace mien::train {

/// People whose first three weights move slowly and turn two sensors; the rest of the weights stay at their
/// rest. A network that learns anything beats the mean pose by far.
inline dataset::Dataset toy_data(std::uint32_t first_performer, std::size_t performers,
                                 std::size_t frames = 200) {
  dataset::Dataset dataset;
  dataset.sensors = {"mentalis", "buccinator_l"};
  for (std::size_t p = 0; p < performers; ++p)
    for (const bool lab : {true, false}) {
      Random random = Random(first_performer + p).fork("toy", lab ? 1 : 0);
      dataset::Sequence& s = dataset.sequences.emplace_back();
      s.performer = first_performer + static_cast<std::uint32_t>(p);
      s.lab = lab;
      s.frames = frames;
      const double phase = random.uniform(0, 6), speed = random.uniform(0.03, 0.08);
      for (std::size_t f = 0; f < frames; ++f) {
        const double t = phase + speed * static_cast<double>(f);
        const double w[3] = {0.5 + 0.5 * std::sin(t), 0.5 + 0.5 * std::sin(1.7 * t + 1),
                             0.5 + 0.5 * std::cos(0.6 * t)};
        for (std::size_t j = 0; j < face::kShapeCount; ++j)
          s.weights.push_back(j < 3 ? static_cast<float>(w[j]) : 0.05F);
        for (int sensor = 0; sensor < 2; ++sensor) {
          const Quat q =
              canonical(exp_rotation(Vec3(0.4 * w[0], 0.3 * w[1], 0.3 * w[2]) * (sensor == 0 ? 1.0 : -0.7)));
          for (int i = 0; i < 3; ++i) s.values.push_back(lab ? 0.0F : static_cast<float>(random.normal()));
          for (const double v : {q.w(), q.x(), q.y(), q.z()}) s.values.push_back(static_cast<float>(v));
        }
        for (const int flag : {1, 1, lab ? 0 : 1, lab ? 0 : 1})
          s.present.push_back(static_cast<std::uint8_t>(flag));
      }
    }
  return dataset;
}

/// A network small enough for tests: seconds, not hours.
inline std::string toy_recipe(std::size_t steps, const std::string& more = "") {
  return "seed = 3\n"
         "[network]\nlayers = 1\nd_model = 32\nheads = 1\nd_head = 32\nffn = 64\nwindow = 40\ndropout = 0.1\n"
         "[optimiser]\nlearning_rate = 2e-3\nbatch = 16\nwarm_up_steps = 10\nema = 0.98\nprecision = "
         "\"fp32\"\n"
         "[validation]\nwindows = 16\nevery_steps = 10\n"
         "[sampler]\nsteps = [1, 3]\nframes = 400\n"
         "[budget]\nsteps = " +
         std::to_string(steps) + "\n" + more;
}

/// The same for a causal network.
inline std::string toy_causal_recipe(std::size_t steps, const std::string& more = "") {
  return "seed = 3\n"
         "[network]\narchitecture = \"causal\"\nlayers = 2\nd_model = 32\nwindow = 40\ndropout = 0\n"
         "[optimiser]\nlearning_rate = 5e-3\nbatch = 16\nwarm_up_steps = 10\nema = 0.98\nloss = \"l2\"\n"
         "difference_weight = 2\nprecision = \"fp32\"\n"
         "[validation]\nwindows = 16\nevery_steps = 10\n"
         "[budget]\nsteps = " +
         std::to_string(steps) + "\n" + more;
}

}  // namespace mien::train
