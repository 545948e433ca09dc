#include "lab/imu/placement/placement_rig.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

namespace mien::lab {

Result<sensor::Rig> rig_of(const std::vector<SensorCandidate>& candidates, const sensor::Rig& base,
                           const std::string& name) {
  const std::optional<std::uint16_t> head = base.head_sensor();
  if (!head)
    return fail(ErrorCode::not_found, "the rig has no sensor of the head to measure a face against",
                base.name, "use one such as rigs/default.toml");
  if (candidates.empty()) return fail(ErrorCode::bad_usage, "a rig needs at least one sensor on the face");
  sensor::Rig rig = sites_rig(candidates);
  rig.name = name;
  rig.sensors.push_back(base.sensors[*head]);
  rig.reference = rig.sensors.back().name;
  rig.faults_toml = base.faults_toml;
  for (std::size_t s = 0; s < rig.sensors.size(); ++s) {
    sensor::Mount& mount = rig.sensors[s];
    mount.device = fmt::format("02:4D:49:45:4E:{:02X}", s);
    if (mount.role == "face") mount.position_m = (1e4 * *mount.position_m).array().round() / 1e4;
  }
  return rig;
}

Result<sensor::Rig> worn_rig_of(const std::vector<SensorCandidate>& candidates, const sensor::Rig& base,
                                const std::string& name, const virt::SkinMotionRequest& skin,
                                const Progress& progress) {
  MIEN_TRY_ASSIGN(sensor::Rig rig, rig_of(candidates, base, name));
  MIEN_TRY_ASSIGN(rig.skin, virt::study_skin_motion(skin, rig, progress));
  return rig;
}

std::string placement_recipe() {
  return R"(# A live model for sensors at other places: as models/recipes/live.toml, with fewer people and less time.
seed = 1

[network]
architecture = "causal"
dropout = 0

[data]
seed = 1
performers = 800
validation_performers = 24
seconds = 24
device_seconds = 40
device_share = 0.3
identities = true
placement_mm = 3
kinematics_gain = 0.30
kinematics_deg = 13

[optimiser]
learning_rate = 3e-3
loss = "l2"
batch = 32
warm_up_steps = 200
ema = 0.998
difference_weight = 5

[augmentation]
sensor_loss = 0.05
many_lost = 0.1
acceleration_loss = 0.1
stretch_loss = 0.08
held_readings = 0.3
known_skin = 0.5
skin_gain_error = 0.08
skin_slope_error = 0.08

[validation]
windows = 400

[budget]
seconds = 900
)";
}

}  // namespace mien::lab
