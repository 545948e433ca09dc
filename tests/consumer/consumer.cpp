#include <cstdio>

#include "mien/core/rotation.h"
#include "mien/core/sha256.h"
#include "mien/face/profile.h"

int main() {
  const mien::Quat q_h_s = mien::exp_rotation({0.0, 0.1, 0.0});
  mien::face::BlendshapeWeights weights;
  weights[mien::face::shape("jawOpen")] = 0.5F;
  const auto arkit = mien::face::arkit_from_ict(weights, 0.0F, true);
  mien::Sha256 hash;
  for (const float value : arkit.values) hash.add_value(value);
  std::printf("%.3f rad, %s\n", mien::log_rotation(q_h_s).y(), hash.hex().c_str());
  return arkit.values[mien::face::arkit_index("jawOpen")] == 0.5F ? 0 : 1;
}
